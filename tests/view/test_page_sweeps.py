"""Sweeps of an explained run: the story tells them, goes to them, and opens a world without their allele."""

import json
from dataclasses import asdict

from ecs_eco.explain import Edit
from ecs_eco.testing.browser import served, until
from tests.explain.newts import recorded
from tests.view.pages import IN_A_BROWSER, opened

pytestmark = IN_A_BROWSER
SWEEP = {
    "species": "newt",
    "lead": "letter B",
    "gene": "hunger",
    "first": 0.2,
    "last": 0.9,
    "half": 2,
    "sentences": ["It rose.", "In 2 forks, it lowered births."],
    "edit": asdict(Edit("newt", "letter", "hunger", 0, "B", "A")),
}


def test_a_sweep_is_gone_to_and_shown_next_to_a_world_without_its_allele(browser, tmp_path):
    run = recorded(tmp_path / "run", ticks=4, snapshot_every=1)
    (run / "explain.json").write_text(json.dumps({"sweeps": [SWEEP]}))
    with served("watch", str(run)) as viewer, opened(browser, viewer.address()) as page:
        page.locator("#tab-why").click()
        sweep = page.locator(".story li.sweep")
        assert "letter B of newt rose from 20% to 90%" in sweep.inner_text()
        assert "In 2 forks, it lowered births." in sweep.inner_text()
        sweep.locator(".jump").click()
        until(page, "ecs.tick === 2 && document.querySelector('#colour').value === 'gene:hunger'")
        sweep.get_by_role("button", name="next to one in which no organism has this allele").click()
        until(page, "ecs.tick === 1 && ecs.second && ecs.second.frames > 0")
        assert "all newt lose letter B" in page.locator("#pairWhat").inner_text()
        assert not page.locator("#pairAgain").is_visible()
