"""How many seeds an interval of a wished width needs, and the intervals so far."""

from __future__ import annotations

import numpy as np
import pytest

from ecs_eco.analysis.replicates import MOST_ROWS, Effect, seeds_section
from ecs_eco.analysis.survival import bootstrap_difference, difference_of_shares, wilson

SPREAD = np.array([9.0, 11.0] * 200)  # mean 10, standard deviation 1


def ones(k: int, n: int) -> np.ndarray:
    return np.repeat([1.0, 0.0], [k, n - k])


def test_the_number_of_seeds_is_that_of_students_t() -> None:
    one, two = Effect("mean", SPREAD), Effect("difference", SPREAD, SPREAD)
    assert one.needs(0.5) == 18  # t(17) / √18 = 0.497, t(16) / √17 = 0.514
    assert one.needs() == 7  # ±10% of 10: t(6) / √7 = 0.925, t(5) / √6 = 1.049
    assert two.needs(1.01) == 9  # √(2 / 9) t(16) = 0.999, √(2 / 8) t(14) = 1.072
    assert one.needs(0.5, level=0.995) == 36  # t(35) / √36 = 0.499, t(34) / √35 = 0.507
    assert Effect("share", ones(5, 10), share=True).needs() == 99  # t(98) / 2 √99 = 0.0997


def test_as_many_seeds_as_are_needed_give_the_wished_interval() -> None:
    rng, half = np.random.default_rng(3), []
    n = Effect("mean", SPREAD).needs(0.5)
    for _ in range(400):
        x = Effect("mean", rng.normal(10.0, 1.0, n)).after(n)
        half.append((x.high - x.low) / 2)
    assert np.mean(half) == pytest.approx(0.5, rel=0.05)


def test_what_cannot_be_known_is_not_given() -> None:
    assert Effect("zero", np.array([-1.0, 1.0])).needs() is None  # 10% of nothing
    assert Effect("constant", np.array([2.0, 2.0])).needs() == 2
    assert Effect("noise", np.array([-1e4, 1e4 + 1.0])).needs() is None  # more than a million
    assert seeds_section([Effect("one seed", np.array([1.0]))]) == []


def test_effects_that_need_too_many_seeds_to_count_come_first() -> None:
    some = [Effect(f"effect {i}", SPREAD + i) for i in range(MOST_ROWS + 5)]
    text = "".join(seeds_section([*some, Effect("noise", np.array([-1e4, 1e4 + 1.0]))]))
    assert text.index("noise") < text.index("effect 0<")


def test_intervals_after_all_seeds_are_those_of_the_report() -> None:
    a, b = SPREAD[:8], SPREAD[:8] + np.arange(8)
    assert Effect("gap", a, b).after(8) == bootstrap_difference(a, b)
    assert Effect("share", ones(3, 8), share=True).after(8) == wilson(3, 8)
    assert Effect("gap", ones(3, 8), ones(8, 8), share=True).after(8) == pytest.approx(
        difference_of_shares(3, 8, 8, 8)
    )


def test_the_table_has_the_seeds_so_far_and_all_effects_together() -> None:
    rows = [Effect(f"effect {i}", SPREAD[:8] * (1 + i)) for i in range(MOST_ROWS)]
    page = "".join(seeds_section([*rows, Effect("widest", SPREAD[:5] - 9.0)], "training seeds"))
    assert "<th>2 training seeds</th><th>3 training seeds</th><th>5 training seeds</th><th>8 " in page
    assert "for all 31 effects together" in page
    assert "about 1.55 miss" in page
    first = page[page.index("<tbody>") :].split("</tr>")[0]
    assert "widest" in first  # it needs the most
    assert "<td></td>" in first  # and has no eighth seed
    assert "Effects not shown, which need fewer training seeds: 1." in page
