"""Lengths are looked at before items: a range is a sequence of any length, and takes no memory until it is written out."""

import collections.abc
import resource
import sys

import numpy as np
import pytest

import vibrochain as vc

ENDLESS = range(10**12)


class Claims(collections.abc.Sequence):
    """A sequence that says to be long, and fails whoever asks for an item."""

    def __len__(self):
        return 10**15

    def __getitem__(self, index):
        raise AssertionError("an item was asked for")


CALLS = {
    "harmonics": lambda model, orbit, long: vc.Force(long),
    "events": lambda model, orbit, long: vc.branch(orbit, "amplitude", events=long),
    "impacts": lambda model, orbit, long: vc.Orbit.near(model, long),
    "t": lambda model, orbit, long: orbit.displacement(long),
    "t of a velocity": lambda model, orbit, long: orbit.velocity([[0.0, 1.0], long]),
    "sites": lambda model, orbit, long: orbit.displacement([0.0], long),
    "displacement": lambda model, orbit, long: vc.simulate(model, displacement=long, velocity=[0.0] * 21),
    "velocity": lambda model, orbit, long: vc.simulate(model, displacement=[0.0] * 21, velocity=long),
    "perturbation": lambda model, orbit, long: vc.simulate(orbit, perturbation=([0.0] * 21, long)),
    "times": lambda model, orbit, long: vc.simulate(orbit, times=long),
    "weights": lambda model, orbit, long: vc.Contact(weights=long),
    "mass": lambda model, orbit, long: vc.Structure(long, [1.0], contacts=[]),
    "load": lambda model, orbit, long: vc.Structure([1.0], [1.0], contacts=[], load=long),
    "static_load": lambda model, orbit, long: vc.Structure([1.0], [1.0], contacts=[], static_load=long),
    "frequencies": lambda model, orbit, long: vc.Structure.modal(long, [0.1], [[1.0]], contacts=[]),
    "words": lambda model, orbit, long: vc.Structure([1.0], [1.0], contacts=[]).sweep(long, ("omega", 1.0, 2.0, 3)),
    "families": lambda model, orbit, long: vc.words(model, families=long),
    # What functions of the package hand to one another: as good as public, as the process would end.
    "a list of panes": lambda model, orbit, long: vc._vibrochain._svg(long),
    "a list of impacts": lambda model, orbit, long: vc._vibrochain._structure_pane("{}", long, 0.0, 1, "motion"),
    "a list of times": lambda model, orbit, long: vc._vibrochain._structure_motion("{}", [], 0.0, 1, long),
    "a list of points": lambda model, orbit, long: vc._vibrochain._run_pane("", long, [], []),
}


@pytest.mark.parametrize("long", [ENDLESS, range(10**30), Claims()], ids=["range", "longer than a length", "claims"])
@pytest.mark.parametrize("name", CALLS)
def test_a_sequence_too_long_is_refused_by_its_name(name, long, model, orbit):
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(vc.RequestError, match=f"{' '.join(name.split()[: 2 if name.startswith('a ') else 1])}: .* are too many: give at most") as error:
        CALLS[name](model, orbit, long)
    assert isinstance(error.value, ValueError)
    # In KiB, on Linux: nothing was written out.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak < 100_000 or sys.platform == "darwin"


def test_an_array_is_longer_than_its_memory(model, orbit):
    long = np.broadcast_to(0.0, 10**10)
    for call in [
        lambda: orbit.displacement(long),
        lambda: orbit.displacement(np.broadcast_to(0, 10**10)),
        lambda: vc.simulate(orbit, times=long),
        lambda: vc.simulate(orbit, perturbation=(long, long)),
        lambda: vc.sweep({"model": {"sites": 5}, "sweep": {"x": {"parameter": "omega", "values": long}}}),
    ]:
        with pytest.raises(vc.RequestError, match="is too long|are too many"):
            call()
    half = np.broadcast_to(0.0, 10**9)
    with pytest.raises(vc.TooLargeError, match="give fewer times or sites"):
        orbit.displacement(half)
    with pytest.raises(vc.TooLargeError, match="give fewer times or sites"):
        vc.simulate(orbit, times=half)
    with pytest.raises(vc.RequestError, match="displacement has 1000000000 entries, the lattice has 21 masses"):
        vc.simulate(model, displacement=half, velocity=[0.0] * 21)


def test_what_is_no_sequence_or_no_number_is_told_by_name(model, orbit):
    endless = []
    endless.append(endless)
    for call, told in [
        (lambda: vc.Force(1.0), "harmonics is of type float: give a sequence"),
        (lambda: vc.branch(orbit, "amplitude", events="fold"), "events is of type str: give a sequence"),
        (lambda: vc.branch(orbit, "amplitude", events=5), "events is of type int: give a sequence"),
        (lambda: orbit.displacement(["a"]), "t: could not convert"),
        (lambda: orbit.displacement({}), "t: "),
        (lambda: orbit.displacement(endless), "t: "),
        (lambda: vc.simulate(orbit, times=["a"]), "times: could not convert"),
        (lambda: model.replace(omega="a"), "omega: must be real number"),
    ]:
        with pytest.raises((TypeError, ValueError), match=told):
            call()


def test_what_stops_a_structure_is_told_by_name():
    stop = vc.Contact(at=0, upper=0.1)
    one = vc.Structure([1.0], [1.0], contacts=[stop], load=[1.0])
    wrong = {
        "between = 0.1 is no pair of coordinates": lambda: vc.Contact(0, 0.1),
        "at = 0.5 is no coordinate": lambda: vc.Contact(at=0.5),
        "upper = 'x' is no number": lambda: vc.Contact(at=0, upper="x"),
        "contacts is one Contact: give a list": lambda: vc.Structure([1.0], [1.0], contacts=stop),
        r"contacts\[1\] is of type dict: give vibrochain.Contact": lambda: vc.Structure([1.0], [1.0], contacts=[stop, {}]),
        "mass of shape .* is not square": lambda: vc.Structure(np.ones((2, 3)), [1.0], contacts=[stop]),
    }
    for told, call in wrong.items():
        with pytest.raises(vc.RequestError, match=told):
            call()
    for call in [lambda: one.sweep("0+", ("omega", 1.0, 2.0, 3)), lambda: one.scene("0+", ("omega", 1.0, 2.0, 3))]:
        with pytest.raises(TypeError, match='words is of type str: give a sequence, as in \\["0\\+"\\]'):
            call()
    assert vc.Contact(weights=np.array([1, -1])).weights == (1.0, -1.0)
    assert vc.Contact(between=[0, 1], lower=np.float64(-1)).between == [0, 1]
