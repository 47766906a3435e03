"""ecs-eco watch and run --watch, as somebody types them."""

import json
import signal
import socket
import struct
import subprocess
import sys
from contextlib import contextmanager

import pytest
from typer.testing import CliRunner
from websockets.sync.client import connect

from ecs_eco.cli import app
from ecs_eco.testing.browser import entered, served
from ecs_eco.view.guard import SUBPROTOCOL

SMALL = [
    "--set",
    "species.grass.count=300",
    "--set",
    "species.deer.count=60",
    "--set",
    "species.wolf.count=12",
]


@contextmanager
def page(address):
    host, credential = entered(address)
    with connect(
        f"ws://{host}/ws",
        origin=f"http://{host}",
        subprotocols=[SUBPROTOCOL, credential],
        compression=None,
        max_size=None,
    ) as ws:
        yield ws


def receive(ws, kind):
    while True:
        message = ws.recv(180)  # kernels may have to be compiled first
        if isinstance(message, bytes):
            ws.send(json.dumps({"kind": "ack", "frame": struct.unpack_from("<I", message, 4)[0]}))
            if kind == "frame":
                return message
        elif (content := json.loads(message))["kind"] == kind:
            return content


@pytest.mark.slow
def test_a_recorded_run_is_watched_acted_upon_stopped_while_it_stands_still_and_repeated(tmp_path):
    out = tmp_path / "run"
    words = [
        "run",
        "predator-prey",
        *SMALL,
        "--ticks",
        "1000000",
        "--policies",
        "random",
        "--out",
        str(out),
        "--watch",
    ]
    with served(*words) as run:
        with page(run.address()) as ws:
            assert receive(ws, "hello")["last"] == 1_000_000
            receive(ws, "frame")
            ws.send('{"kind": "pause"}')
            while (state := receive(ws, "state"))["playing"]:
                pass
            ws.send(json.dumps({"kind": "act", "what": {"kind": "cull", "species": "deer", "share": 0.5}}))
            assert receive(ws, "said")["text"] == f"tick {state['tick']}: cull 50% of deer"
            ws.send('{"kind": "step"}')
            assert receive(ws, "marks")["interventions"] == [
                {"tick": state["tick"], "text": "cull 50% of deer"}
            ]
            run.process.send_signal(signal.SIGINT)
            output = run.process.communicate(timeout=180)[1]
        assert run.process.returncode == 130, output
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["done"] == state["tick"] + 1
    assert [tick for tick, _ in manifest["intervened"]] == [state["tick"]]
    result = CliRunner().invoke(app, ["repeat", str(out), "--quiet"])
    assert result.exit_code == 0, result.output
    assert "the same result" in result.output


@pytest.mark.slow
def test_a_living_world_is_watched_until_ctrl_c():
    with served("watch", "predator-prey", *SMALL, "--policies", "random") as run:
        process = run.process
        with page(run.address()) as ws:
            assert receive(ws, "hello")["last"] is None
            assert struct.unpack_from("<I", receive(ws, "frame"), 8) == (0,)
            state = receive(ws, "state")
            assert (state["tick"], state["playing"]) == (0, False)  # it waits for a page to play it
            process.send_signal(signal.SIGINT)
            output = process.communicate(timeout=180)[1]
        assert process.returncode == 0, output
        assert "Traceback" not in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["predator-pray"], 'did you mean "predator-prey"?'),
        (["predator-prey", "--port", "70000"], "65535"),
        (["predator-prey", "--policies", "trainde"], "trained"),
        (["RUN", "--seed", "3"], "is a recorded run"),
        (["RUN", "--set", "seed=3"], "resume --from-tick"),
    ],
)
def test_what_cannot_be_watched_is_refused(words, message, tmp_path):
    (tmp_path / "manifest.json").write_text("{}")
    result = CliRunner().invoke(
        app, ["watch", *(str(tmp_path) if w == "RUN" else w for w in words), "--no-browser"]
    )
    assert result.exit_code == 2
    assert message in result.output


@pytest.mark.slow
def test_two_worlds_are_watched_beside_each_other_and_have_names_of_their_own():
    words = [*SMALL, "--policies", "random", "--seed", "2"]
    with served("watch", "predator-prey", "predator-prey", *words) as run, page(run.address()) as ws:
        first = receive(ws, "beside")
        assert first["names"] == ["predator-prey, the first", "predator-prey, the second"]
        assert (first["at"], first["hello"]["world"]) == (None, "predator-prey")
        while "state" not in first:
            first = receive(ws, "beside")
        assert "the same numbers in both" in first["state"]["text"]


def test_the_map_of_an_archipelago_has_nothing_beside_it(tmp_path):
    (tmp_path / "archipelago.json").write_text("{}")
    result = CliRunner().invoke(app, ["watch", "predator-prey", str(tmp_path), "--no-browser"])
    assert result.exit_code == 2
    assert "is an archipelago, which cannot be shown next to another world" in result.output


def test_a_taken_port_is_refused_before_anything_is_recorded(tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        for words in (
            ["watch", "predator-prey"],
            ["run", "predator-prey", "--watch", "--out", str(tmp_path / "run")],
        ):
            result = CliRunner().invoke(app, [*words, "--port", port, "--no-browser"])
            assert result.exit_code == 2
            assert f"--port: {port}" in result.output
    assert not (tmp_path / "run").exists()


def test_a_fork_is_not_repeated_from_its_start(tmp_path):
    config = {"space": {"size": [9.0, 9.0], "edges": "torus"}, "species": {"moss": {}}}
    manifest = {"format": 1, "config": config, "seed": 1, "ticks": 5, "forked": {"from": "runs/a"}}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    result = CliRunner().invoke(app, ["repeat", str(tmp_path)])
    assert result.exit_code == 2
    assert "is a fork of runs/a" in result.output


def test_help_and_the_package_load_no_server():
    code = (
        "import sys, ecs_eco, ecs_eco.cli.app; assert not {'uvicorn', 'starlette', 'websockets', "
        "'numba'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
