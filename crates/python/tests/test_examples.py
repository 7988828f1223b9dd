"""Notebooks run as they are, and show what they say."""

import json
import math
import warnings

import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


def test_there_are_notebooks():
    assert [path.stem for path in NOTEBOOKS] == ["branch_and_its_cascade", "breather_and_its_fate", "first_map"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path, monkeypatch):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: notebooks are not run here")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(path.parent)
    notebook = json.loads(path.read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 4 and all(not cell.get("outputs") for cell in notebook["cells"])
    names = {}
    # What warns in a notebook warns every reader.
    warnings.simplefilter("error", UserWarning)
    for number, cell in enumerate(cells, 1):
        exec(compile(cell, f"{path.name}, code cell {number}", "exec"), names)
    if path.stem == "first_map":
        assert len(names["table"]) == 120_000 and 0.5 < names["share"].mean() < 0.9
    elif path.stem == "breather_and_its_fate":
        assert math.isclose(names["measured"], names["predicted"], rel_tol=0.01)
    else:
        assert [event for _, event, _, _ in names["cascade"]] == ["period-doubling", "grazing"]
        assert [periods for *_, periods in names["cascade"]] == [2, 2] and len(names["curve"].orbits) > 10
