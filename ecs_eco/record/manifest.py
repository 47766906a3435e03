"""The model of a run's manifest: the keys that are read, and their types.

Keys that older versions did not write are optional; unknown keys are ignored.
"""

from typing import Annotated, Any, Self

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from ecs_eco.inputs.section import Section


def _is_name(text: str) -> str:
    if text in ("", ".", "..") or "/" in text or "\\" in text or not text.isprintable():
        raise ValueError("is not a name: it is empty, or contains a separator or a control character")
    return text


Filename = Annotated[str, AfterValidator(_is_name)]
Sha = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Tick = Annotated[int, Field(ge=0, le=10**12)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]
Positive = Annotated[float, Field(gt=0)]


WRITTEN = (  # keys of all manifests with seals
    *("format", "world", "seed", "ticks", "done", "dt", "finished", "policies", "learn", "versions"),
    *("snapshot_every", "keep", "config", "species", "causes", "parts"),
)


class _Part(Section):
    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)


class Space(_Part):
    """The space in the world's configuration."""

    size: Annotated[list[Positive], Field(min_length=2, max_length=3)]
    edges: str


class Limit(_Part):
    """A lethal limit of a species."""

    property: str


class Food(_Part):
    """An entry of a species' diet."""

    eats: str
    gain: float


class Sensor(_Part):
    """A sensor of a species."""

    kind: str
    range: float | None = None


class Body(_Part):
    """The bodies of a species or an object type."""

    radius: Positive = 1.0


class Metabolism(_Part):
    """The metabolism of a species."""

    energy_max: float | None = None


class Object(_Part):
    """An object type in the world's configuration."""

    color: str | None = None
    body: Body
    at: list[list[float]] | None = None


class Species(_Part):
    """A species in the world's configuration."""

    count: int = 0
    color: str | None = None
    body: Body | None = None
    metabolism: Metabolism | None = None
    diet: list[Food] | None = None
    sensors: list[Sensor] | None = None
    reproduction: dict[str, Any] | None = None
    locomotion: dict[str, Any] | None = None
    happiness: dict[str, Any] | None = None
    policy: dict[str, Any] | None = None
    lethal: list[Limit] | None = None


class Config(_Part):
    """The configuration of a world, as needed to read a run."""

    name: str = ""
    title: str = ""
    space: Space
    species: Annotated[dict[str, Species], Field(min_length=1)]
    terrain: dict[str, Any] | None = None
    sun: dict[str, Any] | None = None
    data: dict[str, Any] | None = None
    objects: dict[str, Object] | None = None
    reporters: dict[str, Any] | None = None
    interventions: list[dict[str, Any]] = []


class Forked(_Part):
    """The parent run of a fork."""

    source: str = Field(alias="from")
    id: str = ""
    tick: Tick = 0


class Run(_Part):
    """The manifest of a run."""

    format: int = 1
    id: str = ""
    world: str = ""
    title: str = ""
    config: Config = Config.model_construct()
    config_hash: str = ""
    seed: Seed = 0
    ticks: Tick = 0
    done: Tick = 0
    dt: float = Field(1.0, gt=0)
    finished: bool = False
    digest: str = ""
    policies: str | dict[str, str] = "trained"
    weights: dict[Filename, str] = {}
    learn: bool | dict[str, bool] | None = None
    controls: list[str] = []
    command: str | None = None
    versions: dict[str, str] = {}
    target: dict[str, str] = {}
    git_commit: str | None = None
    wall_seconds: float = 0.0
    startup_seconds: float = 0.0
    snapshot_every: int | None = Field(None, ge=0)
    checkpoint_every: int | None = Field(None, ge=0)
    keep: int = 1
    record: str | None = None
    species: list[Filename] = []
    causes: list[str] = []
    colors: dict[str, str] = {}
    code: list[dict[str, str]] = []
    genomes: dict[str, dict[str, Any]] = {}
    parts: dict[Filename, Tick] = {}
    heads: dict[str, str] = {}
    asked: list[tuple[Tick, dict[str, Any]]] = []
    intervened: list[tuple[Tick, dict[str, Any]]] = []
    until: list[str] = []
    ended: dict[str, Any] | None = None
    island: Filename = ""
    archipelago: str = ""
    forked: Forked = Forked.model_construct()

    @model_validator(mode="after")
    def _has_its_species(self) -> Self:
        if "config" in self.model_fields_set and (missing := set(self.species) - set(self.config.species)):
            raise ValueError(f"config.species.{min(missing)} is missing")
        return self
