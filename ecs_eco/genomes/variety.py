"""Genetic variation in a population: allele frequencies, diversity, and DEAP's statistics."""

import numpy as np
from deap import tools

from ecs_eco.genomes.codes import Weights
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.variable_layout import VariableLayout


def frequencies(layout: Layout, loci: np.ndarray) -> dict[str, dict[float, float]]:
    """Return the allele frequencies of each gene: the share of strings with each value.

    Parameters
    ----------
    layout : Layout
    loci : array of uint8, shape (n, row)

    Returns
    -------
    dict of str to dict of float to float
        By gene, then by value. Genes for whole networks are omitted.

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, Layout, frequencies
    >>> layout = Layout([Gene(name="horns", trait="horns", letters=1, values=[0.0, 1.0, 2.0, 3.0])])
    >>> frequencies(layout, layout.rows(["A", "A", "A", "C"]))
    {'horns': {0.0: 0.75, 1.0: 0.25}}
    """
    out = {}
    for code in layout.genes:
        if not isinstance(code, Weights):
            values, counts = np.unique(layout.alleles(loci, code.name), return_counts=True)
            out[code.name] = dict(zip(values.tolist(), (counts / counts.sum()).tolist(), strict=True))
    return out


def diversity(layout: Layout, loci: np.ndarray) -> np.ndarray:
    """Return the expected heterozygosity of each locus.

    Parameters
    ----------
    layout : Layout
    loci : array of uint8, shape (n, row)

    Returns
    -------
    array of float64, shape (length,)

    Raises
    ------
    ValueError
        If strings vary in length, because they have no loci in common.

    Notes
    -----
    1 − Σ p², where p are the shares of the letters (Nei 1973).

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, Layout, diversity
    >>> layout = Layout([Gene(name="horns", trait="horns", letters=1, low=0.0, high=1.0)])
    >>> diversity(layout, layout.rows(["A", "A", "C", "C"])).tolist()
    [0.5]
    """
    if layout.longest is not None:
        raise ValueError(
            "diversity: strings of variable length have no loci in common; "
            "count values with frequencies(), or copies with layout.copy_numbers()"
        )
    strings = layout.check(loci).reshape(-1, layout.length)
    if not len(strings):
        return np.zeros(layout.length)
    shares = np.stack([(strings == letter).mean(axis=0) for letter in range(len(layout.alphabet))])
    return 1.0 - (shares**2).sum(axis=0)


class GenomeStatistics(tools.MultiStatistics):
    """DEAP's MultiStatistics for each gene's values, and for diversity or numbers of letters and copies."""

    def __init__(self, layout: Layout) -> None:
        names = [code.name for code in layout.genes if not isinstance(code, Weights)]
        copies = [f"copies of {code.name}" for code in layout.genes]
        more = ["diversity"] if layout.longest is None else ["letters", *copies]
        super().__init__({name: tools.Statistics() for name in [*names, *more]})
        self.layout = layout

    def compile(self, data: np.ndarray) -> dict[str, dict[str, float]]:
        """Return {gene: {statistic: value}} for genomes u8[n, loci], in the form that a Logbook records."""
        loci = np.asarray(data, np.uint8)
        columns = self.layout.decode(loci)
        if isinstance(self.layout, VariableLayout):
            numbers = self.layout.copy_numbers(loci)
            columns |= {f"copies of {name}": n for name, n in numbers.items()}
            columns["letters"] = self.layout.lengths(loci).sum(axis=1)
        else:
            columns["diversity"] = diversity(self.layout, loci)
        return {name: entry.compile(columns[name]) for name, entry in self.items()}


def statistics(layout: Layout) -> GenomeStatistics:
    """Return DEAP statistics for genomes, with mean, std, min and max for each gene and for diversity.

    Parameters
    ----------
    layout : Layout

    Returns
    -------
    GenomeStatistics
        A `deap.tools.MultiStatistics`: register more functions, and call `compile(loci)`.

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, Layout, statistics
    >>> layout = Layout([Gene(name="horns", trait="horns", letters=1, values=[0.0, 1.0, 2.0, 3.0])])
    >>> float(statistics(layout).compile(layout.rows(["A", "C"]))["horns"]["mean"])
    0.5
    """
    per_gene = GenomeStatistics(layout)
    for name, function in {"mean": np.mean, "std": np.std, "min": np.min, "max": np.max}.items():
        per_gene.register(name, function)
    return per_gene
