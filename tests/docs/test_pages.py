"""Statements of pages that no snippet checks: BibTeX, columns that R reads, tables of seeds, world files."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pyarrow.dataset as ds
import pytest
import yaml
from scipy import stats

from ecs_eco.analysis.survival import wilson
from ecs_eco.record import run_to_folder

ROOT = Path(__file__).parents[2]
HOW_TO = ROOT / "docs" / "how-to"


def bibtex(entry: str, page: str) -> dict[str, str]:
    """Return the fields of a BibTeX entry on a page."""
    body = re.search(rf"@\w+{{{entry},\n(.*?)\n}}", page, re.DOTALL)
    assert body, entry
    return {key: value.strip("{}") for key, value in re.findall(r"(\w+)\s*= (.+?),?$", body[1], re.MULTILINE)}


def test_bibtex_of_the_page_follows_from_the_citation_file() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    page = (HOW_TO / "cite.md").read_text(encoding="utf-8")
    paper = citation["references"][0]
    authors = " and ".join(f"{a['family-names']}, {a['given-names']}" for a in paper["authors"])
    assert bibtex("ecs_eco", page) == {
        "author": citation["authors"][0]["name"],
        "title": citation["title"],
        "version": citation["version"],
        "year": citation["date-released"][:4],
        "license": citation["license"],
    }
    assert bibtex("strannegard2021ecosystem", page) == {
        "author": authors,
        "title": paper["title"],
        "year": str(paper["year"]),
    }
    assert f"ecs-eco {citation['version']} (" in page


def test_columns_that_r_reads_are_in_a_run(tmp_path: Path) -> None:
    page = (HOW_TO / "read_in_r.md").read_text(encoding="utf-8")
    run_to_folder("predator-prey", 1, 3, tmp_path / "my-run", "random", report=False)

    def columns(kind: str) -> set[str]:
        return set(ds.dataset(tmp_path / "my-run" / kind).schema.names)

    selected = re.search(r'"my-run/series"\) \|> select\((.*?)\)', page)
    counted = re.search(r'"my-run/deaths"\).*count\((.*?)\)', page)
    cast = re.findall(r"cast\((\w+), utf8\(\)\)", page)
    assert selected
    assert counted
    assert {"tick", "species", "n"} <= set(selected[1].split(", ")) <= columns("series")
    assert set(counted[1].split(", ")) == {"species", "cause"} <= columns("deaths")
    assert set(cast) == {"uid", "parent"} <= columns("births")
    assert "died: starved" in page
    assert "died: starved" in columns("series")


def power(n: int, effect: float) -> float:
    """Return the power of a two-sided t test at the 5% level with n samples per arm."""
    df, shift = 2 * n - 2, effect * (n / 2) ** 0.5
    edge = stats.t.ppf(0.975, df)
    return float(stats.nct.sf(edge, df, shift) + stats.nct.cdf(-edge, df, shift))


def test_tables_of_seeds_are_those_of_the_exact_tests() -> None:
    page = (HOW_TO / "how_many_seeds.md").read_text(encoding="utf-8")
    means = re.findall(r"^\| ([\d.]+) \| (\d+) \| (\d+) \|$", page, re.MULTILINE)
    assert len(means) == 6
    for effect, *seeds in means:
        for n, wanted in zip(map(int, seeds), (0.8, 0.9), strict=True):
            assert power(n, float(effect)) >= wanted > power(n - 1, float(effect)), effect
    shares = re.findall(r"^\| (\d+) of (\d+)(?: runs)? \| ([\d.]+) to 1 \|$", page, re.MULTILINE)
    assert len(shares) == 5
    for all_of, n, low in shares:
        assert all_of == n
        assert round(wilson(int(n), int(n)).low, 2) == float(low)


def fisher_power(n: int, a: float, b: float) -> float:
    """Return the power of Fisher's exact test at the 5% level with n samples per arm."""
    chances = [[stats.binom.pmf(k, n, share) for k in range(n + 1)] for share in (a, b)]
    return sum(
        chances[0][i] * chances[1][j]
        for i in range(n + 1)
        for j in range(n + 1)
        if chances[0][i] * chances[1][j] > 1e-9
        and stats.fisher_exact([[i, n - i], [j, n - j]]).pvalue <= 0.05
    )


@pytest.mark.parametrize(("a", "b", "n"), [(0.1, 0.9, 7), (0.2, 0.8, 12), (0.5, 1.0, 12), (0.5, 0.9, 23)])
def test_seeds_for_shares_have_the_power_that_the_page_says(a: float, b: float, n: int) -> None:
    page = (HOW_TO / "how_many_seeds.md").read_text(encoding="utf-8")
    assert f"| {a:g} and {b:g} | {n} |" in page
    assert fisher_power(n, a, b) >= 0.8 > fisher_power(n - 1, a, b)


@pytest.mark.parametrize("page", sorted(HOW_TO.glob("*.md")), ids=lambda p: p.stem)
def test_toml_of_a_page_is_toml(page: Path) -> None:
    for block in re.findall(
        r"^```toml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    ):
        tomllib.loads(block)


def test_voles_of_the_page_are_those_that_their_sources_give() -> None:
    page = (HOW_TO / "units.md").read_text(encoding="utf-8")
    burned = 4.82 * 40**0.734  # [kJ/day], Nagy 2005
    useful = 600 * 0.1 * 16.7 * 0.6 * 2500 / 365.25  # [kJ/day]
    assert f"{burned:.1f} kJ/day at 40 g" in page
    assert f"= {useful:,.0f} kJ a day" in page
    assert f"= {useful / burned:.0f} voles, or {useful / burned * 4:.0f} per hectare" in page


def result(name: str) -> Any:
    """Return the stored result of a study."""
    return json.loads((ROOT / f"studies/results/{name}.json").read_text(encoding="utf-8"))


def words(page: Path) -> str:
    """Return the text of a page with single spaces."""
    return " ".join(page.read_text(encoding="utf-8").split())


def test_numbers_of_isolation_are_those_of_the_study() -> None:
    isolation = result("isolation")
    arms = {row[0]: row[1:] for row in isolation["table"]["rows"]}
    value = {line["statement"]: line["value"] for line in isolation["verdicts"]}
    gain = value["H_T, isolated minus panmictic"]
    differ = value["policy divergence over all pairs [nats], isolated minus panmictic"]
    wright = [v for statement, v in value.items() if "relative to Wright's" in statement]
    page = words(HOW_TO / "archipelago.md")
    for text in (
        f"heterozygosity of {arms['isolated'][0]:.3f} on average, against {arms['panmictic'][0]:.3f}",
        f"heterozygosity of {arms['isolated'][1]:.3f} ({gain[1]:.3f} to {gain[2]:.3f} higher)",
        f"({arms['isolated'][3]:.1f}, against {arms['panmictic'][3]:.1f})",
        f"{wright[0]:.2f} and {wright[1]:.2f} times the value that Wright's island model predicts",
        f"{arms['isolated'][5]:.2f} of the divergence of policies is between islands",
        f"({differ[0]:.2f} nats more, {differ[1]:.2f} to {differ[2]:.2f};".replace("-", "−"),
    ):
        assert text in page


def test_numbers_of_searches_are_those_of_the_studies() -> None:
    best = {row[0]: row[3:5] for row in result("optimisers")["table"]["rows"]}
    (of_40, of_80), (tpe, tpe_80), (cma, cma_80), (random, random_80) = (
        best[name] for name in ("gp", "tpe", "cmaes", "random")
    )
    value = {line["statement"]: line["value"] for line in result("search")["verdicts"]}
    found = value["the search: share of runs on fresh seeds in which all species persist"].partition(" (")[0]
    page = words(HOW_TO / "searching.md")
    for text in (
        f"persisted in {of_40} of new runs, compared with {tpe} for the tree-structured Parzen estimator",
        f"{cma} for CMA-ES and {random} for random search",
        f"the shares were {of_80}, {tpe_80}, {cma_80} and {random_80}",
        f"persisted in {found} runs, and those of two random searches in "
        f"{value['the same with random candidates, in the same time']}",
    ):
        assert text in page
