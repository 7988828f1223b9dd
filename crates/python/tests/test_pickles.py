"""Whatever the package hands out can be copied, pickled and sent to other processes, and is the same to the bit."""

import copy
import inspect
import multiprocessing
import pickle

import numpy as np
import pytest

import vibrochain as vc

from models import random_models


def told(value):
    """All that a value says of itself, down to numbers."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, dict):
        return {key: told(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [told(item) for item in value]
    if type(value).__module__.startswith("vibrochain"):
        names = set(getattr(value, "__dict__", ()))
        for kind in type(value).__mro__[:-1]:
            names.update(name for name, item in vars(kind).items() if inspect.isdatadescriptor(item))
        parts = {name: told(getattr(value, name)) for name in names if not name.startswith("__")}
        return type(value).__name__, repr(value), parts
    return repr(value)


@pytest.fixture(scope="module")
def values():
    """One value of each class."""
    free = vc.Model(vc.Chain(21, 0.2, 0.1), omega=0.3, asymmetry=0.4)
    forced = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
    found = forced.breathers("single-sided")
    orbit = found.physical()
    events = vc.locate(orbit, "period-doubling", "amplitude")
    diagram = vc.branch(orbit, "amplitude", from_=0.158, to=0.166, generations=1)
    curve = vc.curve(events.points[0], "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3)
    borders = vc.curves("scenes/conservative-n5.toml", places=2000, special=True)
    scene = vc.read_scene("scenes/fate-n20.toml")
    scene["model"]["sites"], scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 5, 3, 2
    beyond = free.breathers("double-sided").orbits[0].admissibility()
    listed = [
        free, free.chain, forced.force, found, found.completeness, orbit, orbit.impacts[0], orbit.condition(), orbit.stability(),
        orbit.stability().verdict, beyond, beyond.obstruction, events, events.points[0], events.ends[0], diagram, diagram.branches[1],
        diagram.branches[0].points[0], curve, borders, borders.borders[0], vc.sweep(scene), vc.fate(scene, starts=2, periods=50),
        vc.simulate(orbit, periods=3, samples=4),
    ]
    stop = vc.Contact(at=0, upper=0.1, restitution=0.8)
    oscillator = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])
    hits = oscillator.orbits("0+", omega=2.325)
    along = oscillator.branch(hits[0], 2.325, "omega", from_=2.3, to=2.5)
    doubling = oscillator.curves(hits[0], 2.325, "period-doubling", ("omega", "load"), from_=(2.3, 0.8), to=(2.6, 1.2))
    listed += [stop, oscillator, hits, hits[0], along, doubling[0]]  # fmt: skip
    return {type(value).__name__: value for value in listed}


COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    **{f"pickle {n}": lambda value, n=n: pickle.loads(pickle.dumps(value, n)) for n in range(2, pickle.HIGHEST_PROTOCOL + 1)},
}


def classes():
    public = [getattr(vc, name) for name in vc.__all__]
    # A process at work is no value.
    return [each.__name__ for each in public if inspect.isclass(each) and not issubclass(each, (Exception, vc.Explorer))]


@pytest.mark.parametrize("name", classes())
def test_every_value_can_be_copied_and_pickled(name, values):
    value = values[name]
    expected = told(value)
    assert len(expected[2]) > 1 and len(COPIES) > 4
    for made in COPIES.values():
        again = made(value)
        assert type(again) is type(value) and told(again) == expected
        if type(value).__eq__ is not object.__eq__:
            assert again == value


def test_copies_answer_as_what_they_are_copies_of(values):
    orbit, borders, point = (pickle.loads(pickle.dumps(values[name])) for name in ["Orbit", "Borders", "Located"])
    times = np.linspace(0, orbit.period, 50)
    assert np.array_equal(orbit.displacement(times), values["Orbit"].displacement(times))
    assert told(orbit.stability()) == told(values["Orbit"].stability())
    places = [(x, y) for x in np.linspace(0.4, 3.0, 30) for y in np.linspace(0.0, 0.3, 30)]
    classes = [borders.class_at(*place) for place in places]
    assert classes == [values["Borders"].class_at(*place) for place in places] and len(set(classes)) > 3
    window = {"from_": 0.1, "to": 0.3, "and_from": 0.2, "and_to": 0.3, "tolerance": 1e-3}
    assert told(vc.curve(point, "restitution", **window)) == told(values["EventCurve"])


def test_orbits_of_all_kinds_of_models_come_back():
    compared = 0
    for model in random_models(60):
        for which in ["double-sided", "single-sided", "period-doubled"]:
            try:
                found = model.breathers(which)
            except vc.ResonanceError:
                continue
            again = pickle.loads(pickle.dumps(found))
            assert list(again) == list(found) and told(again.completeness) == told(found.completeness)
            compared += len(found)
    word = vc.Model(vc.Chain(21, 0.2, 0.05), omega=1.5, asymmetry=0.2).breathers("0+3-,0-3+")
    assert list(pickle.loads(pickle.dumps(word))) == list(word) and len(word) == 1
    assert compared > 60


def test_other_processes_take_them(values):
    orbits = [point.orbit for point in values["Diagram"].branches[0].points][:6]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        found = pool.map(vc.Orbit.stability, orbits)
    assert len(found) == 6 and [told(each) for each in found] == [told(orbit.stability()) for orbit in orbits]


def test_a_pickle_that_cannot_be_read_says_what_to_do(values):
    restore, (version, data) = vc._vibrochain._reduce(values["Orbit"])
    assert version == vc.__version__
    for wrong in [b"", b"\xff\xff", data[:-9], data.replace(b"PyOrbit", b"PyOrbut")]:
        with pytest.raises(vc.RequestError, match=f"of vibrochain 0.0.1 cannot be read by vibrochain {version} .*once more"):
            restore("0.0.1", wrong)
    # An impact of a mass that the chain does not have.
    far = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    hits = [(7, "upper", 0, -1.28), (7, "lower", far.period / 2, 1.95)]
    short = pickle.dumps(vc.Orbit.near(far, hits)).replace(b"\x65sites\x15", b"\x65sites\x05")
    with pytest.raises(vc.RequestError, match="not those of an orbit of their model"):
        pickle.loads(short)
