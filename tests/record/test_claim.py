"""Folders that one process at a time writes to."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from ecs_eco.engine.errors import FolderInUse
from ecs_eco.record.claim import LOCK, Claim, claim_new, claim_next, claimed, stopped_early


def _names(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


def test_a_folder_is_claimed_once(tmp_path):
    with claim_new(tmp_path / "run") as claim:
        for again in (claim_new, Claim):
            with pytest.raises(
                FolderInUse, match=rf"run: is in use by process {os.getpid()} on .* since \d{{4}}-"
            ):
                again(tmp_path / "run")
        with claimed(claim) as same:
            assert same is claim
        (tmp_path / "run" / "manifest.json").write_text("{}")
    with Claim(tmp_path / "run"):
        assert _names(tmp_path / "run") == [LOCK, "manifest.json"]
    assert _names(tmp_path / "run") == ["manifest.json"]


def test_nothing_is_left_of_a_claim_that_nothing_came_of(tmp_path):
    with claim_new(tmp_path / "new" / "run"):
        assert _names(tmp_path) == ["new", "new/run", f"new/run/{LOCK}"]
    assert _names(tmp_path) == []
    (tmp_path / "empty").mkdir()
    claim_new(tmp_path / "empty").release()
    assert _names(tmp_path) == ["empty"]


def test_a_folder_that_holds_something_is_not_touched(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileExistsError, match="not an empty folder; name another"):
        claim_new(tmp_path)
    with pytest.raises(FileExistsError):
        claim_new(tmp_path / "thesis.tex")
    assert _names(tmp_path) == ["thesis.tex"]


def test_a_run_that_was_killed_while_it_wrote_its_first_checkpoint_is_replaced(tmp_path):
    run = tmp_path / "run"
    (run / "checkpoints").mkdir(parents=True)
    (run / LOCK).touch()
    for half in (".tick-00000005.safetensors.ecs-eco-7-0123abcd.tmp", ".tmpAb3dEf"):  # this of safetensors
        (run / "checkpoints" / half).touch()
    (run / ".manifest.json.ecs-eco-7-0123abcd.tmp").touch()
    with claim_new(run):
        assert _names(run) == [LOCK]
    (run / "checkpoints").mkdir(parents=True)
    (run / LOCK).touch()
    (run / ".tmpAb3dEf").touch()  # none of ours: we had none there
    with pytest.raises(FileExistsError):
        claim_new(run)


def test_many_that_name_no_folder_have_one_each(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        claims = list(pool.map(lambda _: claim_next(tmp_path / "runs" / "x-1"), range(8)))
    assert sorted(c.path.name for c in claims) == ["x-1", *(f"x-1-{n}" for n in range(2, 9))]
    for claim in claims:
        claim.release()
    assert _names(tmp_path) in ([], ["runs"])  # who made it may not be the last to leave


def test_the_claim_of_a_killed_process_is_free(tmp_path):
    code = (
        "import sys\nfrom ecs_eco.record.claim import claim_new\nclaim = claim_new(sys.argv[1])\n"
        "print('claimed', flush=True)\nsys.stdin.read()\n"
    )
    words = [sys.executable, "-c", code, str(tmp_path / "run")]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "claimed\n"
        owner = json.loads((tmp_path / "run" / LOCK).read_text())
        assert owner["pid"] == other.pid
        with pytest.raises(FolderInUse, match=f"process {other.pid} "):
            claim_new(tmp_path / "run")
        other.kill()
    assert stopped_early(tmp_path / "run")
    claim_new(tmp_path / "run").release()
    assert _names(tmp_path / "run") == []  # it was made by another one


def _killed_early(folder, *more):
    """What is left of a run that was killed as it wrote its manifest."""
    left = (
        LOCK,
        ".manifest.json.ecs-eco-7-0123abcd.tmp",
        "checkpoints/tick-000000000000.safetensors",
        "policies/deer.safetensors",
        "code/sir.py",
        "terrain.npz",
    )
    for name in (*left, *more):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("")


def test_the_folder_of_a_run_that_was_killed_before_it_began_is_taken_over(tmp_path):
    _killed_early(tmp_path / "run")
    with claim_new(tmp_path / "run"):
        assert _names(tmp_path / "run") == [LOCK]


@pytest.mark.parametrize(
    "own", ["notes.txt", "notes.tmp", "checkpoints/mine", "policies/notes.md", "code/notes.md"]
)
def test_what_else_lies_there_keeps_such_a_folder_from_being_taken(tmp_path, own):
    _killed_early(tmp_path / "run", own)
    before = _names(tmp_path / "run")
    with pytest.raises(FileExistsError):
        claim_new(tmp_path / "run")
    assert _names(tmp_path / "run") == before


def test_a_folder_that_was_replaced_is_no_longer_ours(tmp_path):
    claim = claim_new(tmp_path / "run")
    claim.check()
    (tmp_path / "run").rename(tmp_path / "moved")
    with pytest.raises(FolderInUse, match="was removed or replaced"):
        claim.check()
    with claim_new(tmp_path / "run"), pytest.raises(FolderInUse, match="was removed or replaced"):
        claim.check()
    claim.release()


def test_where_a_file_system_has_no_locks_the_owner_who_lives_has_the_folder(tmp_path, monkeypatch):
    import errno

    from ecs_eco.record import claim

    def without(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(claim.fcntl, "flock", without)
    first = claim_new(tmp_path / "run")
    with pytest.raises(FolderInUse, match=f"process {os.getpid()} "):
        claim_new(tmp_path / "run")
    owner = json.loads((tmp_path / "run" / LOCK).read_text())
    # another process had this number then
    (tmp_path / "run" / LOCK).write_text(json.dumps(owner | {"started": 1}))
    claim_new(tmp_path / "run").release()
    first.release()
