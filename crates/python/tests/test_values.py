"""Models and orbits as values: read back, compared, pickled, refused."""

import pickle

import numpy as np
import pytest

import vibrochain as vc

from conftest import ROOT
from models import random_models


def test_models_read_back_compare_and_pickle():
    seen = 0
    for model in random_models(100):
        again = eval(repr(model), vars(vc))
        assert again == model and hash(again) == hash(model) and repr(again) == repr(model)
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            assert pickle.loads(pickle.dumps(model, protocol)) == model
        assert pickle.loads(pickle.dumps(model.chain)) == model.chain
        assert pickle.loads(pickle.dumps(model.force)) == model.force
        assert model.replace(omega=model.omega * 2) != model
        assert model.replace(omega=model.omega) == model
        seen += 1
    assert seen == 100


def test_a_parameter_out_of_range_is_told_with_value_range_and_remedy():
    chain = vc.Chain(3, 1.0, 0.0)
    for make, told in [
        (lambda: vc.Chain(0, 1, 1), "sites = 0 is out of range: give a whole number from 1 to 10000000"),
        (lambda: vc.Chain(-(2**80), 1, 1), "is out of range: give a whole number from 1 to 10000000"),
        (lambda: vc.Chain(5, -0.5, 1), "gamma1 = -0.5 is out of range"),
        (lambda: vc.Chain(5, 0.5, float("nan")), "gamma2 = NaN is out of range"),
        (lambda: vc.Chain(5, 1, 1, ends="loose"), 'ends = "loose" is unknown: give one of "closed", "free", "fixed"'),
        (lambda: vc.Chain(5, 1, 1, layers=10**7), "layers = 10000000 is out of range: give a whole number from 1 to 2000000"),
        (lambda: vc.Model(chain, 0.0, 0.1), "omega = 0 is out of range"),
        (lambda: vc.Model(chain, 1.0, 1.0), "asymmetry = 1 is out of range"),
        (lambda: vc.Model(chain, 1.0, 0.1, restitution=0), "restitution = 0 is out of range"),
        (lambda: vc.Model(chain, 1.0, 0.1, amplitude=-1, restitution=1), "amplitude = -1 is out of range"),
        (lambda: vc.Model(chain, 1.0, 0.1, amplitude=1, force=vc.Force([(3, 1)]), restitution=1), "remove one of the two"),
        (lambda: vc.Model(chain, 1.0, 0.1).replace(gamma=1), 'parameter = "gamma" is unknown'),
        (lambda: vc.Force([(2, 0.1)]), "harmonic = 2 is out of range: give an odd number"),
        (lambda: vc.Force([(1,)]), "a harmonic has 1 parts"),
        (lambda: vc.Model(chain, 1.0, 0.1).breathers("both"), '"both" is no family and no impact word'),
        (lambda: vc.Model(chain, 1.0, 0.1).breathers("7+,7-"), "site 7 does not exist: this chain has the sites 0 to 2"),
    ]:
        with pytest.raises(vc.RequestError) as error:
            make()
        assert told in str(error.value)
        assert isinstance(error.value, ValueError) and isinstance(error.value, vc.VibrochainError)


@pytest.mark.parametrize(
    "make, told",
    [
        (lambda: vc.Chain("5", 1, 1), "sites = '5' is no whole number: give one from 1 to 10000000"),
        (lambda: vc.Chain(21.5, 1, 1), "sites = 21.5 is no whole number: give one from 1 to 10000000"),
        (lambda: vc.Chain(5, 1, 1, layers=2.0), "layers = 2.0 is no whole number"),
        (lambda: vc.Chain(5, "a", 1), "'gamma1'"),
        (lambda: vc.Force([(1.5, 0.1)]), "harmonic = 1.5 is no whole number"),
    ],
)
def test_what_is_no_number_is_a_type_error_that_names_the_argument(make, told):
    with pytest.raises(TypeError) as error:
        make()
    # From Python 3.11 on the name of the argument is a note.
    assert told in "\n".join([str(error.value), *getattr(error.value, "__notes__", [])])


def test_a_force_needs_restitution():
    """As the command line and scenes have it: e = 1 is a choice under a force, and none without."""
    chain = vc.Chain(21, 0.2, 0.1)
    free = vc.Model(chain, 1.5, 0.4)
    for make in [
        lambda: vc.Model(chain, 1.5, 0.4, amplitude=0.1),
        lambda: vc.Model(chain, 1.5, 0.4, amplitude=0.0),
        lambda: vc.Model(chain, 1.5, 0.4, force=vc.Force([(3, 0.1)])),
        lambda: free.replace(amplitude=0.1),
    ]:
        with pytest.raises(vc.RequestError, match="^restitution is missing: a force needs restitution$"):
            make()
    elastic = vc.Model(chain, 1.5, 0.4, amplitude=0.1, restitution=1)
    assert elastic.replace(amplitude=0.2).restitution == 1 and free.replace(amplitude=0.1, restitution=1) == elastic
    assert free.restitution == 1 and "restitution=1" in repr(elastic) and "restitution" not in repr(free)
    lossy = vc.Model(chain, 1.5, 0.4, restitution=0.9)
    assert lossy.replace(amplitude=0.1).restitution == 0.9


def test_the_version_is_that_of_the_project():
    manifest = (ROOT / "Cargo.toml").read_text()
    assert f'[workspace.package]\nversion = "{vc.__version__}"\n' in manifest


def test_a_resonance_is_an_error_of_its_own():
    model = vc.Model(vc.Chain(21, 0.25, 0.1), omega=0.5, asymmetry=0.4)
    with pytest.raises(vc.ResonanceError) as error:
        model.breathers("double-sided")
    assert (error.value.harmonic, error.value.mode) == (1, 0) and error.value.frequency == 0.5
    assert "move omega or a stiffness off it" in str(error.value)
    assert str(pickle.loads(pickle.dumps(error.value))) == str(error.value)


def test_no_breather_is_an_answer_until_one_is_needed():
    found = vc.Model(vc.Chain(5, 0.2, 0.1), omega=1.5, asymmetry=0.4, restitution=0.9).breathers("double-sided")
    assert len(found) == 0 and found.completeness.established and "give an amplitude" in found.reason
    with pytest.raises(vc.NoBreatherError, match="give an amplitude"):
        found.physical()


def test_other_failures_have_their_kinds(model, orbit):
    with pytest.raises(vc.NotConvergedError, match="start nearer to an orbit"):
        vc.Orbit.near(model, [(0, "upper", 0.0, 50.0), (7, "upper", 0.3, 50.0), (0, "lower", 0.4, 0.0)])
    with pytest.raises(vc.TooLargeError, match="give fewer times or sites"):
        orbit.displacement(np.broadcast_to(0.0, 10**9))
    with pytest.raises(vc.TooLargeError, match="is too stiff|too stiff"):
        stiff = vc.Model(vc.Chain(2, 1.0, 1e6), omega=1.234567e-7, asymmetry=0.4)
        stiff.breathers("single-sided").orbits[0].admissibility()


def test_orbits_near_their_own_impacts_are_themselves(orbit):
    hits = [(impact.mass, impact.barrier, impact.time, impact.impulse) for impact in orbit.impacts]
    again = vc.Orbit.near(orbit.model, hits, psi=orbit.psi)
    assert again.word == "0+,0-" and again.residual < 1e-14
    assert np.allclose([i.impulse for i in again.impacts], [i.impulse for i in orbit.impacts], rtol=0, atol=1e-13)


def test_motion_is_of_the_shape_asked_for(orbit):
    times = np.linspace(0, orbit.period, 30).reshape(5, 6)
    everything = orbit.displacement(times)
    assert everything.shape == (5, 6, 21) and everything.dtype == np.float64
    assert orbit.displacement(times, 3).shape == (5, 6)
    assert orbit.displacement(0.5).shape == (21,) and orbit.displacement(0.5, 3).shape == ()
    assert orbit.displacement([], [1]).shape == (0, 1)
    some = orbit.velocity(times, np.array([20, 0, 20]))
    assert np.allclose(some, orbit.velocity(times)[..., [20, 0, 20]], rtol=0, atol=1e-14)
    # Times of another type, in another order of memory.
    assert np.array_equal(orbit.displacement(np.arange(4)), orbit.displacement([0.0, 1.0, 2.0, 3.0]))
    assert np.array_equal(orbit.displacement(times.T), np.swapaxes(everything, 0, 1))
    for sites in [21, -1, [0, 21], 2**70]:
        with pytest.raises(vc.RequestError, match="give a whole number from 0 to 20"):
            orbit.displacement(times, sites)
    with pytest.raises(vc.RequestError, match="give finite times"):
        orbit.displacement([0.0, float("inf")])


def test_velocity_is_the_rate_of_displacement_and_barriers_hold(orbit):
    impacts = [impact.time for impact in orbit.impacts]
    times = np.array([t for t in np.linspace(0, orbit.period, 97)[:-1] if min(abs(t - i) for i in impacts) > 1e-3])
    step = 1e-6
    rate = (orbit.displacement(times + step) - orbit.displacement(times - step)) / (2 * step)
    assert np.abs(rate - orbit.velocity(times)).max() < 1e-8
    for impact in orbit.impacts:
        wall = orbit.model.asymmetry + (1 if impact.barrier == "upper" else -1)
        assert abs(orbit.displacement(impact.time, impact.mass) - wall) < 1e-13


def test_a_large_ring_moves_by_transforms_as_mass_by_mass():
    orbit = vc.Model(vc.Chain(3001, 0.2, 0.1), omega=1.5, asymmetry=0.4).breathers("double-sided").orbits[0]
    times = [0.0, 0.7, 2.1]
    sites = [0, 1, 1500, 3000]
    for method in [orbit.displacement, orbit.velocity]:
        assert np.abs(method(times)[:, sites] - method(times, sites)).max() < 1e-12


def test_multipliers_are_of_the_whole_chain(orbit):
    answer = orbit.stability()
    assert answer.multipliers.dtype == np.complex128 and answer.multipliers.shape == (42,)
    assert np.all(np.diff(np.abs(answer.multipliers)) < 1e-12)
    assert not answer.stable and answer.mechanism == "neimark-sacker" and answer.verdict == answer.verdict
    assert orbit.stability(threshold=0.01).stable
    with pytest.raises(vc.RequestError, match="threshold = -1 is out of range"):
        orbit.stability(threshold=-1)


def test_two_impacts_on_one_barrier_take_as_many_periods_as_are_asked_for():
    forced = vc.Model(vc.Chain(1, 1.0, 0.0), 0.7, 0.95, amplitude=0.1, restitution=0.8)
    one = forced.breathers("0-,0-", force_periods=1)
    assert one.completeness.established and {orbit.force_periods for orbit in one.orbits} == {1}
    assert any(abs(orbit.impacts[1].time - 2.43423366690096) < 1e-12 for orbit in one.orbits)
    assert {orbit.force_periods for orbit in forced.breathers("0-,0-").orbits} == {2}
    free = vc.Model(vc.Chain(5, 0.4, 0.42), 0.343, 0.2)
    assert free.breathers("0-,0-").orbits[0].force_periods == 1
    with pytest.raises(vc.RequestError, match="omega/N"):
        free.breathers("0-,0-", force_periods=2)


def test_a_run_calls_masses_of_layers_as_words_do_and_begins_its_clock_at_the_first_impact():
    model = vc.Model(vc.Chain(3, 0.2, 0.1, layers=2, gamma3=0.05), omega=1.5, asymmetry=0.2)
    with pytest.raises(vc.RequestError, match="^site 1:1 starts at 3, "):
        vc.simulate(model, displacement=[0, 0, 0, 0, 3, 0], velocity=[0] * 6)
    with pytest.raises(vc.RequestError, match="^velocity of site 2:0 is NaN"):
        vc.simulate(model, displacement=[0] * 6, velocity=[0, 0, float("nan"), 0, 0, 0])
    starts = 0
    for omega in [1.3, 1.5, 1.7, 1.9]:
        orbit = model.replace(omega=omega).breathers("double-sided").physical()
        time = vc.simulate(orbit, periods=1).events["time"][0]
        assert time == 0.0
        starts += 1
    assert starts == 4
