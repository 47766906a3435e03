"""Element 4 of the ODD: the eleven design concepts, as they apply to the world."""

from __future__ import annotations

from collections.abc import Iterator

from ecs_eco.config.features.feature import of_each
from ecs_eco.config.models.nerves import Reflex
from ecs_eco.config.models.species import Species
from ecs_eco.engine.errors import in_words
from ecs_eco.odd.document import Block, Heading, Items, grid
from ecs_eco.odd.model import Model, is_built_in
from ecs_eco.odd.values import shown, values_of
from ecs_eco.record.dictionary import means_in


def concepts(model: Model) -> Iterator[Block]:
    """Yield the design concepts."""
    for name, concept in CONCEPTS.items():
        yield Heading(3, name)
        yield from concept(model)


def _species(model: Model) -> dict[str, Species]:
    return {} if model.config is None else model.config.species


def _principles(model: Model) -> Iterator[Block]:
    if minds := [name for name, species in _species(model).items() if species.actions]:
        reflex = [name for name, one in _species(model).items() if one.reflex]
        policy = [name for name, one in _species(model).items() if one.policy.kind != "none"]
        networks = [f"an innate reflex network ({', '.join(reflex)})"] * bool(reflex)
        networks += [f"a policy ({', '.join(policy)})"] * bool(policy)
        yield (
            f"Organisms with a nervous system ({', '.join(minds)}) follow Strannegård et al. (2021): sensors yield "
            f"a vector x{f', from which decisions are made by {in_words(networks)}' * bool(networks)}."
        )
    if titles := [title.lower() for title in model.parts]:
        yield (
            f"The model combines these submodels: {in_words(titles)}. Element 7 gives their equations and sources."
        )


def _emergence(model: Model) -> Iterator[Block]:
    species = _species(model)
    yield (
        "The numbers, ages, positions and causes of death of entities emerge from submodels that act on "
        "individuals; no population equation is imposed."
    )
    if learned := [name for name, one in species.items() if one.policy.thinks]:
        yield f"The behavior of {in_words(learned)} emerges from learning; only the reward is imposed."
    if written := [name for name, one in species.items() if one.reflex is not None and one.genome is None]:
        yield f"The reflexes of {in_words(written)} are imposed."
    if coded := [name for name, one in species.items() if one.reflex is not None and one.genome is not None]:
        yield f"The reflexes of {in_words(coded)} are imposed, except where genes code for them."
    if genes := [name for name, one in species.items() if one.genome is not None]:
        yield (
            f"Allele frequencies of {in_words(genes)} emerge from births, deaths and mutation; no fitness "
            "function is imposed."
        )
    if capped := [f"{n} ({one.max_count:,})" for n, one in species.items() if one.max_count is not None]:
        yield f"A maximum number is imposed on {in_words(capped)}."


def _adaptation(model: Model) -> Iterator[Block]:
    rows = [row for name, species in _species(model).items() for row in _decisions(name, species)]
    if rows:
        yield "In each tick, an individual decides on one action in each group:"
        yield from grid(("species", "group", "actions", "decided by"), rows)
    if rest := [name for name in model.organisms if all(row[0] != name for row in rows)]:
        yield f"No decisions are made by {in_words(rest)}."


def _decisions(name: str, species: Species) -> Iterator[tuple[str, str, str, str]]:
    reflex = species.reflex or Reflex()
    named = {*reflex.formulas, *(one.action for one in reflex.connections)}
    for group, actions in species.actions.items():
        if isinstance(actions, list):
            options = ", ".join(actions)
            automatic = ["always on"] * bool(set(actions) & set(species.always_on))
        else:
            options, automatic = f"a number in {shown(actions.continuous)}", []
        policy = ["policy"] * (species.policy.kind != "none" and not automatic)
        mine = {group, *(f"{group}.{one}" for one in species.groups()[group]), *species.groups()[group]}
        reflexes = ["reflexes"] * bool(mine & named or reflex.function)
        yield name, group, options, ", ".join([*automatic, *policy, *reflexes]) or "the default action"


def _objectives(model: Model) -> Iterator[Block]:
    rows = []
    for name, species in _species(model).items():
        if (happiness := species.happiness) is not None:
            weights = " + ".join(f"{shown(w)} × {sensor}" for sensor, w in happiness.weights.items())
            formula = happiness.formula or weights or shown(happiness.function)
            genes = any("happiness." in (gene.trait or "") for gene in getattr(species.genome, "genes", ()))
            says = f"`{formula}`{means_in(formula, species)}" + ", with weights from genes" * genes
            rows.append((name, says, shown(happiness.minimum)))
    text = "The objective is happiness, a function of sensor readings; the reward is its change in a tick."
    yield text if rows else "Individuals have no objective."
    yield from grid(("species", "happiness", "minimum, and happiness at death"), rows)


def _learners(model: Model) -> list[tuple[str, Species]]:
    species = _species(model).items()
    return [
        (name, one) for name, one in species if one.policy.thinks and (one.policy.learn or one.policy.file)
    ]


def _learning(model: Model) -> Iterator[Block]:
    rows = []
    for name, species in _learners(model):
        policy, ppo = species.policy, species.ppo
        when = " and ".join(["before the run"] * bool(policy.file) + ["during the run"] * policy.learn)
        who = "one for each individual" if policy.kind == "individual" else "one for all members"
        rows.append((name, when, who, shown(ppo["learning_rate"]), shown(ppo["horizon"])))
    text = "Policies learn by PPO (Schulman et al. 2017) to increase the discounted sum of rewards."
    text += " Before the run, settings may differ (element 7, `training`)." * any(
        "before" in r[1] for r in rows
    )
    yield text if rows else "Individuals do not learn."
    yield from grid(("species", "learns", "policy", "learning rate", "rollout [ticks]"), rows)


def _prediction(model: Model) -> Iterator[Block]:
    discounts = [(name, species.ppo["discount"]) for name, species in _learners(model)]
    rows = [(name, shown(d), f"{1 / (1 - d):.3g}" if d < 1 else "∞") for name, d in discounts]
    text = (
        "Prediction is implicit: while a policy learns, a second output of its network predicts the discounted "
        "sum of future rewards from the current readings."
    )
    yield text if rows else "Individuals do not predict."
    yield from grid(("species", "discount", "horizon, 1/(1 − discount) [ticks]"), rows)


def _sensing(model: Model) -> Iterator[Block]:
    rows = [
        (name, getattr(sensor, "kind", ""), f"`{'`, `'.join(sensor.channels(model.world.space.volume + 2))}`")
        for name, species in _species(model).items()
        for sensor in species.sensors
    ]
    text = "Sensors read without error or delay. Element 7 (Sensing) defines the readings and their ranges."
    yield text if rows else "Individuals sense nothing."
    yield from grid(("species", "kind", "readings"), rows)


def _interaction(model: Model) -> Iterator[Block]:
    species, sections = _species(model), model.sections
    rows = [
        (name, other, f"`{key}`", f"{shown(reach)} m")
        for name in species
        for key, other, reach in of_each(species[name], "meets")
    ]
    rows += [
        (name, name, "`reproduction.reach`", f"{shown(one.reproduction.reach)} m")
        for name, one in species.items()
        if one.reproduction is not None and one.reproduction.kind == "sexual"
    ]
    text = "Individuals interact within reach, which is measured between the surfaces of their bodies:"
    some = [*[text] * bool(rows), *grid(("kind", "interacts with", "key", "reach"), rows)]
    if solid := [n for n, one in sections.items() if getattr(getattr(one, "body", None), "solid", False)]:
        some.append(f"Solid bodies push each other apart: {in_words(solid)}.")
    if smells := [f"{n} into {in_words(s.emits)}" for n, s in sections.items() if getattr(s, "emits", None)]:
        some.append(f"Individuals interact indirectly through emissions into fields: {in_words(smells)}.")
    if sensed := [
        f"{n} ({', '.join(kinds)})" for n, one in species.items() if (kinds := _sensed(model, one))
    ]:
        some.append(f"Individuals sense other individuals (kinds in parentheses): {in_words(sensed)}.")
    if own := _own(model):
        some.append(f"This world's own code may also define interactions (element 7): {in_words(own)}.")
    yield from some or ["Individuals do not interact."]


def _own(model: Model) -> list[str]:
    """Return the names of this world's own systems and sensors."""
    own = [getattr(one, "function", None) for species in _species(model).values() for one in species.sensors]
    systems = [type(system).__name__ for system in model.active if not is_built_in(system)]
    return [f"`{name}`" for name in (*systems, *map(shown, filter(None, own)))]


def _sensed(model: Model, species: Species) -> list[str]:
    """Return the kinds that a species' sensors detect."""
    named = [v.value for sensor in species.sensors for v in values_of(sensor)]
    return [
        kind for kind in model.tables if any(kind == v or (isinstance(v, list) and kind in v) for v in named)
    ]


def _stochasticity(model: Model) -> Iterator[Block]:
    draws = [part.submodel.draws for parts in model.parts.values() for part in parts if part.submodel.draws]
    yield (
        "Each random number is computed from the seed, the tick, the identity of the individual and the purpose of "
        "the draw, so no draw affects another. The model draws:"
    )
    founders = "the positions and headings of founders and, where they vary, their energies, ages and sexes"
    yield Items(tuple(dict.fromkeys([founders, *draws])))
    if own := _own(model):
        yield f"This world's own code may draw other numbers (element 7): {in_words(own)}."


def _collectives(model: Model) -> Iterator[Block]:
    shared = [name for name, species in _species(model).items() if species.policy.kind == "shared"]
    kin = [] if model.config is None else sorted(model.config.have_parents())
    yield "The model has no collectives with their own state or behavior, but groups may emerge."
    if shared:
        yield f"All members of a species share one policy: {', '.join(shared)}."
    if kin:
        yield f"The parents of individuals are recorded (families): {', '.join(kin)}."


def _observation(model: Model) -> Iterator[Block]:
    yield (
        "In every tick, a run records for each species the number alive, births, deaths by cause, and the energy "
        "taken in, burned, given away and lost. It also records the position of each birth and death, and "
        "snapshots of all individuals at regular intervals. Observations have no error."
    )
    config = model.config
    if config is not None:
        reporters = [(name, f"`{shown(reporter)}`") for name, reporter in config.reporters.items()]
        yield from grid(("reporter", "measured in every tick"), reporters)
        if config.record:
            yield f"For individuals, a run also records {in_words(f'`{field}`' for field in config.record)}."


CONCEPTS = {
    "Basic principles": _principles,
    "Emergence": _emergence,
    "Adaptation": _adaptation,
    "Objectives": _objectives,
    "Learning": _learning,
    "Prediction": _prediction,
    "Sensing": _sensing,
    "Interaction": _interaction,
    "Stochasticity": _stochasticity,
    "Collectives": _collectives,
    "Observation": _observation,
}
