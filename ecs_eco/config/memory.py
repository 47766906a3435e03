"""The memory that a world needs at its start, estimated from its numbers alone, and the machine's memory."""

import math
import os
from collections.abc import Iterator
from pathlib import Path

from ecs_eco.config.explain import value_at
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key
from ecs_eco.engine.errors import MISSING, ConfigError, Problem

ROW = 160  # bytes per organism or object, excluding senses, learning and genome
MOST_SHOWN = 5
CGROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def require_memory(config: WorldConfig, available: float | None = None) -> None:
    """Raise a ConfigError if a world needs more memory at its start than is available [bytes]."""
    available = machine_memory() if available is None else available
    parts = sorted(needs(config), key=lambda part: -part[1])
    total = sum(size for _, size in parts)
    if total <= available:
        return
    largest = [part for part in parts if part[1] > total / 10][:MOST_SHOWN]
    problems = [
        Problem(
            key,
            f"needs about {in_words(size)}",
            MISSING if isinstance(value := value_at(config.model_dump(), key), dict) else value,
            f"a value small enough for {in_words(available)} in total",
            source=config._source,
        )
        for key, size in largest
    ]
    title = f"it needs about {in_words(total)} of memory at its start; available: {in_words(available)}"
    raise ConfigError(problems, f"{config._source}: {title}")


def needs(config: WorldConfig) -> Iterator[tuple[Key, float]]:
    """Yield the key and size [bytes] of all that a world allocates at its start and in its first rollout."""
    for name, field in config.fields.items():
        cells = math.prod(max(1.0, s / field.cell) for s in config.space.size)
        yield ("fields", name, "cell"), (12 if field.substance is None else 32) * cells
    if config.terrain is not None:
        cells = math.prod(max(1.0, s / config.terrain.cell) for s in config.space.size[:2])
        yield ("terrain", "cell"), 16 * cells
    for name, kind in config.objects.items():
        yield ("objects", name, "count"), ROW * (kind.count + len(kind.at))
    for name, species in config.species.items():
        yield from _of_species(config, name, species)


def n_weights(species: Species, dims: int) -> int:
    """Return the number of weights in the policy network of a species."""
    outputs = len(species.action_list()) + len(species.ranges()) + 1
    widths = [len(species.channels(dims)), *species.policy.hidden, outputs]
    return sum((a + 1) * b for a, b in zip(widths, widths[1:], strict=False))


def _of_species(config: WorldConfig, name: str, species: Species) -> Iterator[tuple[Key, float]]:
    rows, key, channels = max(64, 1.5 * species.count), ("species", name), len(species.channels(config.dims))
    weights = n_weights(species, config.dims)
    yield (*key, "count"), rows * (ROW + 8 * channels + 4 * len(config.substances))
    if species.genome is not None:
        loci = (
            species.genome.max_length
            or species.genome.loci
            or sum(
                gene.letters
                * (weights if gene.trait == "policy.weights" and gene.form != "cosine" else gene.codons)
                for gene in species.genome.genes
            )
        )
        yield (*key, "genome"), 2.0 * rows * species.genome.ploidy * loci
    if not species.policy.thinks:
        return
    # the memory of a custom module is unknown until it is created
    size = 0 if species.policy.network else weights
    horizon = species.ppo["horizon"]
    if species.policy.kind == "individual":
        blocks = 256.0 * math.ceil(max(1, species.count) / 256)
        yield (*key, "policy", "hidden"), 12 * blocks * size
        yield (*key, "ppo", "horizon"), blocks * horizon * (4 * channels + 24)
    else:
        yield (*key, "policy", "hidden"), 16.0 * size + 16.0 * 2048 * sum(species.policy.hidden)
        steps = float(species.count) * min(horizon, config.ticks)
        yield (*key, "ppo", "horizon"), steps * (4 * channels + 24) * species.policy.learn


def machine_memory() -> float:
    """Return the memory available to this process [bytes]; infinite if the system does not report it."""
    limits = [math.inf]
    try:
        limits.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        limits += [soft] if soft != resource.RLIM_INFINITY else []
    except (ImportError, AttributeError, ValueError, OSError):  # not available on every system
        pass
    for file in CGROUPS:
        try:
            limits.append(int(Path(file).read_text(encoding="ascii")))
        except (OSError, ValueError):  # "max": no limit
            continue
    return min(limits)


def in_words(size: float) -> str:
    """Return bytes as text such as "3.2 GB"."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} PB"
