"""One sentence says who an organism is, what it sees and what it does."""

from ecs_eco.view.sentence import sentence

DEER = {
    "species": "deer",
    "alive": True,
    "age": 500.0,
    "energy": 0.3,
    "energy_max": 1.0,
    "nerves": None,
    "died": None,
}


def sees(**values):
    return [{"name": name, "value": value} for name, value in values.items()]


def act(group, name, probability=0.71, reflex=0, decision=1):
    return {"group": group, "name": name, "reflex": reflex, "probability": probability, "decision": decision}


def test_who_is_hungry_and_turns_to_its_food_is_said_so():
    nerves = {
        "sensors": sees(grass_forward=0.1, grass_left=0.6, grass_near=0.5),
        "actions": [act("speed", "walk", 0.5), act("turn", "left"), act("turn", "none", decision=0)],
    }
    said = sentence(DEER | {"nerves": nerves}, ["grass"], ["wolf"])
    assert said == (
        "Deer, 500 s old, hungry; saw grass (food) to the left; "
        "its policy chose to walk (50% chance) and turn left (71% chance)."
    )


def test_enemies_come_first_and_reflexes_are_told_from_the_policy():
    nerves = {
        "sensors": sees(grass_near=0.9, grass_forward=1.0, wolf_near=0.1, wolf_forward=-0.5, wolf_left=-0.5),
        "actions": [act("speed", "run", reflex=1), act("eat", "eat", None)],
    }
    said = sentence(DEER | {"nerves": nerves}, ["grass"], ["wolf"])
    assert "saw wolf (an enemy) behind to the right and grass (food) ahead" in said
    assert said.endswith("its reflex made it run; it always tries to eat.")


def test_how_far_they_are_is_said_where_the_range_is_known():
    sensors = sees(wolf_near=0.25, wolf_forward=1.0, grass_near=0.5, grass_left=1.0)
    channels = {"wolf_near": {"range": 12.0}}  # 0.25 is 1 − distance/range
    state = DEER | {"channels": channels, "nerves": {"sensors": sensors, "actions": []}}
    said = sentence(state, ["grass"], ["wolf"])
    assert "saw wolf (an enemy) 9.0 m ahead and grass (food) to the left" in said


def test_what_is_above_or_below_is_said_so():
    def where(**direction):
        sensors = sees(food_near=0.5, **{f"food_{way}": value for way, value in direction.items()})
        state = DEER | {"channels": {"food_near": {"target": "algae"}}}
        said = sentence(state | {"nerves": {"sensors": sensors, "actions": []}}, ["algae"])
        return said.partition("saw ")[2]

    assert where(forward=0.1, left=0.1, up=-0.99) == "algae (food) below."
    assert where(forward=0.7, left=0.1, up=0.7) == "algae (food) ahead and above."
    assert where(forward=-0.6, left=-0.5, up=-0.6) == "algae (food) behind to the right and below."
    assert where(forward=0.1, left=0.98, up=0.1) == "algae (food) to the left."


def test_the_dead_are_told_by_their_cause():
    dead = DEER | {"alive": False, "died": {"tick": 1420, "cause": "eaten by wolf", "killer": 7}}
    assert sentence(dead) == "Deer, eaten by wolf at tick 1,420 (killer: #7), 500 s old."
    old = dead | {"died": {"tick": 3, "cause": "too old", "killer": None}}
    assert sentence(old).startswith("Deer, died (too old) at tick 3")


def test_what_the_dead_saw_and_did_last_is_told_where_it_is_known():
    nerves = {"sensors": sees(wolf_near=0.9, wolf_forward=-1.0), "actions": [act("speed", "run")]}
    dead = DEER | {
        "alive": False,
        "nerves": nerves,
        "died": {"tick": 9, "cause": "eaten by wolf", "killer": 7},
    }
    assert sentence(dead, ["grass"], ["wolf"]) == (
        "Deer, eaten by wolf at tick 9 (killer: #7), 500 s old; in its last tick: saw wolf (an enemy) behind; "
        "its policy chose to run (71% chance)."
    )


def test_plants_and_those_without_energy_have_a_sentence_too():
    assert sentence(DEER | {"species": "grass", "age": None, "energy": None}) == "Grass."


def test_what_rays_hit_has_the_name_of_its_kind():
    nerves = {
        "sensors": sees(far_deer_near=0.5, far_deer_forward=1.0, far_wall_near=0.1, far_wall_forward=1.0),
        "actions": [],
    }
    said = sentence(DEER | {"species": "wolf", "nerves": nerves}, ["deer"], [])
    assert "saw deer (food) ahead and far_wall ahead" in said


def test_who_has_not_lived_a_tick_yet_is_just_born():
    assert sentence(DEER | {"age": 0.0, "nerves": None}).startswith("Deer, just born, ")


def test_of_several_targets_of_a_kind_the_nearest_is_named_and_one_at_the_same_point_has_no_direction():
    sensors = sees(grass_1_near=0.5, grass_1_left=1.0, grass_2_near=0.9, wolf_near=1.0)
    targets = {"grass_1_near": "grass", "grass_2_near": "grass", "wolf_near": "wolf"}
    channels = {name: {"target": target, "range": 4.0} for name, target in targets.items()}
    state = DEER | {"channels": channels, "nerves": {"sensors": sensors, "actions": []}}
    said = sentence(state, ["grass"], ["wolf"])
    assert said.endswith("saw wolf (an enemy) 0.0 m and grass (food) 0.4 m.")
