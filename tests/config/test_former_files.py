"""World files as users had them, in `former/` under their former paths, load with the meaning that they had."""

import json
import tomllib
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.config.document import Document
from ecs_eco.config.notes import notes

FORMER, ROOT = Path(__file__).parent / "former", Path(__file__).parents[2]
FILES = sorted(FORMER.rglob("*.toml"))
HASHES = json.loads((FORMER / "hashes.json").read_text())  # config_hash in version 0.2


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_former_file_keeps_its_values_and_gets_a_note_for_each_former_name(path: Path) -> None:
    name, text = path.relative_to(FORMER), path.read_text()
    document = Document(tomllib.loads(text), path.name, (ROOT / name).parent, text)
    config, simplified = load(document), 'kind = "simplified"' in text
    assert config.config_hash == HASHES[str(name)]
    told = notes(config)
    for key, former in document.renamed.items():
        assert any(note.endswith(f"{key[-1]} is the present name of {former}") for note in told), key
    assert document.renamed
    assert any(note.endswith(" for simplified") for note in told) == simplified
    if (ROOT / name).exists() and (twin := load(ROOT / name)).config_hash == config.config_hash:
        assert config.search == twin.search
        assert simplified or config.resolved() == twin.resolved()  # this kind keeps its name


def test_there_are_twenty_former_files_and_all_shipped_worlds() -> None:
    assert len(FILES) >= 20
    assert {path.stem for path in (ROOT / "ecs_eco/worlds").glob("*/*.toml")} <= {path.stem for path in FILES}
