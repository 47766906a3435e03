"""A world with all of a life: eggs, kin, care, growth, fertility with age and season, genes for them."""

BIRD = {
    "count": 40,
    "max_count": 150,
    "sex": "random",
    "body": {"radius": 0.3, "mass": 1.0, "opaque": False},
    "metabolism": {"energy": 0.7, "energy_max": 1.0, "basal": 0.002, "photosynthesis": 0.012},
    "growth": {"rate": 0.05, "newborn": 0.1, "cost": 0.05, "reserve": 0.1, "pace": 0.2},
    "care": {"rate": 0.01, "reach": 3.0, "age_max": 20.0, "reserve": 0.3, "efficiency": 0.9, "by": "both"},
    "breeding": {"maturity": 4.0, "end": 200.0, "season": 0.25, "width": 0.2},
    "locomotion": {"speed": {"sit": 0.0, "walk": 0.6}, "cost": {"walk": 0.001}, "turn": 0.8},
    "sensors": [
        {"kind": "nearest", "target": "bird", "range": 8.0, "kin": kin}
        for kin in ("mother", "father", "siblings")
    ]
    + [{"kind": "property", "property": "energy", "of": ["bird", "egg"], "range": 6.0, "kin": "offspring"}],
    "actions": {"speed": ["sit", "walk"], "turn": ["left", "none", "right"], "nurse": ["nurse"]},
    "default_action": {"speed": "sit", "turn": "none"},
    "always_on": ["nurse"],
    "reflex": {"formulas": {"left": "bird_mother_left", "right": "-bird_mother_left"}},
    "happiness": {"weights": {"bird_mother_near": 1.0}, "minimum": 0.0},
    "policy": {"kind": "shared", "hidden": [4]},
    "reproduction": {
        "kind": "sexual",
        "energy_min": 0.5,
        "energy_given": 0.1,
        "litter": 3,
        "reach": 6.0,
        "gestation": 2.0,
        "rest": 5.0,
        "eggs": "egg",
    },
    "genome": {
        "genes": [
            {"name": "mass", "trait": "body.mass", "letters": 4, "low": 0.5, "high": 2.0},
            {"name": "season", "trait": "breeding.season", "letters": 4, "low": 0.0, "high": 0.9},
        ]
    },
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
}
EGG = {
    "count": 3,
    "body": {"radius": 0.05, "mass": 0.1, "opaque": False},
    "metabolism": {"energy": 0.1, "basal": 1e-4},
    "hatch": {"into": "bird", "incubation": 6.0, "temperature": 285.0},
}
RAT = {
    "count": 4,
    "body": {"radius": 0.3, "opaque": False},
    "metabolism": {"energy": 0.5},
    "diet": [{"eats": "egg", "efficiency": 0.5, "reach": 0.5}],
}
AVIARY = {
    "format": 1,
    "name": "aviary",
    "space": {"size": [25.0, 25.0]},
    "year": {"length": 60.0, "temperature": 5.0},
    "species": {"bird": BIRD, "egg": EGG, "rat": RAT},
}
