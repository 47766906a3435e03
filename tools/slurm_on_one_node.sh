#!/bin/bash
# A whole SLURM on this machine, as root, without systemd, for as long as a command runs:
#   apt-get install --yes --no-install-recommends slurm-wlm munge
#   tools/slurm_on_one_node.sh ecs-eco sweep PLAN --on slurm
# Two partitions: `long` (the default), whose jobs are queued again when those of `urgent` want their places.
set -euo pipefail

place=$(mktemp --directory /tmp/slurm-XXXXXX)
host=$(hostname --short)
cpus=$(nproc)
memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)  # [MB]
cat > "$place/slurm.conf" <<END
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
StateSaveLocation=$place/state
SlurmdSpoolDir=$place/spool
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.pid
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=5,bf_interval=5
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
JobRequeue=1
KillWait=10
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=long Nodes=$host Default=YES PriorityTier=1 PreemptMode=REQUEUE MaxTime=INFINITE State=UP
PartitionName=urgent Nodes=$host PriorityTier=10 PreemptMode=OFF MaxTime=INFINITE State=UP
END
mkdir "$place/state" "$place/spool"
export SLURM_CONF=$place/slurm.conf

started=()
stop() {
    scancel --user="$(id --user --name)" 2>/dev/null || true
    sleep 2
    for process in "${started[@]}"; do kill "$process" 2>/dev/null || true; done
    wait
}
trap stop EXIT

if ! munge --no-input > /dev/null 2>&1; then
    install --directory --owner=munge --group=munge /run/munge
    runuser --user munge -- munged --foreground > /dev/null 2>&1 & started+=($!)
fi
until munge --no-input > /dev/null 2>&1; do sleep 0.2; done
slurmctld -D > /dev/null 2>&1 & started+=($!)
slurmd -D > /dev/null 2>&1 & started+=($!)
until [[ $(sinfo --noheader --partition=long --format=%t 2>/dev/null) == idle ]]; do sleep 0.5; done

"$@"
