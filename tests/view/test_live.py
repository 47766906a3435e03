"""A living world to be watched: what it says of itself, and that watching changes nothing."""

import base64
import json
import struct

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Genome, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.view.live import Live
from tests.view.parks import SMALL, small, watched


@pytest.mark.parametrize("policies", ["random", "untrained"])
def test_a_watched_world_is_the_same_to_the_byte(policies):
    alone, seen = small(policies).run(15), small(policies)
    page = watched(seen, 15)
    assert page.ticks == list(range(16))
    assert seen.digest() == alone.digest()
    assert seen.before_tick == []


def test_what_the_user_calls_before_ticks_is_called_while_a_page_watches_and_stays():
    seen, ticks = small(), []
    seen.before_tick.append(lambda: ticks.append(seen.tick))
    watched(seen, 5)
    assert ticks[:5] == [0, 1, 2, 3, 4]
    assert len(seen.before_tick) == 1


def test_hello_says_who_lives_where():
    live = Live(small())
    hello = live.hello()
    assert hello["mode"] == "live"
    assert hello["size"] == [240.0, 240.0]
    assert [s["name"] for s in hello["species"]] == ["grass", "deer", "wolf"]
    assert [s["moves"] for s in hello["species"]] == [False, True, True]
    assert hello["colours"] == ["species", "energy", "happiness", "age", "family"]
    assert hello["terrain"] is None
    json.dumps(hello, allow_nan=False)
    assert live.counts() == {"grass": 300, "deer": 60, "wolf": 12}


def test_without_a_sun_there_are_no_days_and_the_light_is_ambient():
    live = Live(small())
    assert live.hello()["day"] is None
    live.world.ambient["light"] = 0.5
    assert struct.unpack_from("<2f", live.frame(1, "species"), 16) == pytest.approx((0.5, np.pi / 6))


@pytest.mark.parametrize(
    ("kind", "start", "light", "elevation"),
    [
        ("natural", 0.5, 1.0, 90),
        ("natural", 0.75, 0.0, 0),
        ("natural", 0.0, 0.0, -90),
        ("inverted", 0.0, 1.0, 90),
        ("inverted", 0.5, 0.0, -90),
    ],
)
def test_the_sun_stands_where_the_hour_says(kind, start, light, elevation):
    sun = {"kind": kind, "day": 100.0, "start": start}
    live = Live(
        World.from_config(
            load("predator-prey", SMALL | {"sun": sun}), seed=5, policies="random", record=False
        )
    )
    assert live.hello()["day"] == {"length": 100.0, "start": (start + 0.5 * (kind == "inverted")) % 1}
    assert struct.unpack_from("<2f", live.frame(1, "species"), 16) == pytest.approx(
        (light, np.radians(elevation)), abs=1e-6
    )
    live.world.tick += 50  # half a day later
    assert live.world.time == 50.0
    assert struct.unpack_from("<2f", live.frame(2, "species"), 16)[1] == pytest.approx(
        np.radians(-elevation), abs=1e-6
    )


def test_a_sun_that_never_moves_makes_no_days():
    live = Live(
        World.from_config(
            load("predator-prey", SMALL | {"sun": {"kind": "constant"}}), policies="random", record=False
        )
    )
    assert live.hello()["day"] is None
    light, elevation = struct.unpack_from("<2f", live.frame(1, "species"), 16)
    assert light == pytest.approx(1 / np.pi)  # the mean over a day at the equator
    assert np.sin(elevation) == pytest.approx(light)


def test_another_day_is_told_once_it_is_another():
    live = Live(
        World.from_config(
            load("predator-prey", SMALL | {"sun": {"day": 100.0, "start": 0.5}}),
            policies="random",
            record=False,
        )
    )
    live.handle({"kind": "act", "what": {"kind": "set", "set": {"sun.start": 0.0}}})
    live.world.run(1)
    assert live.hello()["day"] == {"length": 100.0, "start": 0.0}


def test_the_ground_is_sent_with_its_landmarks_and_large_ones_coarser():
    ground = {
        "cell": 0.5,
        "hills": {"amplitude": 3.0, "scale": 30.0},
        "rocks": [{"at": [10.0, 10.0], "radius": 2.0}],
    }
    live = Live(
        World.from_config(load("predator-prey", SMALL | {"terrain": ground}), policies="random", record=False)
    )
    hello = live.hello()
    terrain = hello["terrain"]
    heights = np.frombuffer(base64.b64decode(terrain["heights"]), "<f4").reshape(terrain["ny"], terrain["nx"])
    assert heights.size <= 65_536
    assert terrain["cell"] * terrain["nx"] == pytest.approx(240)
    assert 1 < np.abs(heights).max() < 20
    assert terrain["rocks"][0]["radius"] == 2.0
    assert hello["objects"] == []  # a rock of the ground is no object that comes with every frame


def test_a_frame_has_all_that_live_at_their_places():
    world = small()
    live = Live(world)
    world.run(3)
    frame = live.frame(1, "energy")
    counts = struct.unpack_from("<3I", frame, 28)
    assert counts == tuple(live.counts().values())
    at = 40 + 12 * counts[0]
    x, _, _, _, value, uid = struct.unpack_from("<HHHBBI", frame, at)
    table, row = world.locate(uid)
    assert table.name == "deer"
    assert x == pytest.approx(table[Position].x[row] / 240 * 65535, abs=0.6)
    energy = table[Metabolism].energy[row] / world.config.species["deer"].metabolism.energy_max
    assert value == pytest.approx(1 + 254 * min(energy, 1), abs=0.6)
    assert live.scales("energy")["deer"] == (0.0, 1.0)
    assert live.scales("age") == {}


def test_genes_have_colours_and_curves():
    world = World.from_config("reflexes", policies="random", record=False)
    live = Live(world)
    genes = [c for c in live.hello()["colours"] if c.startswith("gene:")]
    assert genes
    name, code = next((n, next(iter(codes.values()))) for n, codes in live.genes.items() if codes)
    live.frame(1, f"gene:{code.name}")
    assert live.scales(f"gene:{code.name}")[name] == pytest.approx((code.low, code.high))
    live.sample()
    mean = live.series(-1)["genes"][f"{name}.{code.name}"][0]
    table = world.tables[name]
    decoded = table.species.heredity.layout.decode(table[Genome].loci[table.rows()], [code.name])[code.name]
    assert mean == pytest.approx(float(decoded.mean()), rel=1e-4)


def test_a_world_made_by_hand_can_be_watched():
    world = World([10.0, 10.0])
    world.add_table("mite", Position, Metabolism)
    world.spawn("mite", Position(x=5.0, y=2.0), n=3)
    world.flush()
    page = watched(world, 2)
    assert struct.unpack_from("<I", page.frames[0], 28) == (3,)
    assert page.got("params") == [{"kind": "params", "list": [], "knobs": []}]
    (answer,) = Live(world).handle({"kind": "act", "what": {"kind": "cull", "species": "mite", "count": 1}})
    assert "has no system Intervene" in answer["text"]


def test_roads_and_the_areas_in_which_land_is_used_are_told_as_they_come_and_go():
    road = {"line": [[10.0, 20.0], [60.0, 20.0]], "width": 4.0, "pace": 2.0}
    use = {
        "kind": "harvest",
        "species": "deer",
        "region": [20.0, 20.0, 60.0, 80.0],
        "rate": 0.01,
        "at": 2,
        "until": 3,
    }
    config = load("predator-prey", SMALL | {"terrain": {"cell": 2.0, "roads": [road]}, "land_use": [use]})
    world = World.from_config(config, policies="random", record=False)
    live = Live(world)
    marks, story = live.greeting()
    assert story["kind"] == "story"
    assert marks["roads"] == [{"line": road["line"], "width": 4.0}]
    assert (marks["areas"], marks["fences"], live.news()) == ([], [], [])
    border = [[20.0, 20.0], [60.0, 20.0], [60.0, 80.0], [20.0, 80.0], [20.0, 20.0]]
    told = []
    for _ in range(5):
        world.run(1)
        told += [(world.tick, message["areas"]) for message in live.news() if "areas" in message]
    assert told == [(2, [{"kind": "harvest", "border": border}]), (4, [])]
    world.intervene({"kind": "road", "remove": True})
    world.run(1)
    assert [message["roads"] for message in live.news() if "roads" in message] == [[]]


def test_nobody_has_felt_anything_before_the_first_tick():
    world = small()
    live = Live(world)
    for _ in range(2):
        live.sample()
        world.run(1)
    assert live.series(-1)["happiness"]["deer"][0] is None
    assert live.series(-1)["happiness"]["deer"][1] > 0


def test_a_watched_world_tells_births_and_deaths_and_why():
    world = World.from_config(load("predator-prey", SMALL), seed=5, policies="random")
    live = Live(world)
    for _ in range(30):
        live.passed()
        live.sample()
        world.run(1)
    live.sample()
    series = live.series(-1)
    deer, n = series["n"]["deer"], len(series["tick"])
    births, deaths = (series[kind]["deer"][1:] for kind in ("births", "deaths"))
    change = sum(b - d for b, d in zip(births, deaths, strict=True))
    assert deer[-1] - deer[0] == round(change)
    by_cause = [sum(line[i] or 0 for line in series["causes"]["deer"].values()) for i in range(1, n)]
    assert by_cause == deaths
    (why,) = live.handle({"kind": "why"})
    assert "What happened" in why["sections"]
    assert why["sections"]["What limited each species"]
    assert {"key", "value", "turn", "effect"} == set(why["turns"][0])
    json.dumps([why, live.hello(), live.greeting()], allow_nan=False)


def test_an_extinction_is_news_with_its_cause():
    world = small()
    live = Live(world)
    live.passed()
    live.news()
    world.intervene({"kind": "cull", "species": "wolf", "share": 1.0})
    world.run(2)
    live.passed()
    (story,) = [message for message in live.news() if message["kind"] == "story"]
    assert [(e["kind"], e["species"]) for e in story["entries"]] == [("extinct", "wolf")]
    assert "100% culled" in story["entries"][0]["cause"]
    assert not [message for message in live.news() if message["kind"] == "story"]


def test_what_a_watched_world_remembers_does_not_grow():
    world = World.from_config(load("predator-prey", SMALL), seed=5, policies="random")
    Live(world)
    recorder = world.recorder
    recorder.remembered = 2
    recorder.block = 5
    world.run(40)
    assert 10 <= recorder.series().num_rows // 3 <= 20


def test_real_land_stands_on_its_lowest_ground_and_is_painted_as_on_maps(tmp_path, monkeypatch):
    from ecs_eco import World
    from ecs_eco.view.scene import ground

    monkeypatch.chdir(tmp_path)
    np.savez("dem.npz", z=np.add.outer(np.zeros(30), np.linspace(500.0, 560.0, 40)))
    sent = ground(
        World.from_config(
            {
                "format": 1,
                "name": "real",
                "space": {"size": [400.0, 300.0], "edges": "walls"},
                "terrain": {"raster": "dem.npz", "cell": 10.0, "drainage": {"sea": 510.0}},
                "species": {"ox": {"count": 1, "body": {"radius": 1.0}}},
            }
        )
    )
    heights = np.frombuffer(base64.b64decode(sent["heights"]), "<f4").reshape(30, 40)
    assert heights.min() == 0
    assert heights.max() == pytest.approx(50)  # above the sea, which is at 510 m
    colours = np.frombuffer(base64.b64decode(sent["colours"]), np.uint8).reshape(30, 40, 3)
    red, _, blue = colours[15, 0].tolist()
    assert blue > red  # the sea
    assert colours[15, 20].min() > 150


def test_curves_say_what_each_species_took_in_and_burnt_in_the_last_tick():
    world = small()
    live = Live(world)
    world.run(4)
    live.sample()
    world.run(1)
    live.sample()
    deer = world.tables["deer"]
    series = live.series(-1)
    burnt = float(deer[Metabolism].burnt[deer.rows()].sum(dtype=np.float64))
    assert series["energy"]["deer"]["burnt"][-1] == pytest.approx(burnt, rel=1e-4)
    assert burnt > 0
    assert "grass" in series["energy"]


def test_genes_show_in_bodies_as_size_and_stripes():
    world = World.from_config("reflexes", policies="random", record=False)
    live, table = Live(world), world.tables["goat"]
    shows = {kind["name"]: kind.get("shows") for kind in live.hello()["species"]}
    assert shows == dict.fromkeys(("red", "yellow", "green")) | {
        "goat": {"grows": ("age", 100.0, 0.6), "stripes": ["red", 0.0, -1.0]}
    }
    frame = np.frombuffer(live.frame(1, "species"), "<u4")[7 + len(live.species) :].reshape(-1, 3)[-table.n :]
    codes = dict(zip(frame[:, 2].tolist(), (frame[:, 1] & 65535).tolist(), strict=True))
    rows = table.rows()
    red = table.species.heredity.layout.decode(table[Genome].loci[rows], ["red"])["red"]
    size = np.floor(1.5 + 2.54 * np.minimum(100.0, table[Biology].age[rows])).astype(int).tolist()
    assert codes == {
        uid: young + 256 * (1 if value == -1 else 255)
        for uid, value, young in zip(table.uid[rows].tolist(), red, size, strict=True)
    }
    assert len({code // 256 for code in codes.values()}) == 2
    fish = World.from_config("studies/data/silversides.toml", record=False)
    (kind,) = Live(fish).hello()["species"]
    assert kind["shows"] == {"size": ["size", pytest.approx(0.00585 / 0.0171), 1.0]}  # of the largest
