"""Notes on a world: settings that are allowed but might not be intended."""

from collections.abc import Iterator

from ecs_eco.config.derived import all_genes
from ecs_eco.config.features.feature import of_each
from ecs_eco.config.models.reproduction import Bearing
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.shipped import WORLDS
from ecs_eco.engine.files import read_bytes
from ecs_eco.learning.aliases import hint
from ecs_eco.learning.weights import MOST_BYTES, NAMES

LATE = 0.25  # fraction of a lifespan; generations hardly overlap if breeding begins this late


def notes(config: WorldConfig) -> list[str]:
    """Return the notes on a world, one per line."""
    found = [*config._renamed, *_on_land(config)]
    for name, species in config.species.items():
        about = (
            *_on_energy(config, species),
            *_on_decisions(species),
            *_on_lives(config, name, species),
            *_on_founders(species),
            *_on_weights(config, species),
            *(f".ppo: {hint(word)}" for word in species._words),
        )
        found += [f"species.{name}{note}" for note in about]
    return found


def _on_land(config: WorldConfig) -> Iterator[str]:
    land, terrain = config._land, config.terrain
    if land is None or land.place is None or terrain is None:
        return
    x, y = (1 / (per * (terrain.scale or 1.0)) for per in land.place[2:])
    if max(abs(x - 1), abs(y - 1)) > 1e-6:
        yield (
            f"terrain.raster: one unit of its coordinates ({land.crs[:40]}) is {x:.6g} m from "
            f"west to east and {y:.6g} m from south to north, measured in the middle of the raster"
        )


def _on_energy(config: WorldConfig, species: Species) -> Iterator[str]:
    most = species.metabolism.energy_max
    if why := meaningless_debt(config, species):
        yield (
            f": its energy can fall below 0 ({why}), which has no effect; give it "
            'lethal = [{ property = "energy", min = 0.0 }] or metabolism.torpor = true, or remove the costs'
        )
    way = species.reproduction
    if (
        isinstance(way, Bearing)
        and (each := way.energy_given * (1.0 - getattr(way, "father_share", 0.0))) > 0
        and not any(trait.startswith("reproduction.") for trait in _coded(species))
    ):
        if (litter := way.litter) > 1 and litter * each >= most:
            yield (
                f".reproduction.litter = {litter}: no mother can pay for the whole litter, because "
                f"metabolism.energy_max is {most:g}, and each newborn costs {each:g}"
            )
        if way.energy_min < each:
            yield (
                f".reproduction.energy_min = {way.energy_min:g}: less than the {each:g} that a newborn costs "
                "its mother, who gives birth only when she can pay"
            )
    for i, food in enumerate(species.diet):
        if food.satiation is not None and food.satiation > most:
            yield (
                f".diet.{i}.satiation = {food.satiation:g}: never reached, because metabolism.energy_max is "
                f"{most:g}; it also eats at energy_max, but gains nothing"
            )


def _on_decisions(species: Species) -> Iterator[str]:
    free = [f"{g}.{a}" for g, a in species.decisions() if species.default_action.get(g) != a]
    if free and species.reflex is None and species.policy.kind == "none":
        yield (
            f".actions: nothing controls {', '.join(free)}; add a reflex or a policy, or list actions that "
            "it should always take under always_on"
        )
    formulas = species.reflex.formulas if species.reflex is not None else {}
    for group, actions in species.groups().items():
        always = [a for a in actions if _is_positive(formulas.get(f"{group}.{a}", formulas.get(a, "")))]
        if always and (never := actions[actions.index(always[0]) + 1 :]):
            yield (
                f".reflex.formulas.{always[0]} always forces this action, and only the first forced action "
                f"of each group is taken; never taken: {', '.join(never)}"
            )


def _is_positive(formula: str) -> bool:
    try:
        return float(formula) > 0
    except ValueError:
        return False


def _on_founders(species: Species) -> Iterator[str]:
    oldest = _oldest(species)
    if oldest is None or not species.count:
        return
    if species.age is not None:
        if species.age[1] > oldest:
            yield (
                f".age = [{species.age[0]:g}, {species.age[1]:g}]: it dies at age {oldest:g}, so older "
                "founders die in the first tick"
            )
    elif oldest > (adult := max(_adult(species).values())) >= LATE * oldest:
        yield (
            f": all founders have age 0, so none breed before {adult:g} s, all survivors die at "
            f"{oldest:g} s, and numbers oscillate with the generations; give founders different ages: "
            f"age = [0, {oldest:g}]"
        )


def _on_weights(config: WorldConfig, species: Species) -> Iterator[str]:
    if species.policy.file is None or WORLDS in (path := config.file(species.policy.file)).parents:
        return
    if NAMES.encode() not in read_bytes(path, MOST_BYTES):
        yield (
            f".policy.file = {species.policy.file}: the file names neither channels nor actions, so only "
            "the shapes of its weights are checked"
        )


def _oldest(species: Species) -> float | None:
    """Return the age [s] at which members of a species die, or None if there is no limit."""
    return min(
        (limit.max for limit in species.lethal if limit.property == "age" and limit.max is not None),
        default=None,
    )


def _adult(species: Species) -> dict[str, float]:
    """Return the ages from which a species can breed [s], by key."""
    breeding = species.breeding
    return {
        "reproduction.age_min": getattr(species.reproduction, "age_min", 0.0),
        "breeding.maturity": 0.0 if breeding is None else breeding.maturity,
    }


def _on_lives(config: WorldConfig, name: str, species: Species) -> Iterator[str]:
    way = species.reproduction
    oldest = _oldest(species)
    for key, age in _adult(species).items():
        if oldest is not None and age >= oldest:
            yield f".{key} = {age:g}: it never breeds, because it dies at age {oldest:g}"
    eaten = any(food.eats == name for other in config.species.values() for food in other.diet)
    if (
        way is not None
        and way.kind != "spread"
        and not species.lethal
        and not eaten
        and species.max_count is None
    ):
        yield (
            ": it breeds, but nothing kills it; give it lethal limits, such as "
            '[{ property = "age", max = 1000.0 }], a predator, or max_count'
        )
    ticks = config.search.ticks or config.ticks
    if config.search.ranges and oldest is not None and way is not None and ticks * config.dt < oldest:
        yield (
            f": a search's runs last {ticks * config.dt:g} s, less than a lifespan of {oldest:g} s, so all "
            "survivors at the end may be founders"
        )


def meaningless_debt(config: WorldConfig, species: Species) -> str:
    """Return the keys of costs that can reduce energy below 0 without any effect, or ""."""
    deadly = any(limit.property == "energy" and limit.min is not None for limit in species.lethal)
    return "" if deadly or species.metabolism.torpor else ", ".join(_costs(config, species))


def _costs(config: WorldConfig, species: Species) -> Iterator[str]:
    """Yield a species' keys that cost energy even when its members have none left."""
    if species.metabolism.basal > 0:
        yield "metabolism.basal"
    if species.locomotion is not None:
        yield from (f"locomotion.cost.{gait}" for gait, cost in species.locomotion.cost.items() if cost > 0)
    paid = (cost for cost in of_each(species, "costs") if cost.owed and cost.value > 0)
    yield from (".".join(map(str, cost.key)) for cost in paid)
    for i, food in enumerate(species.diet):
        if food.gain < 0:
            yield f"diet.{i}.gain"
        prey = config.species.get(food.eats)
        if prey is not None and (prey.defence.poison > 0 or "defence.poison" in _coded(prey)):
            yield f"species.{food.eats}.defence.poison"
    yield from (
        trait for trait in _coded(species) if trait.startswith(("metabolism.basal", "locomotion.cost"))
    )


def _coded(species: Species) -> list[str]:
    """Return the names of the traits that its genes code for."""
    return [gene.trait for gene in all_genes(species) if gene.trait]
