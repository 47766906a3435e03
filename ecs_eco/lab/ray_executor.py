"""Ray as an executor: each call is a task with one CPU and one thread, and is repeated if its worker is lost.
It resumes from the checkpoint in its folder, which all machines must share."""

import os
import socket
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, Future, wait as wait_for
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import Any

from ecs_eco.engine.errors import listed, refusal
from ecs_eco.engine.processes import SAFE
from ecs_eco.lab.pool import ENDED, PATIENCE, PINS, Result, once_free

RETRIES = 20  # how often a task is repeated if its worker or machine is lost
ANSWER = 10.0  # [s] to wait for a cluster's answer
GRACE = 30.0  # [s] for calls to write their checkpoint after a request to stop
# prefixes of environment variables that may affect results
SETTINGS = ("ECS_ECO_", "NUMBA_", "NPY_DISABLE_", "MKL_", "ONEDNN_MAX_", "OPENBLAS_CORETYPE", "ATEN_CPU_")
LOCAL = "local"
OF_A_MACHINE = ("ECS_ECO_CACHE", "NUMBA_CACHE_DIR")


class WorkerLost(RuntimeError):
    """The workers of a call were lost repeatedly."""


class Imported(list[str]):
    """Module folders for Ray's workers: only those that this process uses, because Ray always adds the current
    folder, whose modules would shadow all other modules."""

    def extend(self, folders: Iterable[str]) -> None:
        own = {os.path.realpath(folder) for folder in sys.path}
        super().extend(folder for folder in folders if os.path.realpath(folder) in own)


class Call(Future[Any]):
    """The future of a task. Canceling it while it runs asks the task to stop, as Ctrl-C would."""

    def __init__(self, executor: "RayExecutor", reference: Any) -> None:
        super().__init__()
        self._executor, self.reference = executor, reference
        executor.calls.add(self)  # removed when the task has ended
        reference.future().add_done_callback(self._take)

    def cancel(self) -> bool:
        """Cancel the call, whether or not it is running; return False if it is done."""
        before, cancelled = self.cancelled(), super().cancel()
        if cancelled and not before:
            self._executor.ray.cancel(self.reference)
        return cancelled

    def _take(self, done: Future[Any]) -> None:
        self._executor.calls.discard(self)
        if not self.set_running_or_notify_cancel():
            return
        error = done.exception()
        if error is None:
            self.set_result(done.result())
        else:
            self.set_exception(_plain(error))


class RayExecutor(Executor):
    """Runs calls as tasks of a Ray cluster: the one at RAY_ADDRESS, one already running on this machine, or a
    temporary one started here with `workers` CPUs. Raises ConfigError without Ray or an answer."""

    def __init__(self, workers: int | None = None) -> None:
        self.ray = _ray()
        self._connected = not self.ray.is_initialized()
        if self._connected:
            _connect(self.ray, workers, os.environ.get("RAY_ADDRESS"))
        self.at_once = workers  # None: as many as the cluster can run
        self._options = {"num_cpus": 1, "max_retries": RETRIES, "runtime_env": {"env_vars": settings()}}
        self._task = self.ray.remote(**self._options)(_call)
        self.calls = set[Call]()
        self._open = True

    @property
    def workers(self) -> int:
        return self.at_once or max(1, int(self.ray.cluster_resources().get("CPU", 1)))

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        if not self._open:
            raise RuntimeError("cannot schedule new futures after shutdown")
        return Call(self, self._task.remote(fn, args, kwargs))

    def on_each_machine(self, folder: Path, fn: Callable[..., Any], /, *args: Any) -> None:
        """Call a function once on each machine of the cluster, in parallel, and wait. Raises the function's
        exceptions, and a ConfigError that names the machines that do not have the folder."""
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy as At

        machines = {
            node["NodeManagerHostname"]: node["NodeID"]
            for node in self.ray.nodes()
            if node["Alive"] and node["Resources"].get("CPU")
        }
        there = self.ray.remote(**self._options)(_prepare)
        asked = [
            there.options(scheduling_strategy=At(node, soft=True)).remote(str(folder), fn, args)
            for node in machines.values()
        ]
        try:
            without = sorted({name for name in self.ray.get(asked) if name})
        except BaseException as error:
            _, rest = self.ray.wait(asked, num_returns=len(asked), timeout=0, fetch_local=False)
            for reference in rest:  # canceling a task that has just ended can end this process (Ray 2.60)
                self.ray.cancel(reference)
            raise _plain(error) from None
        if without:
            fault = f"does not exist on {listed(without)}"
            allowed = "a folder that all machines of the cluster share"
            raise refusal((), fault, str(folder), allowed, source="--out")

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Disconnect from the cluster once all calls are done, and stop it if it was started here."""
        self._open = False
        calls = tuple(self.calls)
        for call in calls if cancel_futures else ():
            call.cancel()
        if wait:
            self._leave(calls)
        else:
            Thread(target=self._leave, args=(calls,), daemon=True).start()

    def terminate(self) -> None:
        """Ask all calls to stop after writing a last checkpoint. `submit` can be called again afterward."""
        stopped = [call.reference for call in tuple(self.calls) if call.cancel()]
        if stopped:
            _, late = self.ray.wait(stopped, num_returns=len(stopped), timeout=GRACE, fetch_local=False)
            for reference in late:
                self.ray.cancel(reference, force=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is not None:
            self.terminate()
        self.shutdown()

    def _leave(self, calls: Sequence[Call]) -> None:
        """Wait for calls, then end the connection and any cluster started here."""
        wait_for(calls)
        if self._connected and self.ray.is_initialized():
            self.ray.shutdown()
        self._connected = False


def settings() -> dict[str, str]:
    """Return the environment of tasks: one thread, no modules from their folder, this process's settings."""
    return {
        name: value
        for name, value in os.environ.items()
        if name.startswith(SETTINGS) and name not in OF_A_MACHINE
    } | dict.fromkeys((*PINS, SAFE), "1")


def _ray() -> Any:
    """Return the ray module. Raises ConfigError if it is not installed."""
    try:
        import ray
    except ImportError:
        allowed = 'local, or ray after: pip install -e ".[ray]" in the source folder'
        raise refusal((), "Ray is not installed", "ray", allowed, source="--on") from None
    return ray


def _connect(ray: Any, workers: int | None, address: str | None) -> None:
    """Connect to a cluster; start one on this machine if none is named and none is running."""
    job = ray.job_config.JobConfig()
    job._py_driver_sys_path = Imported()
    quiet = {"log_to_driver": False, "logging_level": "ERROR", "job_config": job}
    if address is not None and address.startswith("ray://"):
        allowed = "HOST:PORT on a machine of the cluster, or `ray job submit` elsewhere"
        raise refusal(
            (), "is for Ray's client, which ends with the connection", address, allowed, source="RAY_ADDRESS"
        )
    try:
        if address != LOCAL:
            _knock(address)
            ray.init(address=address or "auto", **quiet)
            return
    except (OSError, RuntimeError, ValueError) as error:
        if address is not None:
            why = getattr(error, "strerror", None) or str(error).splitlines()[0]
            allowed = "the address printed by `ray start --head`, or none for a cluster on this machine"
            raise refusal(
                (), f"no Ray cluster answers there: {why}", address, allowed, source="RAY_ADDRESS"
            ) from None
    ray.init(address=LOCAL, num_cpus=workers or os.cpu_count(), include_dashboard=False, **quiet)


def _knock(address: str | None) -> None:
    """Raise OSError if no server listens at HOST:PORT, because Ray would keep trying for minutes."""
    host, _, port = (address or "").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host.strip("[]"), int(port)), timeout=ANSWER).close()


def _call(fn: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
    try:
        return once_free(lambda: fn(*args, **kwargs), PATIENCE)
    except KeyboardInterrupt:
        import ray

        if ray.get_runtime_context().is_canceled():
            raise
        os._exit(ENDED)  # only this worker is asked to end; the call is repeated elsewhere


def _prepare(folder: str, fn: Callable[..., Any], args: Sequence[Any]) -> str:
    """Call a function on a machine; if the machine does not have the folder, return the machine's name instead."""
    if not os.path.isdir(folder):
        return socket.gethostname()
    fn(*args)
    return ""


def _plain(error: BaseException) -> BaseException:
    """Return the original exception of a call, without Ray's wrapper."""
    from ray import exceptions

    if isinstance(error, exceptions.RayTaskError):
        cause = error.cause
        return cause if isinstance(cause, BaseException) else RuntimeError(str(error))
    if isinstance(error, exceptions.TaskCancelledError):
        return WorkerLost("was canceled in the cluster")
    lost = (
        exceptions.WorkerCrashedError,
        exceptions.NodeDiedError,
        exceptions.OutOfMemoryError,
        exceptions.LocalRayletDiedError,
    )
    if isinstance(error, lost):
        return WorkerLost(
            f"its worker was lost {RETRIES + 1} times (out of memory?): {str(error).splitlines()[0]}"
        )
    return error
