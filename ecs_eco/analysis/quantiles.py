"""Quantiles for two-sided intervals. They need scipy.special, which takes long to import."""


def normal(level: float) -> float:
    """Return the half-width of a normal interval with this confidence level [standard deviations].

    Examples
    --------
    >>> from ecs_eco.analysis import quantiles
    >>> round(quantiles.normal(0.95), 2)
    1.96
    """
    from scipy.special import ndtri

    return float(ndtri(0.5 + level / 2))


def student(df: float, level: float) -> float:
    """Return the half-width of an interval from Student's t with `df` degrees of freedom [standard errors].

    Examples
    --------
    >>> from ecs_eco.analysis import quantiles
    >>> round(quantiles.student(4, 0.95), 2)
    2.78
    """
    from scipy.special import stdtrit

    return float(stdtrit(df, 0.5 + level / 2))
