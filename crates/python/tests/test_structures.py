"""Structures from matrices, against free motion and against each other."""

import concurrent.futures
import copy
import pathlib
import pickle

import numpy as np
import pytest

import vibrochain as vc

STOP = vc.Contact(at=1, lower=-0.7, upper=0.6, restitution=0.8)
MASS = np.diag([1.0, 1.4])
STIFFNESS = np.array([[1.0, -0.3], [-0.3, 0.8]])
DAMPING = np.diag([0.02, 0.02])


def both(**changes):
    given = {"damping": DAMPING, "contacts": [STOP], "load": [0.5, 0.0], **changes}
    return vc.Structure(MASS, STIFFNESS, **given)


def test_orbits_obey_the_equations_of_motion():
    """Each orbit begun just after its first impact comes back, by fine steps of Runge and Kutta."""
    checked = 0
    for omega in (0.6, 1.3):
        for word in ("0+", "0+,0-"):
            for orbit in both().orbits(word, omega=omega):
                if not orbit.physical:
                    continue
                flights = [(hit["time"], hit) for hit in orbit.impacts]
                ends = [later for later, _ in flights[1:]] + [orbit.period]
                # The state is found by the flow itself: linear in it, closed by the impulses.
                inverse = np.linalg.inv(MASS)

                def slope(t, y):
                    push = np.array([0.5 * np.cos(omega * (t + orbit.psi)), 0.0])
                    return np.concatenate([y[2:], inverse @ (push - STIFFNESS @ y[:2] - DAMPING @ y[2:])])

                def flow(y, a, b, steps=4000):
                    h = (b - a) / steps
                    for i in range(steps):
                        t = a + i * h
                        k1 = slope(t, y)
                        k2 = slope(t + h / 2, y + h / 2 * k1)
                        k3 = slope(t + h / 2, y + h / 2 * k2)
                        k4 = slope(t + h, y + h * k3)
                        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                    return y

                def around(y):
                    for (begin, hit), end in zip(flights, ends):
                        y = y + np.concatenate([[0, 0], inverse @ np.array([0, hit["impulse"]])])
                        y = flow(y, begin, end)
                    return y

                base = around(np.zeros(4))
                matrix = np.array([around(row) - base for row in np.eye(4)]).T
                start = np.linalg.solve(np.eye(4) - matrix, base)
                first = orbit.impacts[0]
                place = STOP.upper if first["barrier"] == "upper" else STOP.lower
                assert abs(start[1] - place) < 1e-9
                assert abs(start[3] - first["velocity_before"]) < 1e-9
                checked += 1
    assert checked >= 3


def test_forms_of_matrices_are_one():
    told = both().orbits("0+", omega=0.6)
    for other in (vc.Structure([1.0, 1.4], STIFFNESS.tolist(), [0.02, 0.02], contacts=(STOP,), load=np.array([0.5, 0j])),):
        again = other.orbits("0+", omega=0.6)
        assert [a.impacts for a in again] == [b.impacts for b in told]
    sparse = pytest.importorskip("scipy.sparse")
    again = both(damping=sparse.csr_matrix(DAMPING)).orbits("0+", omega=0.6)
    assert [a.impacts for a in again] == [b.impacts for b in told]


def test_few_modes_are_those_of_lapack():
    load = np.array([1.0, 0.5])
    half = np.diag(np.diag(MASS) ** -0.5)
    squares, vectors = np.linalg.eigh(half @ STIFFNESS @ half)
    rate, shape = np.sqrt(squares[0]), half @ vectors[:, 0]
    few = vc.Structure(MASS, STIFFNESS, 0.1 * MASS, contacts=[STOP], load=load, modes=1)
    tip = vc.Contact(lower=-0.7, upper=0.6, restitution=0.8)
    alone = vc.Structure.modal([rate], [0.05 / rate], [[shape[1]]], contacts=[tip], load_shapes=[shape @ load])
    whole = vc.Structure(MASS, STIFFNESS, 0.1 * MASS, contacts=[STOP], load=load)
    impulses = [[orbit.impacts[0]["impulse"] for orbit in one.orbits("0+", omega=0.5)] for one in (few, alone, whole)]
    assert len(impulses[0]) == 2 and np.allclose(impulses[0], impulses[1], rtol=1e-12, atol=0)
    assert not np.allclose(impulses[0], impulses[2], rtol=1e-3)
    for modes in (0, 3):
        with pytest.raises(vc.RequestError, match="modes = "):
            vc.Structure(MASS, STIFFNESS, contacts=[STOP], modes=modes).orbits("0+", omega=0.5)


def test_an_event_that_rounding_hides_is_told():
    """A crossing of the circle whose place is known to forty digits from elsewhere: the branch has it, or a range that holds it."""
    mass = [
        [0.7437917384682091, -0.10649125917486568, -0.027455372409473666],
        [-0.10649125917486568, 1.854002485409669, -0.05998744780790608],
        [-0.027455372409473666, -0.05998744780790608, 0.894163976577072],
    ]
    stiffness = [
        [0.96733385321138, 1.0541812891397515, -1.2427155830375107],
        [1.0541812891397515, 1.6679763119615, -1.7188229481413906],
        [-1.2427155830375107, -1.7188229481413906, 2.2193251394193143],
    ]
    damping = [
        [0.0009238133966571123, 0.0004377152861348759, -0.00014196926451629204],
        [0.0004377152861348759, 0.001212385640484097, -7.239740158481128e-05],
        [-0.00014196926451629204, -7.239740158481128e-05, 0.0011638040096972847],
    ]
    hit = vc.Contact(weights=[1.0, 0.0, 0.0], upper=-0.11192930404971192, restitution=0.5)
    load = [-1.1242444682723935, -2.6219963990933213, -0.1705754422842902]
    still = [-0.2333316442128846, 0.23261972709696194, 0.4325025846629874]
    whole = vc.Structure(mass, stiffness, damping, contacts=[hit], load=load, static_load=still)
    omega, place = 0.514982390428796, 0.514147684994445
    branch = whole.branch(whole.orbits("0+", omega=omega)[0], omega=omega, free="omega", from_=0.5 * omega, to=2 * omega)
    found = [event["value"] for event in branch.events if event["event"] == "neimark-sacker"]
    hidden = [place for low, high in branch.unresolved if low - 1e-14 <= place <= high + 1e-14]
    assert hidden or min(abs(value - place) for value in found) < 1e-10
    assert not branch.unresolved or "a sign of more" in repr(branch)


def test_multipliers_and_copies():
    orbit = both().orbits("0+", omega=0.6)[1]
    assert orbit.multipliers.shape == (4,)
    assert abs(abs(orbit.multipliers[0]) - orbit.stability["spectral_radius"]) < 1e-12
    # Liouville: the product of all is e² times what dashpots take.
    trace = np.trace(np.linalg.inv(MASS) @ DAMPING)
    assert abs(np.prod(orbit.multipliers) - 0.8**2 * np.exp(-trace * orbit.period)) < 1e-12
    for again in (copy.deepcopy(orbit), pickle.loads(pickle.dumps(orbit))):
        assert again == orbit
    assert pickle.loads(pickle.dumps(both())).orbits("0+", omega=0.6)[1] == orbit
    assert repr(orbit).startswith("<StructureOrbit 0+: period 10.47") and repr(orbit).count("unstable (period-doubling), spectral radius 1.44") == 1
    assert repr(both().orbits("0+", omega=0.6)) == "<2 orbits, 1 physical, complete, by closed form>"
    assert repr(both()) == "Structure(2 coordinates, 1 contact)"


def test_what_is_wrong_is_told():
    with pytest.raises(vc.RequestError, match="positive definite"):
        vc.Structure(-MASS, STIFFNESS, contacts=[STOP]).orbits("0+", omega=1.0)
    with pytest.raises(vc.RequestError, match="contact 1 does not exist"):
        both().orbits("1+", omega=1.0)
    with pytest.raises(vc.RequestError, match="square"):
        vc.Structure(np.ones((2, 3)), STIFFNESS, contacts=[STOP])
    with pytest.raises(vc.RequestError, match="omega"):
        both().orbits("0+", omega=-1.0)
    with pytest.raises(vc.NoBreatherError, match="give a load"):
        both(load=None).orbits("0+", omega=1.0)


def test_branches_and_curves_meet_what_is_known_by_hand():
    """Grazing of a damped oscillator is at A = d sqrt((1 - w^2)^2 + c^2 w^2); at a doubling that is located an orbit has the multiplier -1."""
    stop = vc.Contact(at=0, upper=1.0, restitution=0.8)
    one = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])
    first = one.orbits("0+", omega=1.0)[0]
    branch = one.branch(first, 1.0, "load", from_=0.02, to=2.0, events=["grazing"])
    assert branch.values.shape == branch.spectral_radius.shape == branch.physical.shape and branch.impulses.shape == (len(branch.values), 1)
    assert branch.physical.any() and branch.stable.any() and branch.ends[0][0] == pytest.approx(2.0)
    assert {found["event"] for found in branch.events} == {"grazing"}
    still = [found["value"] for found in branch.events if "impact" in found["evidence"]]
    assert still == pytest.approx([0.1], abs=1e-12)
    known = 0
    for curve in one.curves(first, 1.0, "grazing", ("omega", "load"), from_=(0.5, 0.05), to=(2.0, 2.0)):
        omega, load = curve.values.T
        by_hand = np.sqrt((1 - omega**2) ** 2 + 0.01 * omega**2)
        known += np.abs(load - by_hand).max() < 1e-9
    assert known >= 1
    fold, = one.branch(first, 1.0, "omega", from_=0.9, to=1.9, events=["fold"]).events
    # Both orbits meet there, their multipliers at +1 by the root of the distance.
    before, beyond = [one.orbits("0+", omega=fold["value"] + aside) for aside in (-1e-8, 1e-8)]
    assert (len(before), len(beyond)) == (2, 0)
    assert max(abs(orbit.multipliers - 1.0).min() for orbit in before) < 1e-2
    with pytest.raises(vc.RequestError, match="no such number"):
        one.branch(first, 1.0, "gamma1", from_=0.1, to=1.0)
    with pytest.raises(vc.RequestError, match="is not in a range"):
        one.branch(first, 1.0, "omega", from_=1.1, to=1.5)
    with pytest.raises(vc.RequestError, match="is no event"):
        one.branch(first, 1.0, "omega", from_=0.5, to=1.5, events=["flip"])


def self_excited(damping=-0.2):
    """q'' - 0.2 q' + q = 0 with a stop below, which no load drives."""
    return vc.Structure([1.0], [1.0], damping=[damping], contacts=[vc.Contact(at=0, lower=-1.0, restitution=0.5)])


def after_a_flight(damping, velocity, t):
    """Place and velocity a time after leaving the stop."""
    decay, rate = 0.5 * damping, np.sqrt(1 - 0.25 * damping**2)
    b = (velocity - decay) / rate
    cos, sin, grown = np.cos(rate * t), np.sin(rate * t), np.exp(-decay * t)
    return grown * (b * sin - cos), grown * ((rate * b + decay) * cos + (rate - decay * b) * sin)


def test_where_nothing_has_a_frequency_none_is_asked_for():
    one = self_excited()
    found = one.orbits("0-")
    orbit, = found
    assert found.completeness.by == "enclosures" and found.periods[0] < orbit.period < found.periods[1]
    assert orbit.physical and orbit.psi is None and 0 < orbit.period_error < 1e-12
    hit = orbit.impacts[0]
    place, velocity = after_a_flight(-0.2, hit["velocity_after"], orbit.period)
    assert abs(place + 1) < 1e-12 and abs(-0.5 * velocity - hit["velocity_after"]) < 1e-12
    # A frequency that is given changes nothing, whatever it is.
    for omega in (0.3, 5.0):
        again, = one.orbits("0-", omega=omega)
        assert abs(again.period - orbit.period) < 1e-12
        assert abs(one.near(again, omega=omega).period - orbit.period) < 1e-12
        assert abs(again.motion([1.0])[0][0, 0] - orbit.motion([1.0])[0][0, 0]) < 1e-12
    place, velocity = orbit.motion([0.7, 0.7 + orbit.period])
    assert np.allclose(place[:, 0], after_a_flight(-0.2, hit["velocity_after"], 0.7)[0], rtol=0, atol=1e-12)
    assert np.allclose(velocity[:, 0], after_a_flight(-0.2, hit["velocity_after"], 0.7)[1], rtol=0, atol=1e-12)
    assert pickle.loads(pickle.dumps(orbit)) == orbit and pickle.loads(pickle.dumps(orbit)).period_error == orbit.period_error
    # That of a load has no error of its own.
    assert both().orbits("0+", omega=0.6)[0].period_error is None and both().orbits("0+", omega=0.6).periods is None

    less = self_excited(-0.19)
    near = less.near(orbit)
    assert abs(near.period - less.orbits("0-")[0].period) < 1e-12 and abs(near.period - orbit.period) > 1e-3
    branch = one.branch(orbit, free="damping", from_=0.9, to=1.1)
    assert len(branch.values) > 2 and branch.physical.all() and branch.stable.all()
    for value, period, (impulse,) in zip(branch.values, branch.period, branch.impulses):
        velocity = impulse / 3
        place, before = after_a_flight(-0.2 * value, velocity, period)
        assert abs(place + 1) < 1e-9 and abs(-0.5 * before - velocity) < 1e-9
    assert one.curves(orbit, event="fold", free=("damping", "contact.0.restitution"), from_=(0.9, 0.4), to=(1.1, 0.6)) == []

    table = one.sweep(["0-"], ("damping", 0.9, 1.1, 3))
    assert table["class"].tolist() == ["stable"] * 3
    middle = table["spectral_radius"][1]
    assert abs(middle - 0.25 * np.exp(0.2 * orbit.period)) < 1e-9
    fates = one.fate(["0-"], ("damping", 0.9, 1.1, 3), starts=1, periods=200)
    assert fates["share_breather"].tolist() == [1.0] * 3 and np.allclose(fates["spectral_radius"], table["spectral_radius"], rtol=1e-9)
    from_rest = one.fate([], ("damping", 0.9, 1.1, 3), starts=1, periods=200)
    assert [words[:2] for words in from_rest["words"].tolist()] == ["0-"] * 3

    for asked in (lambda: one.branch(orbit, free="omega", from_=0.5, to=2.0), lambda: one.sweep(["0-"], ("omega", 1.0, 2.0, 3)), lambda: one.fate(["0-"], ("omega", 1.0, 2.0, 3), starts=1)):
        with pytest.raises(vc.RequestError, match="omega changes nothing here"):
            asked()
    with pytest.raises(vc.RequestError, match="load changes nothing here"):
        one.branch(orbit, free="load", from_=0.5, to=2.0)
    with pytest.raises(vc.RequestError, match="is no number of a structure"):
        one.branch(orbit, from_=0.5, to=2.0)
    # A load has one.
    with pytest.raises(vc.RequestError, match="omega is missing"):
        both().orbits("0+")


def shaw_holmes():
    stop = vc.Contact(at=0, upper=0.1, restitution=0.8)
    return vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])


def test_branches_leave_where_they_double():
    one = shaw_holmes()
    first = one.branch(one.orbits("0+", omega=2.325)[0], 2.325, "omega", from_=2.3, to=2.55, generations=1)
    doubling, = [found["value"] for found in first.events if found["event"] == "period-doubling"]
    doubled, = [leaving for leaving in first.leaving if leaving.word == "0+,0+"]
    assert doubled.force_periods == 2 and doubled.origin == (0, pytest.approx(doubling, abs=1e-9))
    # There both impacts are those of the orbit that doubles.
    start = np.abs(doubled.values - doubling).argmin()
    one_of_two = np.interp(doubled.values[start], first.values, first.impulses[:, 0])
    assert doubled.impulses[start] == pytest.approx([one_of_two] * 2, abs=0.1)
    alone = one.branch(one.orbits("0+", omega=2.325)[0], 2.325, "omega", from_=2.3, to=2.55)
    assert alone.leaving == () and alone.origin is None and (alone.values == first.values).all()
    with pytest.raises(vc.RequestError, match="generations = -1"):
        one.branch(one.orbits("0+", omega=2.325)[0], 2.325, "omega", from_=2.3, to=2.55, generations=-1)


def test_runs_settle_on_stable_orbits_from_wherever():
    one, asked = shaw_holmes(), {"starts": 2, "periods": 400}
    rest = one.fate([], ("omega", 2.25, 2.4, 4), **asked)
    assert rest["words"].ravel().tolist() == ["0+ 2"] * 4 and rest.ends["periodic"] == 8
    near = one.fate(["0+"], ("omega", 2.25, 2.4, 4), ("load", 1.0, 1.1, 2), breathers="every", **asked)
    assert near.dims == ("load", "omega") and (near["share_breather"] == 1.0).all() and (near["solutions"] == 1).all()
    assert np.abs(near["measured_exponent"] - near["predicted_exponent"]).max() < 1e-6
    scene = vc.read_scene("scenes/structures/attractors.toml")
    scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 3, 2
    found = vc.fate(scene, breathers="rest", starts=1, periods=100, perturb=0.05)
    assert found["words"].shape == (2, 3) and sum(found.ends.values()) == 6
    with pytest.raises(vc.RequestError, match="from which orbits"):
        one.fate([], ("omega", 2.25, 2.4, 4), breathers="every")
    with pytest.raises(vc.RequestError, match="breathers rest is of structures"):
        vc.fate("scenes/fate-n20.toml", breathers="rest")


def test_shares_of_a_structures_map_are_one_table(mapgen, tmp_path):
    scene = both().scene(["0+", "0+,0-"], ("omega", 0.4, 1.4, 60), ("contact.0.upper", 0.3, 0.8, 50))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        table = vc.sweep_shares(scene, tmp_path / "map.csv", pool, shares=3, threads=1, mapgen=mapgen)
    rows = pathlib.Path(table).read_text().splitlines()
    assert len(rows) == 3001
    here = vc.sweep(scene)
    words = [word or "" for word in here["word"].ravel()]
    assert [row.split(",")[2] for row in rows[1:]] == here["class"].ravel().tolist()
    assert sum(words[i] != "" for i in range(3000)) == here.classes["stable"] + here.classes["unstable"] > 100
