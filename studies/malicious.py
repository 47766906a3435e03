"""Loading a file or message never runs code: malicious worlds, checkpoints, manifests, recordings, policies,
journals, messages to the viewer, land data, and modules in a command's working folder.

Each input carries payloads that leave a mark (a file) if they ever run: names of code at every key that
accepts code, pickles in place of every file, texts that a shell, a template or TeX would run, and addresses
that a land data reader would request. Each input is checked, run, resumed, forked, repeated, reported, drawn,
searched, trained, compared or watched. In a control, the same payloads are run on purpose and must leave
their marks.
"""

from typing import Any

from studies.common.malicious import files, land, messages, surroundings, worlds
from studies.common.malicious.ground import KINDS, REFUSED, TRACEBACK, UNNAMED, ground, judged
from studies.common.study import Study, verdict

BY_HAND: dict[str, Any] = {
    "world": worlds.by_hand,
    "checkpoint": files.checkpoints,
    "manifest": files.manifests,
    "recording": files.recordings,
    "policy": files.policies,
    "journal": files.journals,
    "message": messages.by_hand,
    "folder": surroundings.folders,
    "land": land.by_hand,
    "module": surroundings.modules,
}
BY_MUTATION: dict[str, Any] = {
    "world": worlds.by_mutation,
    "checkpoint": files.checkpoints_by_mutation,
    "manifest": files.manifests_by_mutation,
    "journal": files.journals_by_mutation,
    "message": messages.by_mutation,
    "land": land.by_mutation,
}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Test the attacks of one kind, or the controls."""
    with ground() as place:
        if case["what"] == "control":
            imported = surroundings.imported(place)  # before any code is trusted
            return {"imported": imported, "controls": surroundings.controls(place)}
        if "seed" in case:
            number = case.get("number") or config["mutations"][case["what"]]
            attacks = BY_MUTATION[case["what"]](place, case["seed"], number)
        else:
            attacks = list(BY_HAND[case["what"]](place))[:: config["every"]]
        done = [judged(place, attack) for attack in attacks]
    return {
        "attacks": len(done),
        "attempts": sum(sum(d["counts"].values()) for d in done),
        "kinds": {kind: sum(d["counts"][kind] for d in done) for kind in KINDS},
        "failures": [
            d for d in done if d["marks"] or d["imported"] or d["counts"][UNNAMED] or d["counts"][TRACEBACK]
        ],
        "marks": sum(len(d["marks"]) for d in done),
        "imported": sorted({m for d in done for m in d["imported"]}),
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count marks and outcomes of attempts, by kind of attack."""
    tried = [c for c in cases if c["case"]["what"] != "control"]
    control = next(
        (c["result"] for c in cases if c["case"]["what"] == "control"), {"controls": [], "imported": {}}
    )

    def of(what: str, *kinds: str) -> int:
        results = [c["result"] for c in tried if what in (c["case"]["what"], "all")]
        return (
            sum(r["kinds"][k] for r in results for k in kinds)
            if kinds
            else sum(r["attacks"] for r in results)
        )

    marks, names = (
        sum(c["result"]["marks"] for c in tried),
        sorted({m for c in tried for m in c["result"]["imported"]}),
    )
    n, least = of("all"), 300 if len(cases) > 5 else 1
    loud = [c["label"] for c in control["controls"] if c["marked"]]
    more = [
        *control["imported"].get("beyond a harmless world", ["not measured"]),
        *control["imported"].get("in no installed package", []),
    ]
    ways = list(dict.fromkeys(c["case"]["what"] for c in tried))
    rows = [["files and messages", *map(of, ways), n]]
    rows += [[kind, *(of(way, kind) for way in ways), of("all", kind)] for kind in KINDS]
    return {
        "verdicts": [
            verdict("malicious files and messages", n, f"≥ {least}", n >= least),
            verdict(
                "of these, land files, handmade and mutated",
                of("land"),
                f"≥ {least // 3}",
                of("land") >= least // 3,
            ),
            verdict(
                f"of these, commands in a folder with {len(surroundings.NAMES)} modules",
                of("module"),
                "≥ 1",
                of("module") > 0,
            ),
            verdict("marks left by a payload or a request", marks, "0", marks == 0),
            verdict("payload modules that were imported", len(names), "0", not names),
            verdict(
                "controls, run deliberately, that left their mark",
                len(loud),
                f"all {len(control['controls'])}",
                len(loud) == len(control["controls"]) > 0,
            ),
            verdict(
                "modules that `check` imports for a world with code but not for a world without, "
                "or that belong to no installed package",
                more or "none",
                "none",
                not more,
            ),
            verdict("attempts that were refused by name", of("all", REFUSED), "≥ 1", of("all", REFUSED) > 0),
            verdict(
                "attempts that were refused without a name", of("all", UNNAMED), "0", of("all", UNNAMED) == 0
            ),
            verdict(
                "attempts that ended in a traceback", of("all", TRACEBACK), "0", of("all", TRACEBACK) == 0
            ),
        ],
        "table": {"head": ["outcome of attempts", *ways, "all"], "rows": rows},
    }


STUDY = Study(
    name="malicious",
    claim="No file or message that is loaded runs code: whatever names code is refused by name, or is "
    "harmless.",
    config={
        "mutations": {"world": 40, "checkpoint": 20, "manifest": 20, "journal": 10, "message": 50},
        "every": 1,
    },
    cases=[
        {"what": "control"},
        *({"what": what} for what in BY_HAND),
        *({"what": what, "seed": 1} for what in BY_MUTATION if what != "land"),
        {"what": "land", "seed": 1, "number": 100},
    ],
    run=run,
    summarise=summarise,
    short_cases=[
        {"what": "control"},
        {"what": "world", "seed": 1},
        {"what": "message", "seed": 1},
        {"what": "checkpoint", "seed": 1},
        {"what": "manifest", "seed": 1},
        {"what": "land"},
        {"what": "land", "seed": 1, "number": 5},
        {"what": "module"},
    ],
    short_config={
        "mutations": {"world": 3, "checkpoint": 2, "manifest": 3, "journal": 1, "message": 10},
        "every": 10,
    },
)

if __name__ == "__main__":
    STUDY.main()
