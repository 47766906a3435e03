"""A genome: its alphabet, the meaning of every gene, and the operators that create new genomes from old
ones."""

from functools import partial
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from ecs_eco.engine.submodel import Submodel
from ecs_eco.genomes.alphabet import Alphabet
from ecs_eco.inputs.section import (
    FREE,
    LETTERS,
    OF_CODE,
    Count,
    Name,
    Real,
    Section,
    Share,
    about,
    quantity,
    table,
    with_keyword,
)

Expression = Literal["first", "mean", "greater"]
CopyRule = Literal["first", "mean", "sum", "greatest"]


OperatorName = Annotated[str, Field(pattern=r"^[A-Za-z_][\w.]*(:[A-Za-z_]\w*)?$"), *OF_CODE]


class Gene(Section, own=LETTERS):
    """Loci that code for a value of an organism: a table entry, a number in a range, or a network's
    weights."""

    name: Name = about("name of the gene")
    trait: str | None = about(
        "the species' key whose value it replaces; default: none, a neutral marker", None
    )
    letters: Annotated[int, Field(ge=1, le=64)] = quantity("letters per codon", "1")
    at: Annotated[int, Field(ge=0, le=50_000_000)] | None = quantity(
        "first locus; default: after the previous gene", "1", None
    )
    values: list[Real] | None = about("a value for each codon, in order; values can repeat", None)
    low: Real | None = quantity("the value of the first codon", "unit of the trait", None)
    high: Real | None = quantity("the value of the last codon", "unit of the trait", None)
    code: Literal["positional", "gray", "additive"] = about(
        "positional: letters are digits of a number; gray: neighboring values differ in one letter; "
        "additive: codons add up",
        "positional",
    )
    codons: Annotated[int, Field(ge=1, le=10_000)] = quantity(
        'codons that add up, for code = "additive"', "1", 1
    )
    scale: Literal["linear", "log"] = about("log: equal steps are equal factors", "linear")
    whole: bool = about("whether values are rounded to integers; values of integer traits always are", False)
    form: Literal["direct", "cosine"] | None = about(
        "coding of a network's weights: one codon per weight, or low-frequency coefficients of a cosine "
        "transform of every matrix",
        None,
    )
    coefficients: Count | None = quantity(
        'maximum number of coefficients per matrix, for form = "cosine"', "1", None
    )
    mutation_rate: Share | None = quantity(
        "mutation probability per letter (indpb); default: the same as in mutate",
        "1",
        None,
        former="mutation",
    )
    expression: Expression | None = about(
        "with two strings, how two alleles combine; default: as for the genome", None, former="dominance"
    )
    promoter: Annotated[str, Field(min_length=1, max_length=16)] | None = about(
        "with `max_length`: letters that begin each copy of the gene; default: a word derived from its number",
        omit=True,
    )
    copies: Annotated[int, Field(ge=0, le=10_000)] = quantity(
        "with `max_length`: copies of the gene in a founder's string", "1", 1, omit=True
    )
    copy_rule: CopyRule | None = about(
        "with `max_length`: how several copies in a string combine; default: as for the genome",
        None,
        former="doubled",
        omit=True,
    )


_From: Any = with_keyword(
    "from",
    Name | Annotated[list[Name], Field(min_length=1)],
    about("the gene or derived trait that the formula reads, or a list of these"),
)


class Derived(_From, own=LETTERS):  # type: ignore[call-arg]
    """A trait without letters, computed from genes by a formula; it lets one gene have several effects.
    Values beyond the trait's limits are set to the nearest limit, and integers are rounded."""

    trait: str | None = about(
        "the species' key whose value it replaces; default: the key that ends with NAME", None
    )
    formula: Annotated[str, Field(max_length=1000)] = about(
        "formula of the values of genes and other derived traits, by name"
    )

    @property
    def read(self) -> list[str]:
        """The genes and derived traits that its formula reads."""
        given: str | list[str] = getattr(self, "from")
        return [given] if isinstance(given, str) else given


def _deaps_name(function: object) -> str:
    """Return the name of a function in `deap.tools`, which world files can also use; "" for other functions."""
    if not getattr(function, "__module__", "").startswith("deap."):
        return ""
    from deap import tools

    name = getattr(function, "__name__", "")
    return name if vars(tools).get(name) is function else ""


class Operator(Section):
    """A DEAP operator by name, a function of the same kind given as "module:name", or the function itself,
    with its keyword arguments.

    In Python, a function registered in a DEAP toolbox, such as `toolbox.mate`, can replace the whole section,
    or just `operator`.
    """

    model_config = ConfigDict(extra="allow")

    operator: OperatorName = about("name of the operator")

    @model_validator(mode="before")
    @classmethod
    def _registered(cls, given: object) -> Any:
        """Split a function registered in a toolbox: a partial contains an operator and its arguments."""
        if callable(given):
            given = {"operator": given}
        if not isinstance(given, dict) or not callable(function := given.get("operator")):
            return given
        arguments = {key: value for key, value in given.items() if key != "operator"}
        while isinstance(function, partial):
            if function.args:
                name = getattr(function.func, "__name__", repr(function.func))
                raise ValueError(f"{name} is registered with {function.args!r}; pass its arguments by name")
            if twice := [k for k, v in function.keywords.items() if arguments.setdefault(k, v) != v]:
                conflict = (
                    f"{twice[0]} = {function.keywords[twice[0]]!r} in the toolbox, "
                    f"but {arguments[twice[0]]!r} in the section"
                )
                raise ValueError(
                    f"{conflict}; use only one: toolbox.{cls.__name__.lower()} can replace the section"
                )
            function = function.func
        return {"operator": _deaps_name(function) or function, **arguments}

    @property
    def arguments(self) -> dict[str, Any]:
        """The keyword arguments of the operator."""
        return dict(self.model_extra or {})


class Mate(Operator, own=LETTERS):
    """The crossover of two strings."""

    operator: OperatorName = about(
        "cxOnePoint, cxTwoPoint, cxUniform …; default with `max_length`: cxUnequal", "cxTwoPoint"
    )
    chance: Share = quantity(
        "probability of crossover; otherwise, the child copies a random parent's genome", "1", 1.0
    )


class Mutate(Operator):
    """The mutation of a string."""

    operator: OperatorName = about("mutUniformInt, mutFlipBit …", "mutUniformInt")


class GenomeSection(Section, own=LETTERS):
    """The genome of a species."""

    submodel = Submodel(
        "Heredity",
        reads=("genome",),
        rules={
            "": "A genome is a string of letters. Each gene translates its letters into the value of a trait; "
            "a gene without a trait is neutral. A newborn inherits its string from its parents, with mutations.",
            "genome.mutate.operator=mutUniformInt": "Each letter is replaced by one drawn from the alphabet with "
            "probability `indpb`.",
            "reproduction.kind=sexual": "The strings of both parents are crossed.",
            "genome.founders=random": "Founders have random letters.",
            "genome.founders=own": "Founders have the letters that code for the values of their species.",
        },
        changes=("Genome",),
        draws="crossover, mutation, and letters of founders",
    )

    alphabet: Annotated[
        str, Field(min_length=2, max_length=256), AfterValidator(lambda letters: Alphabet(letters).letters)
    ] = about("letters, in an order of your choice", "ACGT")
    ploidy: Literal[1, 2] = quantity("strings per organism", "1", 1)
    expression: Expression = about(
        "with two strings: the first value, the mean, or the greater value", "first", former="dominance"
    )
    loci: Count | None = quantity(
        "length of a string; default: the length of all genes; loci that no gene uses are neutral", "1", None
    )
    founders: Literal["own", "random"] = about(
        "letters at the start: letters that code for the species' own values, or random letters", "random"
    )
    mate: Mate = table("crossover", Mate, change=FREE)
    mutate: Mutate = table("mutation", lambda: Mutate.model_validate({"indpb": 0.005}), change=FREE)
    max_length: Count | None = quantity(
        "maximum letters per string, which lets strings vary in length; default: all strings have the same "
        "length, and genes have fixed positions",
        "1",
        None,
        former="longest",
        omit=True,
    )
    copy_rule: CopyRule = about(
        "with `max_length`: how several copies of a gene in a string combine: the first copy's value, the "
        "mean, the sum (within the range of one copy) or the greatest value",
        "first",
        former="doubled",
        omit=True,
    )
    insertion: Share = quantity(
        "with `max_length`: probability of an insertion before each letter", "1", 0.0, omit=True, change=FREE
    )
    base_deletion: Share = quantity(
        "with `max_length`: probability that a letter is deleted",
        "1",
        0.0,
        former="deletion",
        omit=True,
        change=FREE,
    )
    duplication: Share = quantity(
        "with `max_length`: probability that a copy of a gene is duplicated in tandem",
        "1",
        0.0,
        omit=True,
        change=FREE,
    )
    gene_deletion: Share = quantity(
        "with `max_length`: probability that a copy of a gene is lost",
        "1",
        0.0,
        former="loss",
        omit=True,
        change=FREE,
    )
    genes: Annotated[list[Gene], Field(min_length=1)] = about("the values for which the loci code")
    derived: dict[Name, Derived] = about("name = a trait that is a formula of genes", {}, omit=True)

    @model_validator(mode="before")
    @classmethod
    def _unequal_crossover(cls, given: object) -> Any:
        """Cross strings of variable length at genes, unless an operator is named."""
        if not isinstance(given, dict) or given.get("max_length") is None:
            return given
        mate = given.get("mate", {})
        if isinstance(mate, dict) and "operator" not in mate:
            return given | {"mate": {"operator": "cxUnequal"} | mate}
        return given
