"""The contents of a nervous-system drawing: sensors, actions, reflexes and networks."""

import math
from dataclasses import dataclass
from typing import Any

from ecs_eco.analysis.formula_signs import Sign, directions, pushes
from ecs_eco.config import WorldConfig
from ecs_eco.config.derived import all_genes
from ecs_eco.config.models.species import OWN, Species
from ecs_eco.config.models.surroundings import BODY, PROPERTIES
from ecs_eco.engine.errors import ConfigError, Problem, nearest
from ecs_eco.inputs.section import function_name

KINDS = {
    "own": "interoception",
    "touch": "touch",
    "smell": "smell",
    "gradient": "smell",
    "approach": "touch",
    "nearest": "vision",
    "rays": "vision",
    "property": "bodies around",
    "alignment": "bodies around",
    "light": "surroundings",
    "temperature": "surroundings",
    "pressure": "surroundings",
}
SECTIONS = dict.fromkeys(("eat", "drink", "breathe", "suck", "sleep"), "homeostatic regulation") | {
    "mate": "reproduction",
    "speed": "locomotion",
    "turn": "locomotion",
    "climb": "locomotion",
}
ORDER = ("homeostatic regulation", "reproduction", "other actions", "locomotion")


@dataclass(frozen=True)
class SensorNode:
    """A sensor: its kind, its stimulus and position, and its channels (rows of the sensory input)."""

    kind: str  # heading: interoception, touch, smell, vision, bodies around, surroundings, other senses
    text: str
    channels: tuple[str, ...]
    first: int  # row of its first channel
    at: tuple[float, float] | None = None  # position on the body: forward, left [radii]
    sector: tuple[float, float] | None = None  # start and end [rad]: 0 is ahead, left is positive
    vision: bool = False


@dataclass(frozen=True)
class ActionNode:
    """An action: its group, and what determines it if no reflex does."""

    section: str  # one of ORDER
    group: str
    name: str
    row: int  # row in the decision vector
    automatic: bool = False
    neutral: bool = False
    chosen: bool = False  # whether the policy network chooses it
    range: tuple[float, float] | None = None  # of a continuous action


@dataclass(frozen=True)
class Reflex:
    """A connection or formula of the reflex network; `sources` are (channel row, sign or None if it varies)."""

    sources: tuple[tuple[int, Sign], ...]
    action: int  # row in the decision vector
    sign: Sign
    label: str
    gene: str = ""  # gene for its weight or threshold


@dataclass(frozen=True)
class HappinessNode:
    """The happiness network; if `sources` is empty, it is a function of all channels."""

    sources: tuple[tuple[int, Sign], ...]
    label: str
    genes: tuple[str, ...] = ()  # genes for its weights
    heritable: frozenset[int] = frozenset()  # channels whose weight is set by a gene


@dataclass(frozen=True)
class PolicyNode:
    """The policy network: `layers` lists the units per layer, from channels to options (empty: no network)."""

    kind: str
    layers: tuple[int, ...]
    learns: bool
    inherit: str = "none"
    network: str = ""  # class name of a torch module, whose layers are not shown

    @property
    def label(self) -> str:
        """The layers and the kind of policy: "14 → 64 → 64 → 6, shared"."""
        return f"{self.way}, {self.kind}" if self.layers else "none"

    @property
    def way(self) -> str:
        """The units of the layers, or the network between channels and options: "14 → Net → 6"."""
        n, first, last = len(self.layers), self.layers[0], self.layers[-1]
        if self.network:
            return f"{first} → {self.network} → {last}"
        return " → ".join(map(str, self.layers)) if n <= 6 else f"{first} → … {n - 2} layers … → {last}"


@dataclass(frozen=True)
class Diagram:
    """A nervous system to draw. Rows refer to the sensory input and the decision vector."""

    world: str
    species: str
    channels: tuple[str, ...]
    sensors: tuple[SensorNode, ...]  # in drawing order
    actions: tuple[ActionNode, ...]  # in drawing order
    reflexes: tuple[Reflex, ...]
    function: str  # module:name of a reflex network that is a function; "" otherwise
    happiness: HappinessNode | None
    policy: PolicyNode


def nervous_species(config: WorldConfig) -> list[str]:
    """Return the species that have sensors or actions."""
    return [name for name, s in config.species.items() if s.sensors or s.actions]


def diagram(config: WorldConfig, species: str) -> Diagram:
    """Return the diagram of a species; raise ConfigError if it is missing or has no nervous system."""
    nervous = nervous_species(config)
    if species not in nervous:
        fault = "no such species" if species not in config.species else "it has neither sensors nor actions"
        allowed = "no species of this world has a nervous system"
        if nervous:
            allowed = f"a species with a nervous system: {', '.join(nervous)}"
        raise ConfigError([Problem((), fault, species, allowed, nearest(species, nervous), "species")])
    own = config.species[species]
    return Diagram(
        config.title or config.name,
        species,
        own.channels(config.dims),
        tuple(_sensors(own, config.dims)),
        tuple(_actions(own)),
        tuple(_reflexes(own, config.dims)),
        function_name(own.reflex.function) if own.reflex and own.reflex.function else "",
        _happiness(own, config.dims),
        _policy(own, config.dims),
    )


def _sensors(species: Species, dims: int) -> list[SensorNode]:
    nodes, first = [], 0
    for s in species.sensors:
        channels = s.channels(dims)
        place = [] if s.kind == "touch" else getattr(s, "at", [])
        at: Any = tuple(place[:2]) if s.kind not in ("own", "nearest", "rays") or any(place) else None
        sector: Any = tuple(s.at) if s.kind == "touch" else None
        if hasattr(s, "fov"):
            ahead = getattr(s, "angle", 0.0)
            sector = (ahead - s.fov / 2, ahead + s.fov / 2)
        kind, of = KINDS.get(s.kind, "other senses"), f"sensors.{s.name}."
        genes = [*dict.fromkeys(g.name for trait, g in _genes(species).items() if trait.startswith(of))]
        text = _text(s) + f", gene{'s' * (len(genes) > 1)} {', '.join(genes)}" * bool(genes)
        nodes.append(SensorNode(kind, text, channels, first, at or None, sector, kind == "vision"))
        first += len(channels)
    order = [*dict.fromkeys(KINDS.values()), "other senses"]
    return sorted(nodes, key=lambda node: order.index(node.kind))


def _text(sensor: Any) -> str:
    """Return a description of a sensor's stimulus and position."""
    where = f", {_place(sensor.at)}" if sensor.kind in ("own", "nearest", "rays") and any(sensor.at) else ""
    match sensor.kind:
        case "own":
            return f"own {sensor.property}" + f", 1 at {sensor.scale:g}" * (sensor.scale != 1) + where
        case "nearest":
            hidden = ", if in sight" if sensor.occlusion else ""
            return f"nearest {sensor.target} within {sensor.range:g} m{_angle(sensor.fov)}{where}{hidden}"
        case "rays":
            rays = "1 ray" if sensor.count == 1 else f"{sensor.count} rays"
            around = f" around {math.degrees(sensor.angle):.0f}°".replace("-", "−") * bool(sensor.angle)
            return f"{rays} of {sensor.range:g} m{_angle(sensor.fov)}{around}{where}: {', '.join(sensor.targets)}"
        case "property":
            decay = {"none": "", "linear": ", falling linearly", "inverse_square": ", by inverse square"}
            mean, whose = "mean " * (sensor.report == "mean"), " or ".join(sensor.kinds()) or "all bodies"
            return (
                f"{mean}{sensor.property} of {whose} within {sensor.range:g} m{decay[sensor.decay]}, "
                f"{_place(sensor.at)}"
            )
        case "touch":
            begin, end = sensor.at
            sector = f"{math.degrees(begin):.0f}° to {math.degrees(end):.0f}°".replace("-", "−")
            sector = "all around" if end - begin >= 2 * math.pi - 1e-5 else sector
            return f"{'anything' if sensor.target == 'any' else sensor.target}, {sector}"
        case "approach":
            return f"optic flow of the nearest approaching {sensor.target}, within {sensor.range:g} m"
        case "alignment":
            return f"mean heading of {sensor.target} within {sensor.range:g} m"
        case "gradient":
            return f"direction in which {sensor.field} rises, over {sensor.span:g} m"
        case "custom":
            return function_name(sensor.function)
    property_ = sensor.field if sensor.kind == "smell" else sensor.kind
    return f"{property_}, {_place(sensor.at)}"


def _angle(fov: float) -> str:
    return "" if fov >= 2 * math.pi - 1e-5 else f" over {math.degrees(fov):.0f}°"


def _place(at: list[float]) -> str:
    """Return a position on the body as text, in radii: "1 ahead, 0.5 left"."""
    ways = (("ahead", "behind"), ("left", "right"), ("up", "down"))
    return ", ".join(f"{abs(v):g} {ways[i][v < 0]}" for i, v in enumerate(at) if v) or "at the center"


def _actions(species: Species) -> list[ActionNode]:
    nodes, ranges = [], species.ranges()
    for row, (group, name) in enumerate(species.action_list()):
        automatic = bool({name, f"{group}.{name}"} & set(species.always_on))
        chosen, neutral = (
            species.policy.kind != "none" and not automatic,
            species.default_action.get(group) == name,
        )
        section = _section(group)
        nodes.append(ActionNode(section, group, name, row, automatic, neutral, chosen, ranges.get(group)))
    return sorted(nodes, key=lambda node: ORDER.index(node.section))


def _section(group: str) -> str:
    if group.startswith(("homeosta", "locomot")):
        return "locomotion" if group.startswith("locomot") else "homeostatic regulation"
    return SECTIONS.get(group, "other actions")


def _reflexes(species: Species, dims: int) -> list[Reflex]:
    if species.reflex is None:
        return []
    readings, rows = species.readings(dims), species.action_rows()
    reflexes = [_connection(c, readings, rows, _genes(species)) for c in species.reflex.connections]
    for action, text in species.reflex.formulas.items():
        sources = _sources(pushes(text, _positive(species, dims)), readings)
        signs = {sign for _, sign in sources}
        sign = signs.pop() if len(signs) == 1 else None
        reflexes.append(Reflex(sources, rows[action], sign, " ".join(text.split())))
    return reflexes


def _connection(
    c: Any, readings: dict[str, tuple[int, ...]], rows: dict[str, int], genes: dict[str, Any]
) -> Reflex:
    weight, threshold = (genes.get(f"reflex.{c.label}.{part}") for part in ("weight", "threshold"))
    sign: Sign = c.weight
    worth = _signed(c.weight)
    if weight is not None:
        values, sign = _range(weight)
        worth = " or ".join(_signed(v) for v in sorted({round(v) for v in values}, key=lambda v: (abs(v), v)))
    beyond = f"> {c.above:g}" if c.above is not None else f"< {c.below:g}"
    if threshold is not None:
        beyond = beyond[:1] + " " + threshold.name
    gene = ", ".join(dict.fromkeys(g.name for g in (weight, threshold) if g is not None))
    sources = tuple((row, sign) for row in readings[c.sensor])
    return Reflex(sources, rows[c.action], sign, f"{worth} if {c.sensor} {beyond}".replace("-", "−"), gene)


def _range(gene: Any) -> tuple[list[float], Sign]:
    """Return a weight gene's values (or the ends of its range and 0, if in between), and their common sign."""
    values = list(gene.values or (gene.low, gene.high))
    if not gene.values and min(values) < 0 < max(values):
        values.append(0.0)
    signs = {(v > 0) - (v < 0) for v in values} - {0}
    return values, 0 if not signs else signs.pop() if len(signs) == 1 else None


def _signed(weight: float) -> str:
    return f"{weight:+g}".replace("-", "−") if weight else "0"


def _genes(species: Species) -> dict[str, Any]:
    """Return the genes of a species by trait."""
    return {gene.trait: gene for gene in all_genes(species) if gene.trait}


def _happiness(species: Species, dims: int) -> HappinessNode | None:
    happiness = species.happiness
    if happiness is None:
        return None
    if happiness.function is not None:
        return HappinessNode((), function_name(happiness.function))
    terms = " + ".join(f"{w:g} * {name}" for name, w in happiness.weights.items())
    text = happiness.formula or terms.replace("+ -", "- ")
    sources = _sources(directions(text, _positive(species, dims)), species.readings(dims))
    label = " ".join(text.split()) if happiness.formula else text.replace(" * ", "·")
    genes = {name: g for name in happiness.weights if (g := _genes(species).get(f"happiness.{name}"))}
    signs = {row: _range(g)[1] for name, g in genes.items() for row in species.readings(dims)[name]}
    sources = tuple((row, signs.get(row, sign)) for row, sign in sources)
    names = tuple(dict.fromkeys(g.name for g in genes.values()))
    return HappinessNode(sources, label, names, frozenset(signs))


def _sources(signs: dict[str, Sign], readings: dict[str, tuple[int, ...]]) -> tuple[tuple[int, Sign], ...]:
    """Return (channel row, sign) for the channels that names refer to; the sign is None if two names disagree."""
    by_row: dict[int, Sign] = {}
    for name, sign in signs.items():
        for row in readings[name]:
            by_row[row] = sign if by_row.get(row, sign) == sign else None
    return tuple(sorted(by_row.items()))


def _positive(species: Species, dims: int) -> set[str]:
    """Return the names of readings that are never negative."""
    names: set[str] = set()
    for s in species.sensors:
        channels = s.channels(dims)
        if s.kind == "own" and s.property in (*OWN, "sex", *BODY, *species.substances):
            names |= set(channels)
        elif s.kind in ("smell", "touch") or (s.kind == "rays" and s.report == "per_ray"):
            names |= {*channels, getattr(s, "field", channels[0])}
        elif s.kind in ("nearest", "rays"):
            names |= {c for c in channels if c.endswith("_near")}
        elif (s.kind == "light" or (s.kind == "property" and s.property not in PROPERTIES)) and s.zero <= 0:
            names |= set(channels)
    return names


def _policy(species: Species, dims: int) -> PolicyNode:
    policy = species.policy
    if policy.kind == "none":
        return PolicyNode("none", (), False)
    automatic = set(species.always_on)
    groups = [
        [a for a in names if not {a, f"{group}.{a}"} & automatic]
        for group, names in species.groups().items()
        if group
    ]
    options = sum(max(2, len(names)) for names in groups if names)  # one action: to act or not
    named = policy.network or policy.function
    network = function_name(named).partition(":")[2] if named else ""
    hidden = [] if network or not policy.thinks else policy.hidden
    layers = (len(species.channels(dims)), *hidden, options)
    return PolicyNode(policy.kind, layers, policy.learn, policy.inherit, network)
