"""Unit, description and source of each recorded column, for Parquet files and the data dictionary."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from ecs_eco.config.models.reporters import EATEN
from ecs_eco.config.models.sensors import Smell
from ecs_eco.config.models.species import Species
from ecs_eco.config.reporter_formula import ReporterFormula
from ecs_eco.config.traits import traits_of
from ecs_eco.engine import files
from ecs_eco.engine.comments import comments_of
from ecs_eco.engine.table import Table
from ecs_eco.inputs.section import function_name
from ecs_eco.life import matter
from ecs_eco.record.belonging import listed
from ecs_eco.record.genomes import genes_of
from ecs_eco.record.parquet import read_metadata
from ecs_eco.space.world import SpatialWorld

NAME = "data_dictionary"
DETAILS = "details-"
COLUMNS = """
*        tick       tick   world.tick            number of the tick, from 0
*        species    -      world.tables          name of the species
*        uid        -      table.uid             number of the organism, never reused
*        x          m      Position.x            position along x
*        y          m      Position.y            position along y
*        z          m      Position.z            position along z, above the bottom; 0 in a plane
*        heading    rad    Position.heading      direction it faces, measured from the x axis
*        energy     energy Metabolism.energy     energy of the organism
*        happiness  1      Nervous.happiness     happiness of the organism
*        parent     -      Recorder              uid of the first parent; 0: none
*        parent2    -      Recorder              uid of the second parent; 0: none
*        genome     -      Genome.loci           letters of the genome
*        cause      -      table.cause           cause of death
*        killer     -      table.killer          uid of the organism that killed it; 0: none
*        age        s      table.born            age at death
*        born       tick   table.born            tick of birth
*        origin     -      archipelago           island from which the migrant came
*        target     -      archipelago           island to which the migrant went
*        reward     1      Nervous.reward        reward in this tick
series   n          1      table.n               organisms alive at the end of the tick
series   births     1      Recorder              births in the tick
series   deaths     1      Recorder              deaths in the tick
series   refused    1      max_count             newcomers rejected at max_count, and objects at builds.most
series   immigrants 1      archipelago           organisms that came from other islands
series   emigrants  1      archipelago           organisms that left for other islands
series   energy_mean    energy Metabolism.energy mean energy of organisms alive at the end of the tick
series   happiness_mean 1      Nervous.happiness mean happiness of organisms alive at the end of the tick
series   depth_mean     m      Position.z        mean distance below the top; 0 if none are alive
series   stock_before   energy Metabolism.energy energy of the species before the tick
series   endowed        energy Metabolism.energy energy of newborns
series   taken_in       energy Metabolism.taken  energy from food and light
series   burnt          energy Metabolism.burnt  energy spent on basal metabolism and locomotion, less debt at death
series   given          energy Metabolism.given  energy that parents passed to their newborns
series   lost           energy Metabolism.energy energy held at death, eaten or not; a debt counts as 0
series   stock_after    energy Metabolism.energy energy of the species after the tick
series   imported       energy Metabolism.energy energy of immigrants
series   exported       energy Metabolism.energy energy of emigrants
matter   holder       -    world.matter          species, object type or field that contains the substance
matter   substance    -    substances            name of the substance
matter   stock_before mol  world.matter          amount before the tick
matter   stock_after  mol  world.matter          amount after the tick
learning n_transitions        1   Learner.update transitions in the update; each is one tick of one organism
learning n_learners           1   Learner.update updated networks
learning reward               1   Learner.update mean reward of the transitions
learning entropy              nat Learner.update mean entropy of the policy
learning approx_kl            nat Learner.update estimated divergence from the previous policy
learning explained_variance   1   Learner.update share of the variance of returns that values explain
learning policy_loss          1   Learner.update loss of the policy
learning value_loss           1   Learner.update loss of the value estimate
learning clip_fraction        1   Learner.update share of transitions whose probability ratio was clipped
learning gradient_norm        1   Learner.update norm of the gradient before clipping
learning learning_rate        1   Learner.update step size of Adam
actions  action   -        actions               group and name of the action
actions  n        1        Nervous.decision      organisms that carried out the action in this tick
actions  of       1        Nervous.decision      organisms that decided in this tick
details  reflex      1     reflex                −1: blocked by the reflex; 0: left to the policy; 1: forced
details  probability 1     policy                probability that the policy assigns to it
details  chosen      1     policy                1: chosen by the policy, or automatic
details  decision    1     Nervous.decision      1: carried out
"""  # kind of table ("*": any), column, unit ("1": dimensionless, "-": not a number), source, description


class Meaning(NamedTuple):
    """The meaning of a column: unit ("1": dimensionless, "": not a number), description and source."""

    unit: str
    description: str
    source: str


FIXED = {
    (kind, name): Meaning(unit.strip("-"), text, source)
    for line in COLUMNS.strip().splitlines()
    for kind, name, unit, source, text in [line.split(None, 4)]
} | {
    ("matter", name): Meaning("mol", text, "world.matter")
    for name, text in (matter.FLOWS | matter.MIGRATION).items()
}


def described(table: pa.Table, kind: str, world: SpatialWorld) -> pa.Table:
    """Return a table of one kind ("series", "births", "details-deer" …) with each column's meaning added."""
    fields = [f.with_metadata(meaning(kind, f.name, world)._asdict()) for f in table.schema]
    return pa.Table.from_arrays(table.columns, schema=pa.schema(fields))


def meaning(kind: str, column: str, world: SpatialWorld) -> Meaning:
    """Return the meaning of a column in one kind of table."""
    head, _, rest = column.partition(": ")
    if kind.startswith(DETAILS):
        return _of_details(world.tables[kind.removeprefix(DETAILS)], column, 3 if world.space.volume else 2)
    if kind == "series" and column in world.reporters:
        what = world.reporters[column]
        text = what.text if isinstance(what, ReporterFormula) else function_name(what)
        return Meaning("", f"your own measurement: {text}", f"reporters, {column}")
    if head == "died":
        return Meaning("1", f'deaths in the tick with the cause "{rest}"', "table.cause")
    if column.startswith(EATEN):
        food = column.removeprefix(EATEN)
        return Meaning(
            "energy", f"energy gained by eating {food}, part of taken_in; negative: a loss", f"diet, {food}"
        )
    if "." in column:
        return _of_field(column, world)
    known = FIXED.get((kind, column)) or FIXED.get(("*", column), Meaning("", "", ""))
    if column == "happiness_mean":
        each = {name: _happiness(table) for name, table in world.tables.items()}
        return _with(known, "; ".join(f"{name}: {formula}" for name, formula in each.items() if formula))
    return known


def _of_field(column: str, world: SpatialWorld) -> Meaning:
    """Return the meaning of a recorded field of a component, "Strain.virulence" or "Strain.genome.3"."""
    name, field, *place = column.split(".")
    component: Any
    for table in world.tables.values():
        for component in table.columns:
            if component.__name__ == name and field in component.fields:
                unit, text = comments_of(component).get(field, ("", ""))
                return Meaning(unit, text + (f", entry {place[0]}" if place else ""), f"{name}.{field}")
    return Meaning("", "", f"{name}.{field}")


def _of_details(table: Table, column: str, dims: int) -> Meaning:
    head, _, act = column.partition(": ")
    if head == "sensor":
        return _of_sensor(table, act, dims)
    known = FIXED.get(("details", head)) or FIXED["*", column]
    if column == "happiness":
        return _with(known, _happiness(table))
    if act in table.species.nerves.ranges.groups and head != "probability":
        return known._replace(unit="", description=f"value of the continuous action {act}")
    return _with(known, act)


def _of_sensor(table: Table, channel: str, dims: int) -> Meaning:
    section = table.species.section
    for i, sensor in enumerate(section.sensors if section is not None else ()):
        if channel in sensor.channels(dims):
            text = " ".join((type(sensor).__doc__ or "").split()).partition(". ")[0].rstrip(".")
            of = next(
                (str(v) for w in ("target", "field", "property") if (v := getattr(sensor, w, None))), ""
            )
            mean = _means(section).get(of, "") if isinstance(sensor, Smell) else of
            return _with(Meaning("1", text, f"sensors.{i}, {sensor.kind}"), mean or of)
    return Meaning("1", "", f"sensors, {channel}")


def _with(known: Meaning, more: str) -> Meaning:
    return known._replace(description=f"{known.description} ({more})") if more else known


def _happiness(table: Table) -> str:
    """Return a species' happiness formula, with the definitions of its names."""
    section: Any = table.species.section
    formula = getattr(getattr(section, "happiness", None), "formula", None)
    return formula + means_in(formula, section) if formula else ""


def means_in(formula: str, section: Species) -> str:
    """Return the definitions of a formula's names that are means of several channels, or ""."""
    used = set(re.findall(r"\w+", formula))
    means = [text for name, text in _means(section).items() if name in used]
    return f", where {' and '.join(means)}" if means else ""


def _means(section: Species) -> dict[str, str]:
    """Return the definition of each field that a species smells with several sensors: their mean."""
    channels, readings = section.channels(2), section.readings(2)
    each = {name: [channels[i] for i in rows] for name, rows in readings.items() if len(rows) > 1}
    return {name: f"{name} is the mean of {' and '.join(noses)}" for name, noses in each.items()}


def genes(world: SpatialWorld) -> dict[str, dict[str, Any]]:
    """Return the meaning of each species' genes: species → gene → unit, description, source."""
    out: dict[str, dict[str, Any]] = {}
    for name, table in world.tables.items():
        if (kept := genes_of(table)) is None or world.config is None:
            continue
        section = table.species.section
        traits = traits_of(section, world.config.dims, world.config.own_components(section))
        for gene in (*kept["genes"], *kept.get("derived", [])):
            trait = traits.get(gene["trait"])
            unit, text = ("", "neutral marker") if trait is None else (trait.unit, trait.text)
            place = gene.get("formula") or (f"loci from {gene['at']}" if "at" in gene else "")
            source = ", ".join(filter(None, [gene["trait"], place]))
            out.setdefault(name, {})[gene["name"]] = Meaning(unit, text, source)._asdict()
    return out


def write_dictionary(folder: Path, kinds: Iterable[str], world: SpatialWorld) -> None:
    """Write data_dictionary.json and .md to a run's folder, based on the columns of its parts."""
    tables: dict[str, dict[str, Any]] = {}
    for kind in kinds:
        parts = listed(folder / kind)
        schemas = [read_metadata(part).schema.to_arrow_schema() for part in (*parts[:1], *parts[-1:])]
        for field in (field for schema in schemas for field in schema):
            said = {k.decode(): v.decode() for k, v in (field.metadata or {}).items()}
            one = {"type": str(getattr(field.type, "value_type", field.type))} | {
                word: said.get(word, "") for word in Meaning._fields
            }
            tables.setdefault(kind, {})[field.name] = one
    content = {"tables": tables, "genes": genes(world)}
    files.write_json(folder / f"{NAME}.json", content)
    files.write(folder / f"{NAME}.md", "\n".join(_page(content)))


def _page(content: dict[str, dict[str, Any]]) -> Iterator[str]:
    yield "# Data dictionary\n\nThe columns of the Parquet files in this folder. Unit 1: dimensionless.\n"
    heads = {"tables": "{}/part-*.parquet", "genes": "Genes of {}"}
    for head, tables in ((heads[word], tables) for word, tables in content.items()):
        for name, columns in tables.items():
            words = list(next(iter(columns.values())))
            yield f"## {head.format(name)}\n\n| name | {' | '.join(words)} |\n|{'---|' * (len(words) + 1)}"
            yield from (
                f"| `{key}` | {' | '.join(map(_cell, one.values()))} |" for key, one in columns.items()
            )
            yield ""


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").replace("<", "&lt;").split())
