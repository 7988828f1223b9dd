"""What Python is told is what the program prints, to the bit. (Numbers that are printed read back as they were.)"""

import csv
import math
import re
import subprocess

import numpy as np
import pytest

import vibrochain as vc

from answers import written
from conftest import ROOT
from models import random_models


def flags(model):
    """The command line of a model."""
    chain = model.chain
    yield from ["--sites", chain.sites, "--gamma1", chain.gamma1, "--gamma2", chain.gamma2, "--omega", model.omega]
    yield from ["--asymmetry", model.asymmetry, "--restitution", model.restitution, "--ends", chain.ends]
    if chain.layers > 1:
        yield from ["--layers", chain.layers, "--gamma3", chain.gamma3, "--layer-ends", chain.layer_ends]
    if len(model.force.harmonics) > 1:
        yield from ["--force", str(model.force)]
    else:
        yield from ["--amplitude", model.amplitude]


def run(mapgen, command, *arguments):
    words = [mapgen, command, *(word if isinstance(word, str) else repr(word) for word in arguments)]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def same(ours, theirs):
    """To the bit; what has no bound is null in JSON."""
    if isinstance(ours, float) and not math.isfinite(ours):
        return theirs is None
    return ours == theirs and type(ours) is type(theirs) and (ours != 0 or math.copysign(1, ours) == math.copysign(1, theirs))


def compare(ours, theirs, names):
    for name in names:
        value = getattr(ours, name)
        assert same(value, theirs[name]), f"{name}: {value!r}, {theirs[name]!r}"


def compare_orbit(orbit, solution):
    compare(orbit, solution, ["family", "period", "phi", "psi", "residual"])
    assert len(orbit.impacts) == len(solution["impacts"])
    for impact, theirs in zip(orbit.impacts, solution["impacts"]):
        compare(impact, theirs, ["site", "barrier", "time", "impulse", "velocity_before", "velocity_after"])
        assert impact.layer == theirs.get("layer", 0)
    compare(orbit.condition(), solution["condition"], solution["condition"])
    answer = orbit.admissibility()
    compare(answer, solution, ["physical", "margin"])
    assert (answer.obstruction is None) == (solution["obstruction"] is None)
    if answer.obstruction:
        told = dict(solution["obstruction"])
        # Words name a mass of layers by row and layer, a number alone counts through all.
        assert re.sub(r"site \d+", "site", str(answer.obstruction)) == re.sub(r"site \d+(:\d+)?", "site", told.pop("message"))
        compare(answer.obstruction, told, told)
    if solution["stability"] is None:
        with pytest.raises(vc.VibrochainError) as error:
            orbit.stability()
        assert str(error.value) == solution["stability_error"]
        return 0
    stability, told = orbit.stability(), solution["stability"]
    compare(stability, told, ["stable", "undecided", "mechanism", "spectral_radius", "excess", "resolution", "method"])
    pairs = [[multiplier.real, multiplier.imag] for multiplier in stability.multipliers.tolist()]
    assert pairs == told["multipliers"]
    return 1


WORDS = ["double-sided", "single-sided", "period-doubled", "double-sided", "0-", "0+,0-"]


def test_two_hundred_models(mapgen):
    models = list(random_models(200))
    orbits = judged = refused = 0
    for i, model in enumerate(models):
        which = WORDS[i % len(WORDS)]
        told = run(mapgen, "orbit", "--json", *flags(model), "--word" if "0" in which else "--family", which)
        try:
            found = model.breathers(which)
        except vc.VibrochainError as error:
            assert told.returncode != 0 and str(error) in told.stderr, f"{model!r} {which}: {error}, {told.stderr}"
            refused += 1
            continue
        assert told.stdout, f"{model!r} {which}: {told.stderr}"
        value = written(mapgen, told.stdout)
        assert value["reason"] == found.reason
        known = value["completeness"]
        assert (found.completeness.established, found.completeness.by) == (known["established"], known["by"])
        assert found.completeness.effort == next((known[key] for key in ["intervals", "boxes", "starts"] if key in known), None)
        assert (found.completeness.unresolved, found.completeness.exhausted) == (value["unresolved"], value["exhausted"])
        assert len(found) == len(value["solutions"]), repr(model)
        for orbit, solution in zip(found, value["solutions"]):
            judged += compare_orbit(orbit, solution)
            orbits += 1
    print(f"{len(models)} models, {orbits} orbits, {judged} judged, {refused} refused")
    assert orbits > 200 and judged > 150 and refused < 20


def test_words_of_several_sites(mapgen):
    orbits = 0
    for word in ["0+3+,0-3-", "0+3-,0-3+", "0-,2-"]:
        model = vc.Model(vc.Chain(21, 0.2, 0.05), omega=1.5, asymmetry=0.2)
        value = written(mapgen, run(mapgen, "orbit", "--json", *flags(model), "--word", word).stdout)
        found = model.breathers(word)
        assert len(found) == len(value["solutions"])
        for orbit, solution in zip(found, value["solutions"]):
            assert orbit.word == solution["word"]
            compare_orbit(orbit, solution)
            orbits += 1
    assert orbits >= 2


SCENES = {
    "conservative": """
        [model]
        sites = 21
        gamma1 = 0.2
        asymmetry = 0.4
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 61 }
        y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 43 }
        [compute]
        families = ["double-sided", "single-sided"]
        stability = true
        collisions = true
        impulse = true
    """,
    "forced": """
        title = "With a force"
        [model]
        sites = 11
        gamma1 = 0.2
        asymmetry = 0.4
        restitution = 0.9
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 17 }
        y = { parameter = "gamma2", values = [0.0, 0.3, 0.1] }
        axes = [{ parameter = "amplitude", from = 0.01, to = 1.0, points = 3, spacing = "log" }]
        [compute]
        families = ["double-sided", "single-sided"]
        stability = true
        threshold = 0.01
    """,
    "existence": """
        [model]
        sites = 6
        ends = "free"
        gamma1 = 0.2
        gamma2 = 0.1
        asymmetry = 0.4
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 50 }
        [compute]
        families = ["double-sided", "0-,2-"]
    """,
}


@pytest.mark.parametrize("name", SCENES)
def test_a_map_is_the_table(name, mapgen, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENES[name])
    told = run(mapgen, "sweep", str(scene), "--out", str(tmp_path / "map.csv"))
    assert told.returncode == 0, told.stderr
    header, *rows = [line.split(",") for line in (tmp_path / "map.csv").read_text().splitlines()]
    maps = [vc.sweep(scene, threads=1), vc.sweep(scene, threads=3)]
    # A dictionary, and the manifest of the table, are the same scene.
    maps += [vc.sweep(vc.read_scene(scene)), vc.sweep(tmp_path / "map.manifest.json"), vc.sweep(maps[0].scene)]
    manifest = written(mapgen, (tmp_path / "map.manifest.json").read_text())
    for table in maps:
        assert list(table.columns) == header and len(table) == len(rows) > 40
        for place, column in enumerate(header):
            fields = [row[place] for row in rows]
            values = table[column].reshape(-1).tolist()
            if isinstance(values[0], str):
                assert values == fields
            else:
                missing = [math.isnan(value) for value in values]
                assert missing == [field == "" for field in fields]
                assert [value for value in values if not math.isnan(value)] == [float(field) for field in fields if field]
        assert table.classes == manifest["classes"] and table.statuses == manifest["statuses"]
        assert table.worst_residual == manifest["worst_residual"]
    assert maps[0].scene["sweep"] == manifest["sweep"]


@pytest.mark.parametrize("breathers", ["class", "every", "unstable"])
def test_an_ensemble_is_the_table(breathers, mapgen, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text((ROOT / "tests" / "data" / "scenes" / "fate.toml").read_text())
    asked = {"breathers": breathers, "starts": 3, "perturb": 0.05, "seed": 7, "periods": 150, "transient": 0.4, "leave": 0.2}
    words = [word for name, value in asked.items() for word in [f"--{name}", value]]
    told = run(mapgen, "fate", str(scene), "--csv", str(tmp_path / "fate.csv"), "--json", *words)
    assert told.returncode == 0, told.stderr
    answer = written(mapgen, told.stdout)
    with open(tmp_path / "fate.csv", newline="") as file:
        header, *rows = csv.reader(file)
    results = [vc.fate(scene, threads=1, **asked), vc.fate(vc.read_scene(scene), threads=3, **asked)]
    for found in results:
        assert found.ends == answer["ends"] and found.dims == ("gamma2", "omega") and found.shape == (3, 4)
        # Parameters have the grid's shape, and so has all else where runs start from one breather a cell.
        grid = ["gamma2", "omega", "solutions", "status"]
        per_breather = [name for name in found.columns if name not in grid and name in header]
        assert set(found.columns) >= set(header) and len(per_breather) == len(header) - 4
        shapes = {found[name].shape for name in per_breather}
        most = int(found["number"].max())
        assert shapes == {(3, 4) if breathers == "class" else (3, 4, 2)} and most <= 2
        assert all(found[name].shape == (3, 4) for name in grid)
        seen = 0
        for row in rows:
            fields = dict(zip(header, row))
            place = tuple(
                int(np.flatnonzero(found.coords[name] == float(fields[name]))[0]) for name in found.dims
            )  # fmt: skip
            assert found["solutions"][place] == int(fields["solutions"]) and found["status"][place] == fields["status"]
            if not fields["number"]:
                assert not found["number"][place].any() and np.isnan(found["share_chaos"][place]).all()
                continue
            if breathers != "class":
                place = (*place, int(fields["number"]) - 1)
            seen += 1
            for name in per_breather:
                value = found[name][place].item()
                if isinstance(value, str):
                    assert value == fields[name], name
                elif fields[name] == "":
                    assert math.isnan(value), name
                else:
                    assert value == float(fields[name]), name
        assert seen == int((found["number"] > 0).sum()) == answer["breathers"] > 3
    for wrong, message in [
        ({"starts": 0}, "^starts 0 is out of range: give a whole number from 1 to 10000"),
        ({"starts": -1}, "^starts = -1 is out of range"),
        ({"seed": -1}, "^seed = -1 is out of range: give a whole number from 0 to 18446744073709551615"),
        ({"seed": 2**64}, "^seed = 18446744073709551616 is out of range"),
        ({"periods": 5}, "^periods 5 is out of range"),
        ({"perturb": 2.0}, "^perturb 2 is out of range: give a size from 0 to 1"),
        ({"breathers": "some"}, 'give one of "class", "every", "unstable"'),
    ]:
        with pytest.raises(vc.RequestError, match=message):
            vc.fate(scene, **wrong)
    with pytest.raises(vc.TooLargeError, match="the limit is 1000000"):
        vc.fate("scenes/three-parameters.toml")


def test_a_run_is_the_table(mapgen, tmp_path):
    model = vc.Model(vc.Chain(11, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
    files = {name: tmp_path / f"{name}.csv" for name in ["impacts", "trajectory"]}
    told = run(
        mapgen, "simulate", *flags(model), "--family", "double-sided", "--periods", "30.3", "--samples", "16",
        *(word for name, path in files.items() for word in [f"--{name}", str(path)]),
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    result = vc.simulate(model.breathers("double-sided").physical(), periods=30.3, samples=16)
    rows = [line.split(",") for line in files["impacts"].read_text().splitlines()]
    names = rows.pop(0)
    assert len(rows) == len(result.events) == 61
    for place, name in enumerate(names):
        told = [type(value)(row[place]) for row, value in zip(rows, result.events[name].tolist())]
        if name == "time":
            # The table has the impact that a run begins on at 0 exactly.
            assert told[0] == 0 and abs(result.events[name][0]) < 1e-14
            told[0] = result.events[name][0]
        assert told == result.events[name].tolist(), name
    table = np.array([[float(field) for field in line.split(",")] for line in files["trajectory"].read_text().splitlines()[1:]])
    ours = np.column_stack([result.times, result.displacement, result.velocity])
    assert ours.shape == (486, 23) and np.array_equal(table, ours)


def test_events_along_a_parameter(mapgen):
    model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
    orbit = model.breathers("single-sided").physical()
    start = [*flags(model), "--family", "single-sided", "--free", "amplitude", "--json"]
    told = written(mapgen, run(mapgen, "locate", "--event", "period-doubling", *start).stdout)
    answer = vc.locate(orbit, "period-doubling", "amplitude")
    assert list(answer.range) == told["range"] and len(answer.points) == len(told["points"]) == 1
    for point, theirs in zip(answer.points, told["points"]):
        compare(point, theirs, ["event", "value", "error", "physical"])
        assert [point.multiplier.real, point.multiplier.imag] == theirs["evidence"]["multiplier"]
        assert [(value, physical) for value, _, physical in point.sides] == [(side["value"], side["physical"]) for side in theirs["sides"]]
        assert len(point.branching) == len(theirs["branching"]["orbits"]) == 1
        for branched, solution in zip(point.branching, theirs["branching"]["orbits"]):
            assert branched.orbit.period == solution["period"] and branched.physical == solution["physical"]
    assert [(end.value, end.reason) for end in answer.ends] == [(end["value"], end["reason"]) for end in told["ends"]]

    told = written(mapgen, run(mapgen, "branch", *start, "--to", "0.17", "--switch").stdout)
    diagram = vc.branch(orbit, "amplitude", to=0.17, generations=1)
    assert diagram.complete == told["complete"] and len(diagram.branches) == len(told["branches"]) >= 2
    for branch, theirs in zip(diagram.branches, told["branches"]):
        assert branch.values.tolist() == [point["value"] for point in theirs["points"]]
        radii = [point["stability"]["spectral_radius"] for point in theirs["points"]]
        assert branch.spectral_radius.tolist() == radii
        assert [event.value for event in branch.events] == [event["value"] for event in theirs["events"]]
        assert (branch.origin is None) == (theirs["origin"] is None)
        if branch.origin:
            assert branch.origin == (theirs["origin"]["branch"] - 1, theirs["origin"]["value"])


def test_a_curve_of_events(mapgen):
    model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
    window = {"from_": 0.1, "to": 0.3, "and_from": 0.2, "and_to": 0.3}
    words = [word for name, value in window.items() for word in [f"--{name.strip('_').replace('_', '-')}", value]]
    told = run(
        mapgen, "curve", *flags(model), "--family", "single-sided", "--event", "period-doubling",
        "--free", "amplitude", "--and", "restitution", "--tolerance", "1e-4", "--json", *words,
    )  # fmt: skip
    [theirs] = written(mapgen, told.stdout)["curves"]
    [point] = vc.locate(model.breathers("single-sided").physical(), "period-doubling", "amplitude", from_=0.1, to=0.3).points
    curve = vc.curve(point, "restitution", tolerance=1e-4, **window)
    assert curve.values.tolist() == [point["values"] for point in theirs["points"]]
    assert curve.errors.tolist() == [point["error"] for point in theirs["points"]]


def test_borders(mapgen):
    scene, options = "scenes/conservative-n5.toml", {"tolerance": 5e-6, "places": 2000}
    ours = vc.curves(scene, special=True, threads=2, **options)
    theirs = written(mapgen, run(mapgen, "curves", scene, "--tolerance", 5e-6, "--places", 2000, "--json").stdout)
    assert len(ours.borders) == len(theirs["borders"]) > 20
    for one, other in zip(ours.borders, theirs["borders"]):
        assert (one.family, one.event, list(one.ends)) == (other["family"], other["event"], other["ends"])
        assert one.values.tolist() == [point["values"] for point in other["points"]]
        assert all(same(error, point["error"]) for error, point in zip(one.errors.tolist(), other["points"]))
        assert all(same(width, point["half_width"]) for width, point in zip(one.half_widths.tolist(), other["points"]))
        assert [place for _, place, _ in one.special] == [point["point"] for point in other["special"]]
        stripe = other["stripe"] and (*other["stripe"]["modes"], other["stripe"]["harmonic"], other["stripe"]["upper"])
        assert one.stripe == stripe
    assert ours.stripes == sum(border["stripe"]["upper"] for border in theirs["borders"] if border["stripe"])
    assert sum(error for _, error in ours.areas.values()) < 1e-2
    areas = {area["class"] or "unknown": (area["share"], area["error"]) for area in theirs["areas"]}
    assert ours.areas == areas and len(areas) > 4
    # What lives at a point is what the map's cell says, away from borders.
    scene = vc.read_scene(scene)
    scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 23, 17
    table, agreed = vc.sweep(scene), 0
    for j, gamma2 in enumerate(table.coords["gamma2"]):
        for i, omega in enumerate(table.coords["omega"]):
            agreed += ours.class_at(omega, gamma2) == table["class"][j, i]
    # A point of the grid may lie on a border or the window's edge.
    assert agreed >= 23 * 17 - 4
    with pytest.raises(vc.RequestError, match="outside the window"):
        ours.class_at(100.0, 0.1)
    with pytest.raises(vc.RequestError, match="tolerance"):
        vc.curves(scene, tolerance=1.0)
