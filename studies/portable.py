"""Does portable mode give the same bytes on every x86-64 machine, while native mode does not?

Every shipped world runs with learning, in separate processes, on this machine and on others: processors
emulated in qemu's user mode (a 2008 Nehalem without AVX; a 2013 Haswell with AVX2 and fused multiply-add),
and this machine with variables that make compilers and libraries assume a less capable processor, which
portable mode must ignore. One of these variables, GLIBC_TUNABLES, affects the C library, which no mode
controls. Kernels for "variables" are compiled into a separate cache. Native mode is the control.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from studies.common.study import Study, verdict

WORLDS = (
    "diel-migration",
    "happiness",
    "innate",
    "island",
    "lamb",
    "learning-krill",
    "predator-prey",
    "reflexes",
)
LESSER = {  # variables that make this processor appear less capable
    "NUMBA_CPU_NAME": "nehalem",
    "NUMBA_CPU_FEATURES": "",
    "ATEN_CPU_CAPABILITY": "default",
    "MKL_ENABLE_INSTRUCTIONS": "SSE4_2",
    "OPENBLAS_CORETYPE": "Prescott",
    "MKL_CBWR": "AUTO",
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-FMA4_Usable,-AVX2,-FMA,-FMA4",
}
QEMU = {
    "Nehalem": ["-cpu", "Nehalem"],
    "Haswell": ["-cpu", "Haswell,-pcid,-x2apic,-tsc-deadline,-hle,-invpcid,-rtm"],
}  # features that qemu lacks
CHILD = """
import json, sys
import ecs_eco
from ecs_eco.testing.self_test import Case, short_world
from ecs_eco.testing.target import target
world = short_world(Case(sys.argv[1], True), int(sys.argv[2]), int(sys.argv[3]))
digests = [world.digest()]
for _ in range(2):
    digests.append(world.run(int(sys.argv[4]) // 2).digest())
import llvmlite.binding as llvm
print(json.dumps({"digests": digests, "target": target().key, "processor": llvm.get_host_cpu_name(),
                  "organisms": sum(table.n for table in world.tables.values())}))
"""
CACHE = Path(tempfile.gettempdir()) / "ecs-eco-study-portable"


def run(config: dict, case: dict) -> dict:
    """Run one world on one machine in one mode."""
    where = case["machine"]
    command, variables = [], {}
    if where in QEMU:
        emulator = shutil.which("qemu-x86_64") or shutil.which("qemu-x86_64-static")
        if emulator is None:
            raise RuntimeError("qemu-x86_64 is missing: apt-get install qemu-user")
        command = [emulator, *QEMU[where]]
    elif where == "variables":
        variables = dict(LESSER)
    own = "variables" if where == "variables" and config["compile_anew"] else "here"
    variables |= {
        "ECS_ECO_PORTABLE": "1" if case["mode"] == "portable" else "0",
        "ECS_ECO_CACHE": str(CACHE / f"{case['mode']}-{own}"),
    }
    numbers = [str(config[key]) for key in ("seed", "horizon", "ticks")]
    done = subprocess.run(
        [*command, sys.executable, "-c", CHILD, case["world"], *numbers],
        check=False,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{case}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def summarise(entries: list[dict]) -> dict:
    """Compare each world's digests across machines."""
    digests: dict = {}
    for entry in entries:
        case = entry["case"]
        digests.setdefault(case["mode"], {}).setdefault(case["world"], {})[case["machine"]] = entry["result"][
            "digests"
        ]
    machines = sorted({entry["case"]["machine"] for entry in entries})
    rows, same, other, compared = [], 0, 0, 0
    for mode in ("portable", "native"):
        for world, on in sorted(digests.get(mode, {}).items()):
            equal = len({tuple(ticks) for ticks in on.values()}) == 1
            same += equal and mode == "portable"
            other += not equal and mode == "native"
            compared += mode == "portable"
            rows.append(
                [
                    mode,
                    world,
                    *(on[m][-1][:12] if m in on else "" for m in machines),
                    "same" if equal else "different",
                ]
            )
    # omitted in the short form, because kernels would have to be compiled two more times
    controls = len(digests.get("native", {}))
    changing = [w for w, on in digests["portable"].items() if len(set(next(iter(on.values())))) < 3]
    verdicts = [
        verdict(
            f"worlds with one digest on {len(machines)} machines in portable mode",
            same,
            f"all {compared}",
            same == compared,
        ),
        verdict(
            "worlds with different digests in native mode (control)",
            other,
            f"all {controls}",
            other == controls,
        ),
        verdict("worlds that did not change, so that nothing was compared", len(changing), "0", not changing),
    ]
    return {"verdicts": verdicts, "table": {"head": ["mode", "world", *machines, "digests"], "rows": rows}}


def _cases(worlds: tuple, machines: tuple) -> list[dict]:
    return [
        {"mode": mode, "world": world, "machine": machine}
        for world in worlds
        for mode, where in (("portable", machines), ("native", ("here", "variables")))
        for machine in where
    ]


STUDY = Study(
    name="portable",
    claim="Portable mode gives the same bytes on every x86-64 machine.",
    config={
        "seed": 1,
        "ticks": 24,
        "horizon": 8,
        "compile_anew": True,
        "variables": LESSER,
        "qemu": {name: " ".join(words) for name, words in QEMU.items()},
    },
    cases=_cases(WORLDS, ("here", "variables", "Nehalem", "Haswell")),
    run=run,
    summarise=summarise,
    short_cases=_cases(("reflexes",), ("here", "variables"))[:2],
    short_config={"ticks": 6, "horizon": 3, "compile_anew": False},
)

if __name__ == "__main__":
    STUDY.main()
