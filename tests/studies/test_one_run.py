"""How the study of processes that claim the same folder reads their errors."""

import pytest

from ecs_eco.record.claim import FolderInUse, claim_new, ours
from studies import one_run as study


def test_both_refusals_count_and_one_of_them_is_a_meeting(tmp_path):
    out = tmp_path / "out"
    with ours(out), pytest.raises(FolderInUse) as in_use, ours(out):
        pass
    out.mkdir(exist_ok=True)
    (out / "file").write_text("something")
    with pytest.raises(FileExistsError) as not_empty:
        claim_new(out)
    for caught, met in ((in_use, True), (not_empty, False)):
        ended = [(0, "done"), (study.REFUSED, str(caught.value))]
        assert study._refused_but_one(ended) == ""
        assert study._met(ended) is met
