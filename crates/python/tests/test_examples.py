"""Notebooks run as they are, and show what they say."""

import json
import math
import warnings

import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


NEEDS = {"beam_from_matrices": ["scipy"], "sweep_with_pandas_and_xarray": ["pandas", "xarray"]}


def test_there_are_notebooks():
    assert [path.stem for path in NOTEBOOKS] == [
        "beam_from_matrices", "branch_and_its_cascade", "breather_and_its_fate", "first_map", "sweep_with_pandas_and_xarray",
    ]  # fmt: skip


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path, monkeypatch):
    for package in ["matplotlib", *NEEDS.get(path.stem, [])]:
        pytest.importorskip(package, reason=f"{package} is not installed: {path.stem} is not run here")
    from matplotlib import pyplot

    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(path.parent)
    notebook = json.loads(path.read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 4 and all(not cell.get("outputs") for cell in notebook["cells"])
    assert sum(bool(line.strip()) for cell in cells for line in cell.splitlines()) < 40
    names = {}
    # What warns in a notebook warns every reader.
    warnings.simplefilter("error", UserWarning)
    for number, cell in enumerate(cells, 1):
        exec(compile(cell, f"{path.name}, code cell {number}", "exec"), names)
        # The last cell is a picture.
        figures = pyplot.get_fignums()
        pyplot.close("all")
    assert len(figures) == 1
    if path.stem == "first_map":
        assert len(names["table"]) == 120_000 and 0.5 < names["share"].mean() < 0.9
    elif path.stem == "breather_and_its_fate":
        assert math.isclose(names["measured"], names["predicted"], rel_tol=0.01)
    elif path.stem == "beam_from_matrices":
        assert names["orbit"].stability["stable"] and names["table"].classes["unstable"] > 100
        # Without the tip's mass, and free of stop and dashpots, the beam swings at the root of 1 + cos b cosh b = 0.
        import scipy.sparse.linalg

        bare = names["M"].copy()
        bare[names["tip"], names["tip"]] -= 1.0
        least = scipy.sparse.linalg.eigsh(names["K"].tocsc(), 1, bare.tocsc(), sigma=0.0, return_eigenvectors=False)[0]
        assert math.isclose(math.sqrt(least), 3.516015, rel_tol=1e-4)
    elif path.stem == "sweep_with_pandas_and_xarray":
        assert len(names["frame"]) == len(names["table"]) == 22_400 and dict(names["best"].sizes) == {"amplitude": 7, "omega": 80}
        assert math.isclose(names["shares"].to_numpy().sum(), 7.0)
    else:
        assert [event for _, event, _, _ in names["cascade"]] == ["period-doubling", "grazing"]
        assert [periods for *_, periods in names["cascade"]] == [2, 2] and len(names["curve"].orbits) > 10
