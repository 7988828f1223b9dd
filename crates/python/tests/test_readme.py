"""The five lines of the README do what it says, as they stand there."""

import ast
import importlib.util
import re
import sys

import numpy as np
import pytest

from conftest import ROOT


def lines_of(document):
    """The only block of Python in a document that begins with the import."""
    blocks = re.findall(r"^ *```python\n(.*?)^ *```$", (ROOT / document).read_text(), re.DOTALL | re.MULTILINE)
    blocks = [block for block in blocks if block.lstrip().startswith("import vibrochain")]
    assert len(blocks) == 1, f"{document} has {len(blocks)} blocks of Python that begin with the import"
    indent = len(blocks[0]) - len(blocks[0].lstrip())
    return [line[indent:] for line in blocks[0].splitlines()]


def test_both_documents_show_the_same():
    assert lines_of("README.md") == lines_of("docs/python.md")


def test_the_five_lines_of_the_readme(monkeypatch, tmp_path):
    import vibrochain as vc

    lines = lines_of("README.md")
    # After the import, five.
    assert len(lines) == 6 and all(ast.parse(line).body for line in lines)
    last = lines.pop()
    told, picture = last.split("; ")
    assert picture == 'table.plot().figure.savefig("map.png")'
    names = {}
    exec("\n".join([*lines, told]), names)

    model, orbit, table = names["model"], names["orbit"], names["table"]
    assert model.chain.sites == 21 and orbit in model.breathers("double-sided").orbits
    # As the remark beside it says.
    assert names["u"].shape == (200, 21) and "(200, 21)" in lines[3]
    assert np.array_equal(names["u"], orbit.displacement(np.linspace(0, orbit.period, 200)))
    assert names["mu"].dtype == complex and len(names["mu"]) == 42
    assert names["P"] == [impact.impulse for impact in orbit.impacts] and len(names["P"]) == 2
    assert isinstance(table, vc.Map) and table.shape == (300, 400) and table.dims == ("gamma2", "omega")
    assert sum(table.classes.values()) == 120_000 and len(table.classes) == 5

    if importlib.util.find_spec("matplotlib") is None:
        sys.__stderr__.write("\nthe README's table.plot() is NOT tested: matplotlib is not installed\n")
        pytest.skip("the README's table.plot() is not tested: matplotlib is not installed")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    from matplotlib import pyplot

    pyplot.close("all")
    monkeypatch.chdir(tmp_path)
    exec(picture, names)
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    [number] = pyplot.get_fignums()
    figure = pyplot.figure(number)
    [ax] = figure.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency ω", "coupling stiffness γ₂")
    assert ax.get_title().startswith("Conservative breathers\n21 masses (N = 20), γ₁ = 0.2, a = 0.4")
    words = {"no physical breather", *(name.replace("-", " ") + "-sided" for name in table.classes if name != "none")}
    assert {text.get_text() for text in ax.get_legend().get_texts()} >= words and len(words) == 5
    # The picture itself: a map of many colours and not an empty frame.
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())
    left, bottom, right, top = (round(place) for place in ax.get_window_extent().extents)
    inside = pixels[pixels.shape[0] - top : pixels.shape[0] - bottom, left:right, :3].reshape(-1, 3)
    colours, counts = np.unique(inside, axis=0, return_counts=True)
    large = colours[counts > 0.02 * len(inside)]
    assert len(large) >= 4 and (large == 255).all(axis=1).any(), large
    pyplot.close(figure)
