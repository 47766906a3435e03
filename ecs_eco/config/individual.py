"""Which numbers of a species' section can be an organism's own, so that a gene may code for them; and which
cannot, each with its reason.

A new number of the schema belongs into one of the three tables (tests/config/test_individual.py says which
are missing). For OWN its system reads it through `ecs_eco.genomes.own_values`, and its kernel through
`ecs_eco.engine.per_row.of_row`. Patterns are dotted keys, with * for a name that the file chooses.
"""

from __future__ import annotations

OWN = frozenset({  # in a column of Traits, by its key
    "body.sinking", "defence.cost", "emits.*", "emits.*.rate", "happiness.minimum",
    "heat.specific_heat", "heat.conductance", "heat.metabolic_heat", "heat.regulate.set_point",
    "heat.regulate.warming", "heat.regulate.cooling", "heat.regulate.cost",
    "metabolism.energy_max", "metabolism.basal", "metabolism.digestion",
    "locomotion.speed.*", "locomotion.cost.*", "locomotion.turn", "locomotion.climb", "locomotion.pitch",
    "locomotion.drag",
    "diet.*.reach", "diet.*.chance", "diet.*.gain", "diet.*.efficiency", "diet.*.until",
    "diet.*.assimilation",
    "reproduction.rate", "reproduction.dispersal", "reproduction.spacing", "reproduction.father_share",
    "reproduction.reach", "reproduction.chance", "reproduction.gestation", "reproduction.rest",
    "reproduction.father_rest",
    "growth.rate", "growth.newborn", "growth.cost", "growth.reserve", "growth.pace",
    "growth.store",
    "care.rate", "care.until", "care.reach", "care.reserve", "care.efficiency",  # of the parent
    "reactions.*.energy", "reactions.*.rate", "reactions.*.half.*",
    "exchange.*.rate", "exchange.*.half", "exchange.*.until", "exchange.*.at.*", "exchange.*.above",
    "exchange.*.partition", "carries.*.reach", "carries.*.cost", "builds.*.cost", "builds.*.spacing",
    "lethal.*.min", "lethal.*.max",
    "sensors.*.scale", "sensors.*.zero", "sensors.*.span", "sensors.*.dark", "sensors.*.sight",
    "sensors.*.blind", "sensors.*.fov", "sensors.*.angle", "actions.*.continuous.*", "neutral.*",
    "ppo.gae_lambda", "ppo.clip", "ppo.clip_value", "ppo.value_weight", "ppo.max_grad_norm",
    "ppo.adam_epsilon", "ppo.weight_decay", "ppo.epochs", "ppo.minibatch",
})  # fmt: skip

ELSEWHERE = {  # in a column of another component: pattern → name of the trait
    "body.radius": "body.radius", "body.mass": "body.mass", "fertility": "fertility",
    "breeding.maturity": "breeding.maturity", "breeding.prime": "breeding.prime",
    "breeding.end": "breeding.end", "breeding.season": "breeding.season", "breeding.width": "breeding.width",
    "properties.*": "properties.NAME",
    "metabolism.growth": "metabolism.growth", "heat.insulation": "heat.insulation",
    "defence.toughness": "defence.toughness", "defence.poison": "defence.poison",
    "sensors.*.radius": "sensors.NAME.radius", "sensors.*.at.*": "sensors.NAME.forward",
    "policy.hidden.*": "policy.hidden.N",
    "reflex.connections.*.weight": "reflex.NAME.weight",
    "reflex.connections.*.above": "reflex.NAME.threshold",
    "reflex.connections.*.below": "reflex.NAME.threshold",
    "happiness.weights.*": "happiness.CHANNEL",
    "ppo.learning_rate": "ppo.learning_rate", "ppo.discount": "ppo.discount", "ppo.entropy": "ppo.entropy",
    "reproduction.age_min": "reproduction.age_min", "reproduction.energy_min": "reproduction.energy_min",
    "reproduction.energy_given": "reproduction.energy_given", "reproduction.litter": "reproduction.litter",
}  # fmt: skip

POPULATION = "it counts organisms: no single one has it"
PARENTLESS = "it is about organisms without parents, who have no gene of anybody"
LETTERS = "it says how letters are read and copied: a gene that changed it would be read differently"
MATTER = "it is matter, which comes from parents, food and surroundings, not from letters"
CHEMISTRY = "a reaction has the same proportions in every body"
SHAPE = "all of a species have one shape, which body.radius makes larger or smaller as a whole"
EGG = "an egg only keeps the genome of what hatches from it: it is read when that is born"
WIDTH = "it is the width of a column or of a network's input, which all of the species share"
SHARED = {  # pattern → why it cannot be an organism's own
    "count": POPULATION, "max_count": POPULATION,
    "age.*": PARENTLESS,
    "metabolism.energy_spread": PARENTLESS,
    "metabolism.energy": "founders bring it along; of those with parents it is reproduction.energy_given",
    "substances.*": MATTER, "reactions.*.from.*": CHEMISTRY, "reactions.*.to.*": CHEMISTRY,
    "body.density": "mass follows from it: that of an organism is body.mass",
    "builds.*.most": POPULATION,
    "body.length": SHAPE, "body.size.*": SHAPE,
    "hatch.incubation": EGG, "hatch.temperature": EGG, "hatch.threshold": EGG,
    "sensors.*.count": WIDTH, "sensors.*.width": WIDTH,
    "policy.mutation": "noise of what is inherited beside the genome; that of letters is genome.mutate",
    "genome.ploidy": LETTERS, "genome.loci": LETTERS, "genome.mate.chance": LETTERS,
    "genome.longest": LETTERS, "genome.insertion": LETTERS, "genome.deletion": LETTERS,
    "genome.duplication": LETTERS, "genome.loss": LETTERS, "genome.genes.*.copies": LETTERS,
    "genome.genes.*.letters": LETTERS, "genome.genes.*.at": LETTERS, "genome.genes.*.values.*": LETTERS,
    "genome.genes.*.low": LETTERS, "genome.genes.*.high": LETTERS, "genome.genes.*.codons": LETTERS,
    "genome.genes.*.coefficients": LETTERS, "genome.genes.*.mutation": LETTERS,
    "reproduction.immigration": PARENTLESS, "reproduction.seed_rain": PARENTLESS,
    "ppo.horizon": WIDTH, "ppo.unroll": "of networks with a memory, which torch lets learn all at once",
    "ppo.anneal": "those that learn one by one are not annealed",
}  # fmt: skip

OF_SITES = {  # what cannot be an organism's own where reproduction.kind = "spread"
    "reproduction.spacing": "it is the side of a site, and sites are the ground's",
    "reproduction.dispersal": "a free site looks for a plant within this distance: it is the site's",
}

