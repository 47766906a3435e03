"""What a sweep was and did, in words and on a page: the numbers are those of the forks."""

import json
import sys
from dataclasses import replace
from html import escape
from types import ModuleType

import numpy as np
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from ecs_eco import explain
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import number
from ecs_eco.cli import app
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.explain import Account, Allele, Edit, Sweep, TakenOut, follow, write_explanation
from ecs_eco.explain.account import (
    account,
    born_or_learned,
    candidates,
    elsewhere,
    of_two_sweeps,
    put_in,
    rose,
    ticks_of,
    without,
)
from ecs_eco.explain.figures import birth, clearest, largest, neutral
from ecs_eco.explain.page import births_of, headline, opening, with_another
from ecs_eco.record import run_to_folder
from tests.explain.newts import recorded

RED = Allele("goat", "letter", "red", 0, "T")
TICKS = np.arange(0, 1001, 100)


def sweep(kind="complete", last=0.97, **changes):
    """A rise of RED from 8% to 97% between ticks 300 and 700."""
    path = np.interp(TICKS, [0, 300, 700, 1000], [0.08, 0.08, 0.97, last])
    values = {
        "species": "goat",
        "lead": RED,
        "linked": (),
        "ticks": TICKS,
        "path": path,
        "begin": 300,
        "half": 500,
        "end": 700,
        "first": 0.08,
        "last": last,
        "s": 0.35,
        "interval": (0.3, 0.41),
        "generation": 100.0,
        "p": 1e-9,
        "q": 1e-7,
        "kind": kind,
    }
    return Sweep(**values | changes)


def taken(births=(-0.6, -0.8, -0.4), poisoned=(0.3, 0.31, 0.29), old=(-0.3, -0.31, -0.29)):
    """Forks in which carriers that lost RED differ by these numbers from the others."""

    def both(differences, control):
        return np.array([[control, control + x] for x in differences])

    means = {
        "births": both(births, 2.0),
        "survival": both((-20.0, -21.0, -19.0), 100.0),
        "died: poisoned": both(poisoned, 0.1),
        "died: too old": both(old, 0.9),
        "action: eat": both((0.1, 0.11, 0.09), 0.5),
    }
    edit = Edit("goat", "letter", "red", 0, "T", "A")
    return TakenOut((edit,), 500, np.full(3, 90), np.full((3, 2), 40), means, {})


def test_a_rise_is_told_with_its_numbers():
    assert rose(sweep()) == (
        "In the species goat, letter T at locus 0 (gene red) rose from 8% to 97%, mostly between ticks 300 and "
        "700. Its selection coefficient is 0.35 (95% interval: 0.3 to 0.41) per generation of 100 ticks."
    )
    assert rose(sweep("passing", 0.1)).endswith("it was at 10%.")
    assert "stayed level" in rose(sweep("balanced", 0.6))
    extinct = sweep("partial", path=np.append(sweep().path[:-1], np.nan))
    assert rose(extinct).endswith("At the last sample before the species died out, it was at 97%.")


def test_an_effect_is_told_with_its_interval_and_its_cause():
    text = without(RED, taken())
    # the interval of −0.6 over three forks: 0.2 / √3 × 4.303
    assert "Without it, carriers had 0.6 (0.1 to 1.1) fewer young each; with it, 2." in text
    assert "letter A replaced letter T at locus 0 (gene red) in a random half of 80 carriers." in text
    assert "lived 20 (18 to 22) ticks less" in text
    assert "Among causes of death, “poisoned” increased most, by 30 percentage points (28 to 32)." in text


def test_what_cannot_be_told_is_said():
    text = without(RED, taken(births=(-0.6, 0.6, 0.1), poisoned=(0.3, 0.9, 0.0), old=(0.1, 0.101, 0.099)))
    assert "cause" not in text  # the largest increase, of poison, is not clear
    text = without(RED, taken(births=(-0.6, 0.6, 0.1)))
    assert "does not differ clearly" in text
    other = Allele("goat", "letter", "", 3, "C")
    same = replace(taken(), means=taken(births=(-0.1, 0.1, 0.0)).means)
    lines = Account(sweep(linked=((other, 0.9),)), ((RED, same), (other, same))).sentences()
    assert lines[-1].endswith("the forks do not show which one drove the rise.")
    harmful = replace(same, means=taken(births=(0.6, 0.7, 0.65)).means)  # its loss raises the number of young
    lines = Account(sweep(linked=((other, 0.9),)), ((RED, harmful), (other, same))).sentences()
    assert "more young each" in lines[-2]
    assert lines[-1].endswith("the forks do not show which one drove the rise.")
    one = {name: values[:1] for name, values in taken().means.items()}
    text = without(RED, replace(taken(), n=taken().n[:1], means=one))
    assert "In 1 fork at tick" in text
    assert "Without the allele, the number of young differs by −0.6; one fork gives no interval." in text
    assert "lived" not in text
    assert "NaN" not in text
    assert "–" not in text
    assert Account(sweep(), gap="It could not be taken out.").sentences()[-1] == "It could not be taken out."


def test_the_driver_is_the_allele_whose_loss_costs_young():
    other = Allele("goat", "letter", "", 3, "C")
    none = taken(births=(-0.1, 0.1, 0.0))
    told = Account(sweep(linked=((other, 0.9),)), ((other, none), (RED, taken())))
    assert told.driver == RED
    assert told.sentences()[-1] == (
        "Removing letter T at locus 0 (gene red) clearly lowers the number of young, and no other removal does, so "
        "this allele probably drove the rise."
    )
    assert told.to_json()["driver"] == RED.name
    more = Account(told.sweep, ((other, taken(births=(-0.3, -0.31, -0.29))), (RED, taken())))
    assert more.driver == RED
    assert more.sentences()[-1].startswith(
        "Removing letter T at locus 0 (gene red) lowers the number of young most"
    )
    assert "but removing letter C at locus 3 also lowers it clearly" in more.sentences()[-1]


def test_two_by_two_tells_whether_an_advantage_is_inherited_or_learned():
    births = np.array(
        [[2.0, 2.0 - a, 2.0 - b, 2.0 - a - b] for a, b in ((0.5, 0.1), (0.6, -0.1), (0.4, 0.0))]
    )
    two = replace(taken(), means={"births": births}, n=np.full((3, 4), 40))
    assert Account(sweep(), learned=two).to_json()["learned"]["first"]["value"] == pytest.approx(-0.5)
    text = born_or_learned(two)
    # intervals over three forks: 0.1 / √3 × 4.303
    assert "−0.5 (−0.75 to −0.25) without the allele, 0 (−0.25 to 0.25) without what they had learned" in text
    assert "The allele raises the number of young; an effect of learning is not clear." in text
    assert text.endswith("The interaction is 0 (0 to 0): no clear deviation from the sum of both effects.")
    both = np.array([[2.0, 1.5, 1.5 + x, 0.0 + x] for x in (-0.01, 0.0, 0.01)])
    text = born_or_learned(replace(taken(), means={"births": both}, n=np.full((3, 4), 40)))
    assert "Both the allele and learning raise the number of young. The interaction is −1" in text
    assert text.endswith("the two effects do not add up.")
    text = born_or_learned(replace(taken(), means={"births": both[:1]}, n=np.full((1, 4), 40)))
    assert "–" not in text  # one fork gives no interval


OTHER = Allele("goat", "letter", "", 3, "C")


def test_forks_at_several_ticks_are_compared_with_the_first():
    before = replace(taken(births=(-0.1, 0.1, 0.0)), tick=300)
    after = replace(taken(births=(-0.61, -0.79, -0.4)), tick=700)
    several = (RED, taken()), (OTHER, taken()), (RED, before), (RED, after)
    # the interval of 0 over three forks: 0.1 / √3 × 4.303 = 0.25; of −0.6, 0.5; that of the difference, 0.56
    assert elsewhere(several) == [
        "In forks at tick 300, the difference in the number of young was 0 (−0.25 to 0.25), clearly different, by "
        "0.6 (0.045 to 1.2), from that at tick 500.",
        "In forks at tick 700, the difference in the number of young was −0.6 (−1.1 to −0.12), not clearly "
        "different from that at tick 500.",
    ]
    told = Account(sweep(), several)
    assert told.at_first_tick == several[:2]
    assert [row["tick"] for row in told.effects() if row["measure"] == "births"] == [500, 500, 300, 700]


def test_ticks_of_forks_are_those_of_the_rise():
    assert ticks_of(sweep(), None) == ticks_of(sweep(), "within") == [500]
    assert ticks_of(sweep(), ["before", 20, "after", 300, "within"]) == [300, 20, 700, 500]
    with pytest.raises(ValueError, match="tick = 'middle'; expected a whole number, before, within or after"):
        ticks_of(sweep(), [3, "middle"])


def test_the_reverse_and_two_sweeps_are_told_with_their_doses():
    back = replace(taken(births=(0.6, 0.8, 0.4)), edits=(replace(taken().edits[0], reverse=True),))
    assert put_in(back) == (
        "In reverse, letter T at locus 0 (gene red) was put into a random half of 80 organisms without it, in "
        "forks at tick 500: their number of young differed clearly from that of the others; the difference is "
        "0.6 (0.1 to 1.1)."
    )
    births = np.array([[2.0, 1.5, 1.5 + x, 0.0 + x] for x in (-0.01, 0.0, 0.01)])
    edits = (taken().edits[0], Edit("goat", "letter", "", 3, "C", "A"))
    two = replace(taken(), edits=edits, means={"births": births}, n=np.full((3, 4), 20))
    text = of_two_sweeps(OTHER, two)
    assert text.startswith(
        "At tick 500, 80 organisms carried both letter T at locus 0 (gene red) and letter C at locus 3. Compared "
        "with carriers that kept both, the number of young differed by −0.5"
    )
    assert "−2 (−2 to −2) without both. The interaction is −1 (" in text
    doses = {1: {"births": births[:, :2]}, 2: {"births": births[:, [0, 3]]}}
    means = taken().means | {"births": births[:, :2]}
    doses = {dose: means | of for dose, of in doses.items()}
    told = Account(sweep(), ((RED, replace(taken(), doses=doses, means=means)),))
    told = replace(told, reverse=back, together=(OTHER, two))
    rows = [row for row in told.effects() if row["measure"] == "births"]
    assert [(row["change"], row["dose"], round(row["effect"], 2)) for row in rows] == [
        ("without letter T at locus 0 (gene red)", 0, -0.5),
        ("without letter T at locus 0 (gene red)", 1, -0.5),
        ("without letter T at locus 0 (gene red)", 2, -2.0),
        ("letter T at locus 0 (gene red) put in", 0, 0.6),
        ("without letter T at locus 0 (gene red)", 0, -0.5),
        ("without letter C at locus 3", 0, -0.5),
        ("without letter T at locus 0 (gene red) and letter C at locus 3", 0, -2.0),
        ("interaction of both", 0, -1.0),
    ]
    for line in (put_in(back), text):
        assert line in told.sentences()
    assert ">letter T at locus 0 (gene red) put in</td>" in births_of(told)


def test_each_letter_is_taken_out_but_not_also_the_value_that_it_codes_for():
    linked = (Allele("goat", "value", "red", -1, "-1"), 1.0), (Allele("goat", "letter", "", 3, "C"), 0.9)
    more = (Allele("goat", "letter", "", 4, "C"), 0.8), (Allele("goat", "haplotype", "", -1, "TACC"), 0.8)
    assert [a.locus for a in candidates(sweep(linked=(*linked, *more)))] == [0, 3, 4]
    second = Allele("goat", "letter", "red", 1, "G")
    assert candidates(sweep(linked=((second, 0.9),))) == [RED, second]
    assert candidates(sweep(lead=linked[0][0], linked=((RED, 1.0), (second, 0.9)))) == [linked[0][0]]


def test_why_an_allele_could_not_be_taken_out_is_told_for_each(monkeypatch):
    errors = iter([ValueError("no carriers."), RecordingError("no record"), ConfigError([])])

    def fail(*_, **__):
        raise next(errors)

    monkeypatch.setattr(sys.modules["ecs_eco.explain.account"], "take_out", fail)
    two, done = sweep(linked=((Allele("goat", "letter", "", 3, "C"), 0.9),)), []
    assert account("run", two, forks=2, progress=lambda *one: done.append(one)).gap == (
        "Taking out letter T at locus 0 (gene red) failed: no carriers. "
        "Taking out letter C at locus 3 failed: no record."
    )
    assert done == [(2, 4), (4, 4)]
    with pytest.raises(ConfigError):  # code that is not trusted: the command says how to allow it
        account("run", two, forks=2)


def test_what_was_examined_is_told_first(pond):
    lineage = replace(Lineage.read(pond), genomes={})
    assert opening([], lineage, 4, ["newt"], False, False) == [
        "In 4 ticks, no sweeps were found in newt. In a sweep, an allele rises by at least 10 percentage points "
        "and by more than drift allows.",
        "No genomes of newt are recorded, so only the clades of founders were followed. To follow genes, give the "
        "species a section “genome”.",
    ]
    assert (
        "Only alleles of the 8 clearest sweeps"
        in opening([sweep()] * 9, lineage, 4, ["newt"], False, True)[-1]
    )


def test_the_clearest_sweep_and_its_effect_open_the_page():
    weak, clear = replace(sweep(), p=0.009), replace(sweep(), p=0.001)
    without = taken()
    effect = without.effect("births")
    told = headline([Account(weak), Account(clear, taken=((RED, without),))])
    assert told[0] == rose(clear)
    words = f"{number(effect.value, 2)} ({number(effect.low, 2)} to {number(effect.high, 2)})"
    assert told[1:] == [f"Taking it out changes the number of young of its carriers by {words}."]
    assert headline([Account(weak)]) == [rose(weak)]
    assert headline([]) == []


def test_two_sweeps_of_a_species_are_taken_out_together():
    clades, first, second = sweep(lead=Allele("goat", "clade", "", -1, "1")), sweep(), sweep(lead=OTHER)
    assert with_another([clades, first, second]) == {id(first): second}
    assert with_another([clades, first]) == {}


def test_figures_show_the_clearest_effects():
    assert clearest(taken())[:2] == ["births", "survival"]
    assert largest(taken(old=(0.0, 0.01, -0.01)), "died") == "death: poisoned, +30 points without it"
    assert largest(taken(), "action") == "action eat, +10 points without it"
    assert largest(taken(births=(0.0, 0.0, 0.0)), "meals") == ""
    assert birth(taken()) == "young, −30% without it"
    assert birth(taken(births=(-0.6, 0.6, 0.1))) == "young: no clear change"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Goats that lose the gene that keeps them from good grass."""
    out = tmp_path_factory.mktemp("explained") / "run"
    config = load("reflexes", {"species.goat.policy.learn": False})
    run_to_folder(config, seed=1, ticks=320, out=out, policies="untrained", report=False)
    return out


@pytest.mark.slow
def test_page_files_and_command_have_the_same_numbers(run):
    how = {"forks": 2, "ticks": 8, "workers": 1, "reverse": True, "together": True}
    found = write_explanation(run, species="goat", tick=[120, "within"], **how)
    assert "No species has two sweeps" in found["summary"][-1]
    assert found["sweeps"][0]["lead"] == "green = 0"
    assert json.loads((run / "explain.json").read_text(encoding="utf-8")) == found
    page = (run / "explain.html").read_text(encoding="utf-8")
    effects = pq.read_table(run / "explain" / "effects.parquet").to_pylist()
    assert effects == [row for one in found["sweeps"] for row in one["effects"]]
    of_first = found["sweeps"][0]["effects"]
    assert {row["tick"] for row in of_first} == {120, found["sweeps"][0]["half"]}
    assert {row["reverse"] for row in of_first} == {False, True}
    again = write_explanation(run, species="goat", tick=[120, "within"], **how)
    assert again == found
    table = pq.read_table(run / "explain" / "frequencies.parquet").to_pandas()
    first = found["sweeps"][0]
    own = table[(table.kind == "value") & (table.gene == "green") & (table.value == "0")].set_index("tick")
    assert own.frequency[first["begin"]] <= first["first"] + 0.25 * (own.frequency.max() - first["first"])
    assert own.frequency.iloc[-1] == first["last"]
    lives = Lineage.read(run).of_species("goat")
    alive, green = lives.alive(first["half"]), lives.values("green", "goat")
    assert own.frequency[first["half"]] == pytest.approx((green[alive] == 0).mean())
    for one in found["sweeps"]:
        assert all(escape(line, quote=False) in page.replace("&quot;", '"') for line in one["sentences"])
    said = CliRunner().invoke(app, ["explain", str(run), "--species", "goat", "--forks", "0", "--quiet"])
    assert said.exit_code == 0, said.output
    assert first["sentences"][0] in said.output
    assert f"written: {run / 'explain.html'}" in said.output


@pytest.mark.slow
def test_the_band_of_drift_begins_at_the_rise_and_widens(run):
    paths = follow(Lineage.read(run), "goat")
    j = next(j for j, allele in enumerate(paths.alleles) if allele.kind == "value")
    begin = len(paths.ticks) // 3
    one = sweep(lead=paths.alleles[j], ticks=paths.ticks, path=paths.p[:, j], begin=int(paths.ticks[begin]))
    low, high = neutral(one, paths)
    assert np.isnan(low[:begin]).all()
    assert low[begin] == high[begin] == pytest.approx(paths.p[begin, j])
    assert (np.diff(high[begin:]) >= 0).all()
    assert high[-1] > high[begin]


@pytest.fixture(scope="module")
def pond(tmp_path_factory):
    return recorded(tmp_path_factory.mktemp("pond") / "run", ticks=4)


def test_all_comparisons_of_a_sweep_are_made_in_forks(pond):
    leads = [Allele("newt", "letter", gene, at, "B") for at, gene in enumerate(("hunger", "fertile"))]
    first, other = (sweep(species="newt", lead=lead) for lead in leads)
    how = {"tick": [0, 1], "forks": 2, "ticks": 6, "workers": 1}
    found = account(pond, first, other=other, reverse=True, **how)
    assert found.gap == ""
    assert [(allele, taken.tick) for allele, taken in found.taken] == [(leads[0], 0), (leads[0], 1)]
    assert found.reverse.edits[0] == Edit("newt", "letter", "hunger", 0, "B", "A", reverse=True)
    assert found.reverse.effect("survival").value < 0 < found.taken[0][1].effect("survival").value
    assert found.together[0] == leads[1]
    assert found.together[1].tick == 0
    assert found.together[1].n.shape == (2, 4)
    assert len(found.sentences()) == 5


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--species", "newd"], 'did you mean "newt"'),
        (["--fdr", "2"], "a number between 0 and 1"),
        (["--tick", "5"], "from 0 to 4"),
        (["--tick", "before", "--tick", "middle"], "a whole number, before, within or after"),
        (["--on", "elsewhere"], "elsewhere"),
    ],
)
def test_bad_input_is_refused(pond, arguments, said):
    done = CliRunner().invoke(app, ["explain", str(pond), *arguments])
    assert done.exit_code == 2
    assert said in done.output
    assert "Traceback" not in done.output


def test_no_module_hides_a_public_name_of_the_package():
    assert not [name for name in explain.__all__ if isinstance(getattr(explain, name), ModuleType)]


def test_measures_that_no_unchanged_organism_has_are_not_shown_in_percent():
    none = replace(
        taken(), means=taken().means | {"meals: red": np.array([[0.0, 0.2], [0.0, 0.3], [0.0, 0.4]])}
    )
    assert "meals: red" not in clearest(none)
    childless = replace(taken(), means={"births": np.array([[0.0, 0.5], [0.0, 0.6], [0.0, 0.4]])})
    assert birth(childless) == "young, +0.5 each without it"
