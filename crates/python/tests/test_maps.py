"""Maps as arrays: whose memory they are, what is missing, what they are handed on to."""

import builtins
import errno
import json
import subprocess
import sys

import numpy as np
import pytest

import vibrochain as vc


def scene(x=40, y=30, **compute):
    scene = vc.read_scene("scenes/conservative-n20.toml")
    scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = x, y
    scene["compute"].update(compute)
    return scene


@pytest.fixture(scope="module")
def table():
    return vc.sweep({**vc.read_scene("scenes/conservative-n20.toml")})


def words(table):
    """What `mapgen`'s legends call the classes of a map, by these."""
    told = {name: name.replace("-", " ") + "-sided" for name in table.classes}
    return {told[name] if name != "none" else "no physical breather": name for name in table.classes}


def base(array):
    """What holds the memory of an array in the end."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def test_columns_are_the_memory_that_was_computed_into(table):
    for name in ["spectral_radius", "margin", "solutions"]:
        column = table[name]
        # Memory of no array of NumPy: the vector that the sweep has filled. The same whenever it is asked for.
        assert base(column).base is not None and not isinstance(base(column).base, np.ndarray)
        assert table[name] is column and column.shape == (300, 400) and column.flags.c_contiguous
    codes, _ = table.codes("class")
    assert base(codes).base is not None and codes.itemsize == 1
    # Parameters take none at all.
    assert table["omega"].strides == (0, 8) and table["gamma2"].strides == (8, 0)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="where the system tells no peak of memory")
def test_a_sweep_takes_the_memory_of_its_columns_once():
    """Peak memory of a process that sweeps, beyond one that sweeps next to nothing."""

    def peak(points):
        code = f"""
import vibrochain as vc
scene = vc.read_scene("scenes/conservative-n20.toml")
scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = {points}, 1000
scene["compute"].update(families=["single-sided"], stability=False)
table = vc.sweep(scene, threads=1)
print(*(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""
        return int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)

    cells = 1_000_000
    columns = 8 + 8 + 4 + 3 * 1  # two numbers, a count, three codes of words
    grown = 1024 * (peak(1010) - peak(10)) / cells
    assert 0.5 * columns < grown < 1.5 * columns, f"{grown:.1f} bytes a cell, the columns are {columns}"


def test_what_a_cell_lacks_is_missing_and_not_zero(table):
    none = table["class"] == "none"
    assert 0 < none.sum() == table.classes["none"] < len(table)
    assert np.isnan(table["spectral_radius"][none]).all() and np.isnan(table["margin"][none]).all()
    assert (table["mechanism"][none] == "").all() and (table["solutions"][none] == 0).all()
    assert not np.isnan(table["spectral_radius"][~none]).any()
    bare = vc.sweep(scene(stability=False))
    assert np.isnan(bare["spectral_radius"]).all() and set(bare.codes("mechanism")[0].ravel()) == {-1}


def test_names_that_are_no_columns(table):
    with pytest.raises(KeyError, match="it has gamma2, omega, class"):
        table["radius"]
    with pytest.raises(KeyError, match="those are class, mechanism, status"):
        table.codes("margin")
    assert "margin" in table and "radius" not in table


def test_a_scene_that_is_wrong_is_told_where():
    cells = vc.read_scene("scenes/conservative-n20.toml")
    for change, told in [
        (lambda s: s.update(modle=1), "'modle' is unknown: give title, model, sweep, compute"),
        (lambda s: s["model"].update(gamma1=-1.0), "gamma1 = -1 is out of range"),
        (lambda s: s["model"].update(gamma1=float("nan")), "give finite numbers"),
        (lambda s: s["model"].update(gamma1=vc), "cannot be part of one"),
        (lambda s: s["sweep"]["x"].update(points=1), "points = 1 is out of range"),
        (lambda s: s.pop("sweep"), r"the table \[sweep\] is missing"),
        (lambda s: s["compute"].update(families=["both"]), "both"),
    ]:
        wrong = json.loads(json.dumps(cells))
        change(wrong)
        with pytest.raises(vc.RequestError, match=told):
            vc.sweep(wrong)
    for threads in [0, -1, 1025, 10**30]:
        with pytest.raises(vc.RequestError, match="give a whole number from 1 to 1024"):
            vc.sweep(cells, threads=threads)
    with pytest.raises(vc.TooLargeError, match="is too large for memory, the limit is 100000000"):
        vc.sweep("scenes/three-parameters.toml")
    for ask in [vc.sweep, vc.curves, vc.fate, vc.read_scene]:
        with pytest.raises(FileNotFoundError, match="there is no such file: 'scenes/none.toml'") as error:
            ask("scenes/none.toml")
        assert error.value.filename == "scenes/none.toml" and error.value.errno == errno.ENOENT


def test_numbers_of_numpy_make_a_scene():
    plain = scene()
    numpy = scene()
    numpy["model"]["gamma1"] = np.float64(0.2)
    numpy["sweep"]["x"] = {"parameter": "omega", "values": np.linspace(0.4, 3.0, 5)}
    plain["sweep"]["x"] = {"parameter": "omega", "values": np.linspace(0.4, 3.0, 5).tolist()}
    assert np.array_equal(vc.sweep(numpy)["margin"], vc.sweep(plain)["margin"], equal_nan=True)


def test_to_pandas(table):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed: tables for it are not tested here")
    frame = table.to_pandas()
    assert tuple(frame.columns) == table.columns and len(frame) == len(table)
    assert isinstance(frame["class"].dtype, pandas.CategoricalDtype)
    counts = frame["class"].value_counts()
    assert all(counts[name] == count for name, count in table.classes.items())
    assert frame["mechanism"].isna().sum() == (table["mechanism"] == "").sum()
    assert np.array_equal(frame["margin"], table["margin"].ravel(), equal_nan=True)
    # Numbers are the map's own memory still.
    assert np.shares_memory(frame["margin"].to_numpy(), table["margin"])


def test_to_xarray():
    pytest.importorskip("xarray", reason="xarray is not installed: datasets are not tested here")
    given = scene(7, 5)
    given["sweep"]["axes"] = [{"parameter": "asymmetry", "values": [0.4, 0.1]}]
    del given["model"]["asymmetry"]
    table = vc.sweep(given)
    data = table.to_xarray()
    assert dict(data.sizes) == {"asymmetry": 2, "gamma2": 5, "omega": 7} and table.shape == (2, 5, 7)
    point = data.sel(asymmetry=0.1, gamma2=table.coords["gamma2"][3], omega=table.coords["omega"][6])
    assert np.shares_memory(data["margin"].values, table["margin"])
    assert point["margin"].item() == table["margin"][1, 3, 6] and str(point["class"].item()) == table["class"][1, 3, 6]


def test_plot(table, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pictures are not tested here")
    ax = table.plot()
    mechanisms = {"period doubling", "through +1", "Neimark–Sacker"}
    assert {text.get_text() for text in ax.get_legend().get_texts()} == set(words(table)) | mechanisms and len(words(table)) == 5
    heading, *caption = ax.get_title().split("\n")
    assert heading == "Conservative breathers" and " ".join(caption) == (
        "21 masses (N = 20), γ₁ = 0.2, a = 0.4, double-sided and single-sided breathers, stable: no |μ| above 1 by more than rounding"
    )
    # Textures lie where stability is lost in their ways; Neimark-Sacker has none.
    assert sorted(hatch for mesh in ax.collections[1:] for hatch in mesh.hatches) == ["...", "///"]
    # The legend is off the data, and in the picture.
    ax.figure.canvas.draw()
    legend, data = ax.get_legend().get_window_extent(), ax.get_window_extent()
    assert legend.x0 > data.x1 and legend.x1 < ax.figure.bbox.x1 + 1
    # Each colour where its class is.
    mesh = ax.collections[0]
    mesh.update_scalarmappable()
    colours = mesh.get_facecolors().reshape(300, 400, 4)
    assert np.array_equal((colours[..., :3] == 1.0).all(axis=-1), table["class"] == "none")
    table.plot("margin", ax=ax)
    with pytest.raises(vc.RequestError, match="give one of class, spectral_radius, margin, solutions"):
        table.plot("status")
    given = scene()
    del given["sweep"]["y"]
    given["model"]["gamma2"] = 0.1
    curve = vc.sweep(given)
    assert curve.shape == (40,) and curve.plot("margin").get_ylabel() == "margin, the smallest distance to a barrier"
    ax = curve.plot()
    assert ax.get_ylabel() == "largest |μ|, logarithmic"
    drawn = {line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")}
    assert set(drawn) == set(words(curve)) - {"no physical breather"} and {"stable double-sided", "unstable double-sided"} <= set(drawn)
    for name, line in drawn.items():
        there = curve["class"] == words(curve)[name]
        assert np.array_equal(line.get_ydata()[there], curve["spectral_radius"][there])
        assert np.isnan(line.get_ydata()[~there]).all()
        assert line.get_linestyle() == ("--" if name.startswith("unstable") else "-")


def test_plot_of_numbers(table):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pictures are not tested here")

    def pixels(mesh):
        mesh.update_scalarmappable()
        return mesh.get_facecolors().reshape(300, 400, 4)

    margin = pixels(table.plot(color="margin").collections[0])
    # The ends of viridis, as they are published; nothing where there is no breather.
    least, most = np.nanargmin(table["margin"]), np.nanargmax(table["margin"])
    assert np.allclose(margin.reshape(-1, 4)[[least, most], :3] * 255, [[68, 1, 84], [253, 231, 37]], atol=1)
    assert np.array_equal(margin[..., 3] == 0, np.isnan(table["margin"]))
    ax = table.plot("spectral_radius")
    grey, excess = (pixels(mesh) for mesh in ax.collections[:2])
    # Excesses span decades: by logarithms, what is less than all of them in grey.
    low = ax.collections[1].norm.vmin
    assert low <= (table["spectral_radius"][table["spectral_radius"] - 1 > 1e-8] - 1).min() < 10 * low
    assert np.array_equal(grey[..., 3] > 0, table["spectral_radius"] - 1 < low)
    assert np.array_equal(excess[..., 3] > 0, table["spectral_radius"] - 1 >= low)
    solutions = pixels(table.plot("solutions").collections[0])
    assert np.array_equal(solutions[..., 3] > 0, table["solutions"] > 0)


def test_plot_of_a_slice():
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pictures are not tested here")
    given = scene(7, 5)
    given["sweep"]["axes"] = [{"parameter": "asymmetry", "values": [0.7, 0.1, 0.4]}]
    del given["model"]["asymmetry"]
    table = vc.sweep(given)
    with pytest.raises(vc.RequestError, match="here are 3, asymmetry, gamma2, omega: fix the others by slice={'asymmetry': 0.7}"):
        table.plot()
    ax = table.plot("margin", slice={"asymmetry": 0.1})
    shown = ax.collections[0].get_array().reshape(5, 7)
    assert np.array_equal(np.ma.filled(shown, np.nan), table["margin"][1], equal_nan=True)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency ω", "coupling stiffness γ₂") and " a = 0.1," in ax.get_title()
    # Lists are drawn in the order of their values.
    ax = table.plot("margin", slice={"omega": 3, "gamma2": 0.15})
    [line] = [line for line in ax.get_lines() if line.get_label() == "stable double-sided"]
    assert np.array_equal(line.get_xdata(), [0.1, 0.4, 0.7])
    assert np.array_equal(line.get_ydata(), table["margin"][[1, 2, 0], 2, 6])
    for wrong, told in [
        ({"asymmetry": 0.2}, "asymmetry = 0.2 is none of its 3 values: next to it are 0.1 and 0.4"),
        ({"gamma1": 0.2}, "'gamma1' is no axis of this map: give one of asymmetry, gamma2, omega"),
        ({"asymmetry": 0.1, "omega": 3, "gamma2": 0}, "pictures have one or two axes, here are 0, no axis"),
    ]:
        with pytest.raises(vc.RequestError, match=told):
            table.plot(slice=wrong)


@pytest.mark.parametrize("package, method", [("pandas", "to_pandas"), ("xarray", "to_xarray"), ("matplotlib", "plot")])
def test_what_is_not_installed_is_said(package, method, monkeypatch, table):
    real = builtins.__import__

    def missing(name, *rest):
        if name.split(".")[0] == package:
            raise ImportError(f"No module named {name!r}")
        return real(name, *rest)

    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [])
    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(ImportError, match=f"Map.{method} needs {package}, which is not installed: pip install {package}"):
        getattr(table, method)()
