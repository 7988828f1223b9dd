"""Pictures show what values say, in the colours and words of the program's."""

import re

import numpy as np
import pytest

import vibrochain as vc
from vibrochain import _pictures

from conftest import ROOT

pyplot = pytest.importorskip("matplotlib.pyplot", reason="matplotlib is not installed: pictures are not tested here")
pyplot.switch_backend("Agg")

STOP = vc.Contact(at=0, upper=0.1, restitution=0.8)
ONE = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[STOP], load=[1.0])


@pytest.fixture(scope="module")
def diagram():
    model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
    return vc.branch(model.breathers("single-sided").physical(), "amplitude", from_=0.15, to=0.17, generations=1)


def named(ax):
    """The lines of a picture by what the legend calls them."""
    return {line.get_label().replace("\n", " "): line for line in ax.get_lines() if not line.get_label().startswith("_")}


def drawn(ax):
    """Points of all lines without a name, as pairs."""
    points = np.vstack([line.get_xydata() for line in ax.get_lines() if line.get_label().startswith("_")])
    return points[np.isfinite(points).all(axis=1)]


def is_off_the_data(ax):
    """The legend hides nothing, and is in the picture; so is the title."""
    ax.figure.canvas.draw()
    legend, data, whole = ax.get_legend().get_window_extent(), ax.get_window_extent(), ax.figure.bbox
    title = ax.title.get_window_extent()
    assert legend.x0 > data.x1 and legend.x1 <= whole.x1 + 1 and title.x0 >= -1 and title.x1 <= whole.x1 + 1


def test_an_orbit_is_drawn_as_it_moves(orbit):
    ax = orbit.plot()
    [line] = [line for line in ax.get_lines() if len(line.get_xdata()) > 2]
    t, u = line.get_xydata().T
    assert np.allclose(u, orbit.displacement(t * orbit.period, 0), rtol=0, atol=1e-12)
    # Both impacts are among its points, and both barriers stand there.
    assert np.isclose(u.max(), 1.4, atol=1e-12) and np.isclose(u.min(), -0.6, atol=1e-12)
    assert {line.get_ydata()[0] for line in ax.get_lines() if len(line.get_xdata()) == 2} == {1.4, 0.4 - 1.0}
    assert "unstable, Neimark–Sacker, |μ| = 1.001629" in ax.get_title().replace("\n", " ")
    profile = named(orbit.plot("profile"))
    assert len(profile) == 2
    first = profile["at t/T = 0.0000"].get_xydata()
    assert np.allclose(first[:, 1], orbit.displacement(0.0)[first[:, 0].astype(int)], rtol=0, atol=1e-12) and len(first) == 21
    ax = orbit.plot("multipliers")
    points = named(ax)["multipliers"].get_xydata()
    told = orbit.stability().multipliers
    assert len(points) == 42 and np.allclose(np.sort_complex(points[:, 0] + 1j * points[:, 1]), np.sort_complex(told))
    assert ax.get_title().count("Neimark") == 1
    is_off_the_data(ax)
    before, after = (named(orbit.plot("portrait"))[name].get_xydata() for name in ("before", "after"))
    hits = orbit.impacts
    assert sorted(before[:, 1]) == pytest.approx(sorted(hit.velocity_before for hit in hits))
    assert sorted(after[:, 1]) == pytest.approx(sorted(hit.velocity_after for hit in hits))
    with pytest.raises(vc.RequestError, match='what = "phase" is unknown'):
        orbit.plot("phase")


def test_a_diagram_shows_its_points_and_events(diagram):
    ax = diagram.plot("spectral_radius")
    points = drawn(ax)
    for branch in diagram.branches:
        for value, radius, physical in zip(branch.values, branch.spectral_radius, branch.physical):
            there = np.abs(points - [value, radius]).max(axis=1).min()
            assert not physical or there < 1e-9
    lines = named(ax)
    events = [event for branch in diagram.branches for event in branch.events if event.event in ("fold", "grazing")]
    shown = {(name, x) for name in ("fold", "grazing") if name in lines for x in lines[name].get_xdata()}
    # Of an event at which an orbit stops being physical those beside it decide.
    assert {(event.event, event.value) for event in events if event.physical} <= shown
    assert shown <= {(event.event, event.value) for event in events} and len(shown) >= 2
    assert "Neimark–Sacker" in lines and "period doubling" in lines
    is_off_the_data(ax)
    # A branch has the colour that its family has in maps.
    [family] = [line for name, line in lines.items() if name.startswith("single-sided")]
    assert family.get_color() == _pictures.class_colour("stable-single")
    # Stable is solid, unstable dashed; what changes does so at events.
    first = diagram.branches[0]
    doubling = next(event.value for event in first.events if event.event == "period-doubling")
    solid = [line.get_xydata() for line in ax.get_lines() if line.get_linestyle() == "-" and line.get_color() == family.get_color()]
    least = min(np.nanmin(points[:, 0]) for points in solid if len(points))
    assert least == pytest.approx(doubling, abs=1e-12)
    # As many points lie before an event as its place says.
    for event, place in zip(first.events, first.places):
        if event.event != "fold":
            low, high = sorted(first.values[place - 1 : place + 1])
            assert low <= event.value <= high
    with pytest.raises(vc.RequestError, match='show = "class" is unknown'):
        diagram.plot("class")


def test_curves_of_events_take_turns_in_colour(diagram):
    [point] = [event for event in diagram.branches[0].events if event.event == "period-doubling"]
    curve = vc.curve(point, "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3)
    ax = curve.plot()
    assert curve.plot(ax) is ax
    lines = named(ax)
    assert list(lines) == ["curve 1", "curve 2"] and lines["curve 1"].get_color() != lines["curve 2"].get_color()
    points = lines["curve 1"].get_xydata()
    assert {tuple(pair) for pair in points[np.isfinite(points).all(axis=1)]} == {tuple(pair) for pair in curve.values}
    # What is fixed is told, what varies is not.
    assert "ω = 1.07" in ax.get_title() and "A =" not in ax.get_title() and "e =" not in ax.get_title()


def test_regions_are_drawn_by_their_area():
    found = vc.curves("scenes/conservative-n5.toml", places=2000)
    ax = found.plot()
    assert len(ax.patches) == len(found.regions) > 10
    is_off_the_data(ax)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    # Every place has the colour of what lives there: outlines of holes leave them out.
    tried = 0
    for x, y in np.random.default_rng(3).uniform([left, low], [right, high], size=(300, 2)):
        classes = {name for (name, _, _), patch in zip(found.regions, ax.patches) if patch.get_path().contains_point((x, y))}
        own = found.class_at(x, y)
        over = [patch for patch in ax.patches if patch.get_path().contains_point((x, y))]
        assert own in classes
        tried += len(over) == 1
    assert tried > 280
    # Shares are the areas of the outlines.
    window = (right - left) * (high - low)
    for _, share, outlines in found.regions:
        x_y = [outline.T for outline in outlines]
        area = sum(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) for x, y in x_y)
        assert area / window == pytest.approx(share, abs=1e-9)
    ax = found.plot(lines=True)
    assert {"period doubling", "grazing"} <= {text.get_text() for text in ax.get_legend().get_texts()}


def test_a_run_over_its_orbit(orbit):
    run = vc.simulate(orbit, periods=20, samples=30)
    lines = named(run.plot())
    t, u = lines["simulation"].get_xydata().T
    assert t.min() >= 12 - 1 and np.allclose(u, orbit.displacement(t * orbit.period, 0), rtol=0, atol=1e-6)
    assert u.max() == pytest.approx(1.4, abs=1e-9)
    mesh = run.plot("field").collections[0]
    field = mesh.get_array().reshape(21, len(run.times))
    # The site that hits is in the middle of a ring.
    assert np.array_equal(field[10], run.displacement[:, 0]) and np.array_equal(field[0], run.displacement[:, 11])
    hits = run.plot("impacts").get_lines()[-1].get_xydata()
    assert np.array_equal(hits[:, 1], run.events["velocity_before"]) and len(hits) == run.impacts
    bare = vc.simulate(orbit, periods=5)
    assert bare.plot().get_ylabel() == "velocity before impacts"
    with pytest.raises(vc.RequestError, match="samples=50"):
        bare.plot("field")
    with pytest.raises(vc.RequestError, match="mass = 21 is out of range"):
        run.plot(mass=21)


def test_structures_are_drawn_like_chains():
    orbit = ONE.orbits("0+", omega=2.325)[0]
    ax = orbit.plot()
    line = max(ax.get_lines(), key=lambda line: len(line.get_xdata()))
    t, g = line.get_xydata().T
    place, velocity = orbit.motion(t[1:-1] * orbit.period)
    assert np.allclose(place[:, 0], g[1:-1], rtol=0, atol=1e-9) and g.max() == pytest.approx(0.1, abs=1e-12)
    # The motion obeys the equation: u'' + 0.1 u' + u = cos w(t + psi).
    times, step = np.linspace(0.3, 2.3, 9), 1e-4
    (u, v), (_, later), (_, before) = orbit.motion(times), orbit.motion(times + step), orbit.motion(times - step)
    acceleration = (later - before) / (2 * step)
    push = np.cos(2.325 * (times + orbit.psi))
    assert np.abs(acceleration + 0.1 * v + u - push[:, None]).max() < 1e-6
    branch = ONE.branch(orbit, omega=2.325, free="omega", from_=2.3, to=2.6)
    lines = named(branch.plot("spectral_radius"))
    assert lines["period doubling"].get_xdata() == pytest.approx([2.456715356], abs=1e-9)
    assert lines["period doubling"].get_ydata() == pytest.approx([1.0])
    table = ONE.sweep(["0+"], ("omega", 2.3, 2.6, 31), ("contact.0.upper", 0.08, 0.12, 3))
    assert table.shape == (3, 31) and table.dims == ("contact.0.upper", "omega")
    # The same as point by point.
    for column, omega in enumerate(table.coords["omega"]):
        [best] = [each for each in ONE.orbits("0+", omega=omega) if each.physical] or [None]
        assert table["class"][1, column] == ("none" if best is None else "stable" if best.stability["stable"] else "unstable")
        assert best is None or table["spectral_radius"][1, column] == pytest.approx(best.stability["spectral_radius"], rel=1e-9)
    assert {text.get_text() for text in table.plot().get_legend().get_texts()} >= {"stable 0+", "unstable 0+"}
    again = vc.sweep(table.scene)
    assert np.array_equal(again["margin"], table["margin"], equal_nan=True) and again.classes == table.classes
    file = vc.sweep("scenes/structures/shaw-holmes.toml")
    assert file.dims == ("omega",) and file["word"].dtype.kind == "U" and file.plot().get_ylabel() == "largest |μ|, logarithmic"


def test_one_place_says_what_a_colour_means():
    """Python types no colour: the code has none, and what it is told are the program's."""
    code = (ROOT / "crates/plot/src/map/palette.rs").read_text()
    compared = 0
    for classes, rgb in re.findall(r"\(Self::Colour, Some\((.*?)\)\) => \[(.*?)\]", code):
        for name in re.findall(r"Class::(\w+)", classes):
            name = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower()
            assert _pictures.class_colour(name) == "#" + bytes(map(int, rgb.split(", "))).hex(), name
            compared += 1
    assert compared == len(_pictures.STYLE["classes"]) == 10
    sources = sorted((ROOT / "crates/python/python/vibrochain").glob("*.py"))
    assert len(sources) > 8
    assert not [path for path in sources if re.search(r"[\"']#[0-9a-fA-F]{6}|\(\d+, \d+, \d+\)", path.read_text())]


def test_notebooks_show_a_table_and_a_picture(orbit, diagram):
    scene = vc.read_scene("scenes/conservative-n20.toml")
    scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 40, 30
    table = vc.sweep(scene)
    hits = ONE.orbits("0+", omega=2.325)
    along = ONE.branch(hits[0], 2.325, "omega", from_=2.3, to=2.5)
    large = vc.Model(vc.Chain(5000, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    shown = [
        (orbit, "neimark", True), (orbit.model, "frequency", True), (diagram, "branch 1", True), (diagram.branches[0], "fold at", True),
        (table, "stable-double", True), (vc.simulate(orbit, periods=3, samples=9), "impacts", True), (ONE, "contact 0", True),
        (hits[0], "impulse", True), (along, "period-doubling", True), (large, "frequency", False),
    ]  # fmt: skip
    for value, words, is_drawn in shown:
        text = value._repr_html_()
        assert words in text.lower() and "<table>" in text and ("<svg" in text) == is_drawn, type(value)
        assert text.count("<svg") == text.count("</svg>") and len(text) < 300_000
