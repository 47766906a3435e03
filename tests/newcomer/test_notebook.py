"""A newcomer's notebook, run in a kernel: 6 cells, 14 lines. Before, world, table and series showed a line of
text; figure, page and a row per tick were not to be had from a world at all."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from tools.sizes import code_lines

HERE = Path(__file__).parent
CELLS = (HERE / "notebook.py").read_text(encoding="utf-8").split("# %%\n")[1:]


def test_lines_and_cells_are_counted_as_they_are():
    lines = sum(len(code_lines(cell)) for cell in CELLS)
    assert f"{len(CELLS)} cells, {lines} lines" in __doc__


@pytest.mark.slow
@pytest.mark.skipif(find_spec("nbclient") is None, reason='no notebooks here: pip install -e ".[dev]"')
def test_the_notebook_shows_world_table_series_figure_and_living_page(tmp_path):
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    NotebookClient(
        notebook, timeout=500, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    shown = [
        {kind: text for output in cell.outputs for kind, text in output.get("data", {}).items()}
        for cell in notebook.cells
    ]
    world, table, series, figure, page, _ = shown
    assert "meadow" in world["text/html"]
    assert "Metabolism.energy" in table["text/html"]
    assert "120 rows" in series["text/html"]
    assert "image/png" in figure
    assert '<iframe src="http://127.0.0.1:' in page["text/html"]
    assert notebook.cells[-1].outputs[0]["text"] == "True 140\n"
