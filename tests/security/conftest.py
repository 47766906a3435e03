"""A module that leaves a mark when it is run."""

import sys
from pathlib import Path

import pytest

from ecs_eco.inputs import trust
from studies.common.malicious.templates import PAYLOAD


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the `evil` module, beside the world file and on Python's own path, leaves when it is run;
    and a user who allowed nothing."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(trust, "_here", set())
    (tmp_path / "evil.py").write_text(PAYLOAD.format(mark=str(tmp_path / "mark")), encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "evil", raising=False)
    return tmp_path / "mark"
