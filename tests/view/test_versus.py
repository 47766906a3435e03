"""What differs by now, in a sentence."""

from ecs_eco.view.versus import differences, side

ANIMALS = ["deer", "wolf", "grass"]


def said(one, other, since=100, tick=520, ends=((), ())):
    entries = [[{"species": name, "kind": "extinct", "tick": at} for name, at in end] for end in ends]
    a, b = (
        side(dict(zip(ANIMALS, n, strict=True)), told, tick)
        for n, told in zip((one, other), entries, strict=True)
    )
    return differences(ANIMALS, a, b, since, tick)


def test_other_numbers_are_said_and_equal_ones_are_not():
    told = said((228, 12, 900), (310, 12, 905))
    assert told["text"] == "After 420 ticks: deer 310 instead of 228; grass 905 instead of 900."
    assert list(told["clauses"]) == ["deer", "grass"]


def test_who_lives_in_one_world_alone_comes_first_with_its_end():
    told = said((228, 0, 9), (310, 12, 9), ends=([("wolf", 180)], []))
    assert told["text"] == (
        "After 420 ticks: wolf died out at tick 180 in the original, 12 alive here; deer 310 instead of 228."
    )
    told = said((228, 1, 9), (228, 0, 9), ends=([], [("wolf", 180)]))
    assert told["text"] == "After 420 ticks: wolf died out at tick 180 here, 1 alive in the original."


def test_ends_at_other_ticks_differ_and_ends_that_are_to_come_are_not_told():
    told = said((5, 0, 9), (5, 0, 9), ends=([("wolf", 180)], [("wolf", 300)]))
    assert told["text"] == "After 420 ticks: wolf died out at tick 300 here and at tick 180 in the original."
    told = said((5, 7, 9), (5, 0, 9), ends=([("wolf", 900)], [("wolf", 520)]))
    assert told["clauses"]["wolf"] == "wolf died out at tick 520 here, 7 alive in the original"


def test_equal_numbers_and_one_tick():
    assert said((1, 2, 3), (1, 2, 3), 519)["text"] == "After 1 tick: the same numbers in both."


def test_two_worlds_that_have_nothing_in_common_are_called_first_and_second():
    told = said((228, 0, 9), (310, 12, 9), since=None)
    assert told["text"] == (
        "At tick 520: wolf absent in the first, 12 alive in the second; "
        "deer 228 in the first, 310 in the second."
    )


def test_of_many_species_the_farthest_apart_are_named_and_the_others_counted():
    names = [f"s{i}" for i in range(7)]
    one, other = (side({name: 100 + k * i for i, name in enumerate(names)}, [], 9) for k in (0, 1))
    told = differences(names, one, other, 0, 9)
    assert list(told["clauses"]) == ["s6", "s5", "s4", "s3"]
    assert told["text"].endswith("; other species that differ: 2.")


def test_species_that_one_of_them_alone_has_are_counted():
    one, other = side({"deer": 5, "wolf": 2}, [], 9), side({"deer": 7, "lamb": 1000, "ewe": 3}, [], 9)
    assert differences(["deer", "wolf"], one, other, None, 9)["text"] == (
        "At tick 9: deer 5 in the first, 7 in the second; only the first has 2 wolf; "
        "only the second has 1,000 lamb, 3 ewe."
    )
    assert differences(["wolf"], side({"wolf": 2}, [], 9), side({"ewe": 3}, [], 9), None, 9)["text"] == (
        "At tick 9: only the first has 2 wolf; only the second has 3 ewe."
    )
