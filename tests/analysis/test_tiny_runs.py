"""Every reader of runs takes those in which hardly anything lives, and odd causes of death."""

import json
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from ecs_eco.analysis.why import write_why
from ecs_eco.cli.app import app
from ecs_eco.record import run_to_folder
from ecs_eco.view.replay import Replay

MOSS = {
    "count": 6,
    "body": {"radius": 0.1},
    "metabolism": {"energy": 1.0, "basal": 0.01},
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
}
STARVES = {"metabolism": {"energy": 1.0, "basal": 1.5}}
SIZE = {"name": "size", "letters": 2, "trait": "body.mass", "low": 0.5, "high": 1.0}
THINKS = {
    "sensors": [{"kind": "own", "property": "energy"}],
    "actions": {"speed": ["sit", "go"]},
    "locomotion": {"speed": {"sit": 0.0, "go": 0.5}},
    "happiness": {"formula": "energy", "minimum": -1.0},
    "policy": {"kind": "shared", "learn": True, "hidden": [4]},
    "ppo": {"horizon": 2},
    "genome": {"genes": [SIZE]},
}
CULL = [{"kind": "cull", "at": 0, "species": "moss", "share": 1.0}]
ODD = "\x01\x00\uffff$\\frac{<b>&\"'--a\n\tb老い \u202e%s {0}"
RUNS = {
    "nobody": ({"moss": MOSS | {"count": 0}}, {}),
    "all starve in the first tick": ({"moss": MOSS | STARVES | THINKS}, {}),
    "all are culled in the first tick": ({"moss": MOSS}, {"interventions": CULL}),
    "one for a tick": ({"moss": MOSS | THINKS | {"count": 1}}, {"ticks": 1}),
    "no tick": ({"moss": MOSS}, {"ticks": 0}),
    "eaters without food": (
        {"moss": MOSS | STARVES, "mite": MOSS | {"diet": [{"eats": "moss", "reach": 0.5, "gain": 0.1}]}},
        {},
    ),
    "odd causes": (
        {
            "moss": MOSS | {"lethal": [{"property": "age", "max": 2.0, "cause_above": ODD}]},
            "mite": MOSS | {"lethal": [{"property": "age", "max": 2.0, "cause_above": " "}]},
        },
        {"title": ODD},
    ),
}


@pytest.fixture(scope="module", params=RUNS)
def run(request, tmp_path_factory):
    species, more = RUNS[request.param]
    config = {
        "format": 1,
        "name": "bog",
        "ticks": 4,
        "space": {"size": [9.0, 9.0], "edges": "walls"},
        "species": species,
    } | more
    folder = tmp_path_factory.mktemp("run") / "run"
    run_to_folder(
        config | {"ticks": max(1, config["ticks"])},
        1,
        config["ticks"],
        folder,
        "untrained",
        record="full",
        snapshot_every=1,
        report=not config["ticks"],
    )
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("report",),
        ("why",),
        ("lineage", "--csv", "l.csv", "--newick", "l.nwk", "--living"),
        ("tracks", "t.csv"),
        ("tracks", "t.parquet", "--lines"),
    ],
    ids=" ".join,
)
def test_a_command_reads_it_or_says_in_a_sentence_why_not(run, monkeypatch, words):
    monkeypatch.chdir(run)
    result = CliRunner().invoke(app, [words[0], str(run), *words[1:]])
    assert isinstance(result.exception, SystemExit | None), result.exception
    lived = any((run / "series").glob("*.parquet"))
    if lived and not (words[0] == "lineage" and "contains no births" in result.output):
        assert result.exit_code == 0, result.output
    if lived and words[0] in ("report", "why"):
        for figure in (run / "figures").glob("*.svg"):
            ElementTree.fromstring(figure.read_text())
        assert not set((run / f"{words[0]}.html").read_text()) & set("\x00\x01\uffff")


def test_the_viewer_replays_it(run):
    if not any((run / "series").glob("*.parquet")):
        return
    replay = Replay(run)
    json.dumps([replay.hello(), *replay.greeting(), replay.series(-1)], allow_nan=False)
    for colour in replay.hello()["colours"]:
        assert replay.frame(0, colour)
    for kind in ("seek", "why"):
        json.dumps(replay.handle({"kind": kind, "tick": 0}), allow_nan=False)


def test_why_says_of_what_a_species_died_out_in_the_first_tick(tmp_path):
    species, _ = RUNS["eaters without food"]
    config = {"format": 1, "name": "bog", "ticks": 4, "space": {"size": [9.0, 9.0]}, "species": species}
    run_to_folder(config, 1, out=tmp_path / "run", report=False)
    happened = write_why(tmp_path / "run")["sentences"]["What happened"]
    assert happened[0] == "No species died out after the first tick in 4 ticks."
    assert "moss died out in the first tick: starved 100%." in happened
