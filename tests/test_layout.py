"""The tests mirror the package: whoever looks for the tests of a room finds them under its name."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
BESIDE = {"benchmarks", "security", "studies", "tools"}  # what is tested besides the rooms


def folders(place):
    return {path.name for path in place.iterdir() if path.is_dir() and not path.name.startswith(("_", "."))}


def test_every_room_of_the_package_has_tests_under_its_name_and_nothing_else_has():
    assert folders(ROOT / "tests") - BESIDE == folders(ROOT / "ecs_eco")


def test_no_folder_of_tests_is_empty_and_no_test_lies_deeper_than_what_it_tests():
    for place in (ROOT / "tests").rglob("test_*.py"):
        room = place.parent.relative_to(ROOT / "tests")
        assert (room.parts[:1] in [(), *((name,) for name in BESIDE)]
                or (ROOT / "ecs_eco" / room).is_dir()), place
    for room in folders(ROOT / "ecs_eco"):
        assert any((ROOT / "tests" / room).rglob("test_*.py")), room
