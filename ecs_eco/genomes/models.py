"""A genome: its alphabet, what every gene codes for, and the operators that make new genomes of old ones."""

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
    is_absent,
    is_empty,
    quantity,
    table,
    with_keyword,
)

Expression = Literal["first", "mean", "greater"]
CopyRule = Literal["first", "mean", "sum", "greatest"]


OperatorName = Annotated[str, Field(pattern=r"^[A-Za-z_][\w.]*(:[A-Za-z_]\w*)?$"), *OF_CODE]


class Gene(Section, own=LETTERS):
    """Loci that code for one value of the organism: by a table of values, by a range,
    or as the weights of a network."""

    name: Name = about("name of the gene")
    trait: str | None = about(
        "key of the species' value that it replaces; absent: none, a neutral marker", None
    )
    letters: Annotated[int, Field(ge=1, le=64)] = quantity("letters of one codon", "1")
    at: Annotated[int, Field(ge=0, le=50_000_000)] | None = quantity(
        "first locus; absent: after the gene before", "1", None
    )
    values: list[Real] | None = about("a value for each codon in their order; several may be the same", None)
    low: Real | None = quantity("the value of the first codon", "unit of the trait", None)
    high: Real | None = quantity("the value of the last codon", "unit of the trait", None)
    code: Literal["positional", "gray", "additive"] = about(
        "positional: digits of a number; gray: so that neighboring values differ in one letter; additive: "
        "codons add up",
        "positional",
    )
    codons: Annotated[int, Field(ge=1, le=10_000)] = quantity(
        'codons that add up, for code = "additive"', "1", 1
    )
    scale: Literal["linear", "log"] = about("log: equal steps are equal factors", "linear")
    whole: bool = about(
        "whether values are rounded to whole numbers; a trait of whole numbers always is", False
    )
    form: Literal["direct", "cosine"] | None = about(
        "of a network's weights: each its codon, or low-frequency coefficients of a cosine transform of "
        "every matrix",
        None,
    )
    coefficients: Count | None = quantity('most coefficients for each matrix, for form = "cosine"', "1", None)
    mutation_rate: Share | None = quantity(
        "its own chance of a letter to mutate (indpb); absent: that of mutate", "1", None, former="mutation"
    )
    expression: Expression | None = about(
        "with two strings, how two alleles make the value; absent: that of the genome",
        None,
        former="dominance",
    )
    promoter: Annotated[str, Field(min_length=1, max_length=16)] | None = about(
        "with `max_length`: the letters that begin each copy of the gene; absent: a word chosen by its number",
        None,
        exclude_if=is_absent,
    )
    copies: Annotated[int, Field(ge=0, le=10_000)] = quantity(
        "with `max_length`: copies of the gene in a founder's string", "1", 1, exclude_if=lambda n: n == 1
    )
    copy_rule: CopyRule | None = about(
        "with `max_length`: what several copies in a string make; absent: that of the genome",
        None,
        former="doubled",
        exclude_if=is_absent,
    )


_From: Any = with_keyword(
    "from",
    Name | Annotated[list[Name], Field(min_length=1)],
    about("the gene or derived trait that the formula reads, or a list of several"),
)


class Derived(_From, own=LETTERS):  # type: ignore[call-arg]
    """A trait that no letters code for: a formula of the values of genes, so that one gene may have several
    effects. Values beyond what the trait can be become its nearest limit, whole numbers are rounded."""

    trait: str | None = about(
        "key of the species' value that it replaces; absent: the one that ends with NAME", None
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
    """Return the name of a function of `deap.tools`, which a file can say as well; "" for any other."""
    if not getattr(function, "__module__", "").startswith("deap."):
        return ""
    from deap import tools

    name = getattr(function, "__name__", "")
    return name if vars(tools).get(name) is function else ""


class Operator(Section):
    """An operator of DEAP by name, "module:name" of a similar function, or the function itself,
    and its keyword arguments.

    In Python what a DEAP toolbox has registered, `toolbox.mate`, may replace the whole section,
    or `operator`.
    """

    model_config = ConfigDict(extra="allow")

    operator: OperatorName = about("name of the operator")

    @model_validator(mode="before")
    @classmethod
    def _registered(cls, given: object) -> Any:
        """Take apart what a toolbox has registered: a partial says an operator and its arguments."""
        if callable(given):
            given = {"operator": given}
        if not isinstance(given, dict) or not callable(function := given.get("operator")):
            return given
        arguments = {key: value for key, value in given.items() if key != "operator"}
        while isinstance(function, partial):
            if function.args:
                name = getattr(function.func, "__name__", repr(function.func))
                raise ValueError(f"{name} is registered with {function.args!r}; give its arguments by name")
            if twice := [k for k, v in function.keywords.items() if arguments.setdefault(k, v) != v]:
                conflict = (
                    f"{twice[0]} = {function.keywords[twice[0]]!r} in the toolbox, "
                    f"and {arguments[twice[0]]!r} beside it"
                )
                raise ValueError(
                    f"{conflict}; give it once: toolbox.{cls.__name__.lower()} may stand for the section"
                )
            function = function.func
        return {"operator": _deaps_name(function) or function, **arguments}

    @property
    def arguments(self) -> dict[str, Any]:
        """The keyword arguments of the operator."""
        return dict(self.model_extra or {})


class Mate(Operator, own=LETTERS):
    """How two strings are crossed."""

    operator: OperatorName = about(
        "cxOnePoint, cxTwoPoint, cxUniform …; with `max_length` absent means cxUnequal", "cxTwoPoint"
    )
    chance: Share = quantity("chance of a crossing; without one the child copies one parent, drawn", "1", 1.0)


class Mutate(Operator):
    """How a string mutates."""

    operator: OperatorName = about("mutUniformInt, mutFlipBit …", "mutUniformInt")


class GenomeSection(Section, own=LETTERS):
    """The genome of a species."""

    submodel = Submodel(
        "Heredity",
        reads=("genome",),
        rules={
            "": "A genome is a string of letters. Each gene translates its letters into the value of a trait. A "
            "newborn inherits its string from its parents, with mutations.",
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
    ploidy: Literal[1, 2] = quantity("strings of an organism", "1", 1)
    expression: Expression = about(
        "with two strings: the first one's value, the mean, or the greater one", "first", former="dominance"
    )
    loci: Count | None = quantity(
        "length of a string; absent: that of the genes; loci that no gene uses are neutral", "1", None
    )
    founders: Literal["own", "random"] = about(
        "letters at the start: those that code for the species' own values, or all random", "random"
    )
    mate: Mate = table("crossover", Mate, change=FREE)
    mutate: Mutate = table("mutation", lambda: Mutate.model_validate({"indpb": 0.005}), change=FREE)
    max_length: Count | None = quantity(
        "letters that a string may have at most, which gives strings a length of their own; absent: all have "
        "the same length, and genes a fixed place",
        "1",
        None,
        former="longest",
        exclude_if=is_absent,
    )
    copy_rule: CopyRule = about(
        "with `max_length`: what several copies of a gene in a string make: the first one's value, the mean, "
        "the sum (within what one copy can say) or the greatest",
        "first",
        former="doubled",
        exclude_if=lambda how: how == "first",
    )
    insertion: Share = quantity(
        "with `max_length`: chance per letter that one is inserted before it",
        "1",
        0.0,
        exclude_if=is_empty,
        change=FREE,
    )
    base_deletion: Share = quantity(
        "with `max_length`: chance per letter to be lost",
        "1",
        0.0,
        former="deletion",
        exclude_if=is_empty,
        change=FREE,
    )
    duplication: Share = quantity(
        "with `max_length`: chance per copy of a gene to be doubled, in tandem",
        "1",
        0.0,
        exclude_if=is_empty,
        change=FREE,
    )
    gene_deletion: Share = quantity(
        "with `max_length`: chance per copy of a gene to be lost",
        "1",
        0.0,
        former="loss",
        exclude_if=is_empty,
        change=FREE,
    )
    genes: Annotated[list[Gene], Field(min_length=1)] = about("what the loci code for")
    derived: dict[Name, Derived] = about("name = trait that is a formula of genes", {}, exclude_if=is_empty)

    @model_validator(mode="before")
    @classmethod
    def _unequal_crossover(cls, given: object) -> Any:
        """Let strings of variable length cross at genes, unless an operator is named."""
        if not isinstance(given, dict) or given.get("max_length") is None:
            return given
        mate = given.get("mate", {})
        if isinstance(mate, dict) and "operator" not in mate:
            return given | {"mate": {"operator": "cxUnequal"} | mate}
        return given
