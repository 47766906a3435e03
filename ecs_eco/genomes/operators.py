"""DEAP's operators on genomes: a toolbox with `mate`, `mutate` and `select_mate`.

A DEAP operator that has a kernel runs as that kernel for all births at once; any other function in
the toolbox is called for each birth with lists of integers, as in DEAP.
"""

import inspect
import random
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from ecs_eco.engine.errors import UnknownName, listed, nearest, unknown_name
from ecs_eco.genomes.choices import RULES
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.models import Gene, GenomeSection
from ecs_eco.genomes.unequal import SLIP, UnequalCrossover
from ecs_eco.inputs.code import handed_over

if TYPE_CHECKING:
    from deap.base import Toolbox

TRIALS = 20
PREFIX = {"mate": "cx", "mutate": "mut"}
LONGEST_TRIED = 10_000  # maximum length of the strings on which an operator is tried
# DEAP operators that world files can name, and the arguments of each
SAFE: dict[str, dict[str, tuple[str, ...]]] = {
    "mate": {"cxOnePoint": (), "cxTwoPoint": (), "cxUniform": ("indpb",)},
    "mutate": {
        "mutFlipBit": ("indpb",),
        "mutInversion": (),
        "mutShuffleIndexes": ("indpb",),
        "mutUniformInt": ("low", "up", "indpb"),
    },
}
# additional operators for strings of variable length: ours and DEAP's
VARIABLE: dict[str, dict[str, tuple[str, ...]]] = {
    "mate": {"cxUnequal": ("slip",), "cxMessyOnePoint": ()},
    "mutate": {},
}
_NUMBERS = "it produces numbers between letters"
_STRATEGY = "it needs a strategy in addition to the genome"
_ORDER = "it permutes a genome that contains every letter once"
REFUSED = {  # DEAP operators that cannot work on letters
    "cxBlend": _NUMBERS,
    "cxSimulatedBinary": _NUMBERS,
    "cxSimulatedBinaryBounded": _NUMBERS,
    "mutGaussian": _NUMBERS,
    "mutPolynomialBounded": _NUMBERS,
    "cxESBlend": _STRATEGY,
    "cxESTwoPoint": _STRATEGY,
    "cxESTwoPoints": _STRATEGY,
    "mutESLogNormal": _STRATEGY,
    "cxPartialyMatched": _ORDER,
    "cxUniformPartialyMatched": _ORDER,
    "cxOrdered": _ORDER,
    "cxMessyOnePoint": "it changes the length of a genome, which needs genome.max_length",
    "cxTwoPoints": "its name is now cxTwoPoint",
}


def toolbox_of(
    section: GenomeSection | Mapping[str, Any],
    layout: Layout,
    select_mate: str = "nearest",
    find: Callable[[Any], Any] = handed_over,
    mates: bool = True,
) -> "Toolbox":
    """Return a DEAP toolbox with `mate`, `mutate` and `select_mate`.

    Parameters
    ----------
    section : GenomeSection or Mapping
        A `genome` section of a world file, or a dict with `mate` and `mutate`, such as {"mutate":
        {"operator": "mutUniformInt", "indpb": 0.01}}.
    layout : Layout
    select_mate : {"nearest", "random", "richest", "oldest"}
        The mate-choice rule.
    find : callable, optional
        Returns the function for "module:name", like `WorldConfig.function`; by default, only functions are
        accepted.
    mates : bool, default True
        Whether `mate` is used and must be checked.

    Returns
    -------
    deap.base.Toolbox

    Raises
    ------
    ValueError
        If an operator cannot work on these genomes; the message gives the reason.
    UnknownName
        If DEAP does not have an operator.

    Notes
    -----
    DEAP operators that have a kernel (cxOnePoint, cxTwoPoint, cxUniform, mutUniformInt …) run as this kernel
    for all births at once; other functions are called for each birth with lists of integers.

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, Layout, toolbox_of
    >>> layout = Layout([Gene(name="size", trait="size", letters=8, low=0.0, high=1.0)])
    >>> toolbox = toolbox_of({"mutate": {"operator": "mutUniformInt", "indpb": 1.0}}, layout)
    >>> len(toolbox.mutate([0] * 8)[0])
    8
    """
    from deap.base import Toolbox

    toolbox = Toolbox()
    if not isinstance(section, GenomeSection):
        section = GenomeSection(**{"genes": [Gene(name="any", letters=1, low=0.0, high=1.0)], **section})
    for word in ("mate", "mutate"):
        entry = getattr(section, word)
        arguments = defaults(entry.operator, layout) | entry.arguments
        toolbox.register(word, operator_of(word, entry.operator, layout, find), **arguments)
    if select_mate not in RULES:
        raise UnknownName(unknown_name("select_mate", "rule", select_mate, RULES))
    toolbox.register("select_mate", RULES[select_mate])
    for word in ("mate", "mutate") if mates else ("mutate",):
        check_operator(word, getattr(toolbox, word), layout)
    return toolbox


def operator_of(
    word: str, name: object, layout: Layout, find: Callable[[Any], Any] = handed_over
) -> Callable[..., Any]:
    """Return the operator with this name, or the result of `find` for a function or "module:name"."""
    if not isinstance(name, str) or ":" in name:
        return find(name)
    check_name(word, name, layout)
    if name == "cxUnequal":
        return UnequalCrossover(layout)  # type: ignore[arg-type]  # the check of the name ensures this
    from deap import tools

    return getattr(tools, name)


def known_operators(word: str, layout: Layout) -> dict[str, tuple[str, ...]]:
    """Return the operators that world files can name for genomes with a given layout, and the arguments of
    each."""
    return SAFE[word] | (VARIABLE[word] if layout.longest is not None else {})


def check_name(word: str, name: str, layout: Layout) -> None:
    """Raise ValueError or UnknownName unless a name is one of the known operators."""
    known = known_operators(word, layout)
    if name == "cxUnequal" and name not in known:
        raise ValueError(
            f"{word}: {name} cuts strings at genes, which needs genome.max_length; "
            f"expected {listed(known, 30)}"
        )
    if name in REFUSED and name not in known and name.startswith(PREFIX[word]):
        raise ValueError(
            f"{word}: {name} does not work on genomes: {REFUSED[name]}; expected {listed(known, 30)}"
        )
    if name not in known:
        raise UnknownName(unknown_name(word, "operator", name, known))


def defaults(name: object, layout: Layout) -> dict[str, Any]:
    """Return an operator's default arguments; mutUniformInt draws from all letters."""
    if name == "cxUnequal":
        return {"slip": SLIP}
    return {"low": 0, "up": len(layout.alphabet) - 1} if name == "mutUniformInt" else {}


def check_entry(word: str, name: str, given: Mapping[str, Any], layout: Layout, used: bool = True) -> None:
    """Raise ValueError or UnknownName if an operator or its arguments do not fit; nothing is called."""
    check_name(word, name, layout)
    takes, given = known_operators(word, layout)[name], defaults(name, layout) | dict(given)
    if wrong := [k for k in given if k not in takes]:
        raise ValueError(
            f"{word}: {name}: got an unexpected keyword argument '{wrong[0]}'; {_takes(takes, wrong[0])}"
        )
    if missing := [k for k in takes if k not in given]:
        raise ValueError(f"{word}: {name}: missing a required argument: '{missing[0]}'; {_takes(takes)}")
    if used:
        _check_values(word, name, given, layout)


def check_operator(word: str, operator: Callable[..., Any], layout: Layout) -> None:
    """Raise ValueError if an operator cannot work on these genomes; a user-defined function is tried."""
    from deap import tools

    function, arguments = taken_apart(word, operator)
    name = getattr(function, "__name__", repr(function))
    deaps = vars(tools).get(name) is function
    known = known_operators(word, layout)
    if name in REFUSED and deaps and name not in known:
        raise ValueError(f"{word}: {name} does not work on genomes: {REFUSED[name]}")
    _check_values(word, name, arguments, layout)
    if not (deaps and name in known):
        _try(word, name, operator, layout)


def _check_values(word: str, name: str, arguments: Mapping[str, Any], layout: Layout) -> None:
    """Raise ValueError if this operator or its arguments do not fit genomes of the layout."""
    if name == "mutFlipBit" and len(layout.alphabet) > 2:
        letters = layout.alphabet.letters
        raise ValueError(
            f"{word}: mutFlipBit exchanges 0 and 1, but {letters!r} has {len(letters)} letters; use mutUniformInt"
        )
    if layout.length < 2 and name in ("cxOnePoint", "cxTwoPoint", "mutShuffleIndexes"):
        raise ValueError(f"{word}: {name} needs at least two loci, but the genome has {layout.length}")
    if name == "mutUniformInt":
        _check_letters(word, arguments, layout)
    for share in ("indpb", "slip"):
        given = arguments.get(share, 0)
        if not isinstance(given, int | float) or not 0 <= given <= 1:
            raise ValueError(f"{word}: {name} with {share} = {given}; expected 0 to 1")
    own = [code.name for code in layout.genes if code.gene.mutation_rate is not None]
    if own and layout.longest is not None and word == "mutate" and name not in (*SAFE[word],):
        raise ValueError(
            f"mutate: {name} ignores the positions of genes, so the gene {own[0]!r} cannot have "
            "its own mutation_rate"
        )
    if word == "mutate" and own and ("indpb" not in arguments or name == "mutShuffleIndexes"):
        why = "moves letters from gene to gene" if name == "mutShuffleIndexes" else "has no indpb"
        raise ValueError(f"mutate: {name} {why}, so the gene {own[0]!r} cannot have its own mutation_rate")


def _check_letters(word: str, arguments: Mapping[str, Any], layout: Layout) -> None:
    """Raise ValueError if `low` and `up` are not letters of the genome, or low is above up."""
    for key in ("low", "up"):
        value, size = arguments[key], len(layout.alphabet)
        if not _letters(value, size):
            raise ValueError(f"{word}: mutUniformInt with {key} = {value}; expected 0 to {size - 1}")
        if not isinstance(value, list | tuple):
            continue
        given = f"{word}: mutUniformInt with {len(value)} numbers as {key}; expected one"
        if layout.longest is not None:
            raise ValueError(f"{given}, because genes have no fixed positions")
        if len(value) < layout.length:
            raise ValueError(f"{given}, or {layout.length}: one per locus")
    low, up = (np.atleast_1d(arguments[key])[: layout.length] for key in ("low", "up"))
    if (low > up).any():
        raise ValueError(
            f"{word}: mutUniformInt with low = {arguments['low']} above up = {arguments['up']}; "
            "expected low <= up"
        )


def taken_apart(word: str, operator: Callable[..., Any]) -> tuple[Callable[..., Any], dict[str, Any]]:
    """Return the registered function and its arguments by name; raise ValueError if one is missing."""
    function, named = getattr(operator, "func", operator), dict(getattr(operator, "keywords", {}))
    name = getattr(function, "__name__", repr(function))
    if getattr(operator, "args", ()):
        raise ValueError(f"{word}: {name} is registered with {operator.args!r}; pass its arguments by name")  # type: ignore[attr-defined]
    signature = inspect.signature(function)
    genomes = 2 if word == "mate" else 1
    takes = list(signature.parameters)[genomes:]
    try:
        bound = signature.bind(*[None] * genomes, **named)
    except TypeError as error:
        wrong = [k for k in named if k not in takes]
        raise ValueError(f"{word}: {name}: {error}; {_takes(takes, *wrong[:1])}") from None
    bound.apply_defaults()
    return function, {k: v for k, v in bound.arguments.items() if k in takes}


def _takes(takes: Iterable[str], wrong: str = "") -> str:
    guess = nearest(wrong, takes) if wrong else ""
    return f"its arguments are {listed(takes)}" + (f'; did you mean "{guess}"?' if guess else "")


def choice_of(toolbox: "Toolbox") -> int:
    """Return the index of the toolbox's `select_mate` in CHOICES, −1 for a user-defined function."""
    rules = list(RULES.values())
    function = getattr(toolbox.select_mate, "func", toolbox.select_mate)
    return rules.index(function) if function in rules else -1


def strings_of(word: str, name: str, result: object, length: int | None, size: int) -> list[np.ndarray]:
    """Return the genomes u8[length] that an operator returned (None: of any length). Raises ValueError."""
    n = 2 if word == "mate" else 1
    if not isinstance(result, tuple) or len(result) != n:
        allowed = f"a tuple of {'two genomes' if n == 2 else 'one genome'}, as DEAP's operators return"
        raise ValueError(
            f"{word}: {name} returns {type(result).__name__} {str(result)[:60]}; expected {allowed}"
        )
    return [_string(word, name, genome, length, size) for genome in result]


def _string(word: str, name: str, genome: Sequence[Any], length: int | None, size: int) -> np.ndarray:
    if length is None and not len(genome):
        return np.zeros(0, np.uint8)
    if length is not None and len(genome) != length:
        raise ValueError(
            f"{word}: {name} returns a genome of {len(genome)} loci; expected {length}: "
            "genomes keep their length"
        )
    try:
        letters = np.frombuffer(bytes(list(genome)), np.uint8)  # the fastest way to check a list of integers
        if letters.max() < size:
            return letters
    except (TypeError, ValueError):
        pass
    at, letter = next((i, x) for i, x in enumerate(genome) if not (_is_whole(x) and 0 <= x < size))
    allowed = f"whole numbers from 0 to {size - 1}"
    raise ValueError(
        f"{word}: {name} puts {letter!r}, which is not a letter, at position {at}; expected {allowed}"
    )


def _is_whole(letter: object) -> TypeGuard[int]:
    return isinstance(letter, int | np.integer)


def _letters(value: object, size: int) -> bool:
    values = value if isinstance(value, list | tuple | np.ndarray) else [value]
    return all(_is_whole(v) and 0 <= v < size for v in values)


_one_thread = threading.RLock()


@contextmanager
def kept_random() -> Iterator[None]:
    """Restore the state of Python's random number generator after this context, which one thread enters at a
    time, because all threads share this state."""
    with _one_thread:
        state = random.getstate()
        try:
            yield
        finally:
            random.setstate(state)


def _try(word: str, name: str, operator: Callable[..., Any], layout: Layout) -> None:
    size, length = len(layout.alphabet), min(layout.length, LONGEST_TRIED)
    expected = length if layout.longest is None else None
    numbers = str(np.random.get_state())  # noqa: NPY002
    try:
        with kept_random():
            for trial in range(TRIALS):
                random.seed(trial)
                lengths = [length if expected else random.randrange(1, length + 1) for _ in range(2)]
                lengths = lengths[: 2 if word == "mate" else 1]
                pair = [[random.randrange(size) for _ in range(n)] for n in lengths]
                strings_of(word, name, operator(*pair), expected, size)
    except (TypeError, AttributeError, IndexError, KeyError, ZeroDivisionError, OverflowError) as error:
        raise ValueError(
            f"{word}: {name} fails on a list of letter numbers: {type(error).__name__}: {error}"
        ) from error
    if str(np.random.get_state()) != numbers:  # noqa: NPY002
        raise ValueError(
            f"{word}: {name} draws from numpy's global random numbers; use Python's random, "
            "which is seeded for each birth"
        )
