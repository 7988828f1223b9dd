"""What becomes of a state, event by event."""

from __future__ import annotations

from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vibrochain
from ._errors import RequestError
from ._vibrochain import Model, Orbit

_EVENT = np.dtype(
    [
        ("time", "f8"),
        ("site", "i8"),
        ("layer", "i8"),
        ("barrier", "U5"),
        ("velocity_before", "f8"),
        ("velocity_after", "f8"),
        ("kind", "U7"),
    ]
)


class Run:
    """What a simulation leaves.

    Attributes
    ----------
    events : numpy.ndarray, structured
        One row a mass and event: time, site, layer, barrier ("lower", "upper"), velocity_before, velocity_after, kind ("impact",
        "stick", "release").
    times : numpy.ndarray of float64, shape (k,)
        When it was looked at.
    displacement, velocity : numpy.ndarray of float64, shape (k, masses)
        The state then; at an event, just after it.
    state : tuple of two numpy.ndarray, shape (masses,)
        Displacements and velocities at the end.
    end : float
        When it ended.
    complete : bool
        Whether it came to the end that was asked for, not to `max_impacts` before.
    impacts : int
        Number of impacts, one a mass.

    Examples
    --------
    >>> import vibrochain as vc
    >>> model = vc.Model(vc.Chain(1, 1.0, 0.0), omega=1.0, asymmetry=0.0, restitution=0.5)
    >>> run = vc.simulate(model, displacement=[0.0], velocity=[2.0], periods=0.25)
    >>> [str(kind) for kind in run.events["kind"]], round(float(run.events["time"][0]), 12)
    (['impact'], 0.523598775598)
    """

    def __init__(self, parts: dict[str, Any]) -> None:
        columns = parts["events"]
        self.events = np.empty(len(columns["time"]), dtype=_EVENT)
        for name, values in columns.items():
            if name == "kind":
                codes, words = values
                values = np.array(words)[codes]
            elif name == "barrier":
                values = np.where(values, "upper", "lower")
            self.events[name] = values
        self.times: NDArray[np.float64] = parts["times"]
        self.state: tuple[NDArray[np.float64], NDArray[np.float64]] = parts["last"]
        masses = len(self.state[0])
        self.displacement: NDArray[np.float64] = parts["displacement"].reshape(-1, masses)
        self.velocity: NDArray[np.float64] = parts["velocity"].reshape(-1, masses)
        self.end: float = parts["end"]
        self.complete: bool = parts["complete"]
        self.impacts: int = parts["impacts"]

    def __repr__(self) -> str:
        return f"<Run to t = {self.end}: {len(self.events)} events, {len(self.times)} samples>"


def simulate(
    start: Orbit | Model,
    *,
    displacement: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    psi: float = 0.0,
    perturbation: tuple[ArrayLike, ArrayLike] | None = None,
    periods: float | None = None,
    samples: SupportsIndex = 0,
    times: ArrayLike | None = None,
    max_impacts: SupportsIndex | None = None,
) -> Run:
    """Simulates a chain from an orbit or from any state, event by event, without any knowledge of orbits.

    Parameters
    ----------
    start : Orbit or Model
        The orbit to start on, in the flight before its impact at time 0, so that times agree with the orbit's; or the parameters
        of a run from a state at time 0.
    displacement, velocity : array_like of float, shape (masses,)
        The state, of a run from a Model.
    psi : float
        Phase of the force at time 0, as a time, of a run from a Model.
    perturbation : tuple of two array_like, optional
        What is added to displacements and velocities at the start, of a run from an Orbit.
    periods : float, optional
        Periods of the force to simulate; 20 if neither they nor `times` are given.
    samples : int
        How often a period to look at all masses; 0 is not at all.
    times : array_like of float, optional
        Instead of `periods` and `samples`: when to look, rising; the run ends with the last.
    max_impacts : int, optional
        Stop after so many impacts.

    Returns
    -------
    Run

    Raises
    ------
    RequestError
        For a state outside the gap, or a value out of range.
    NotConvergedError
        For a cascade of impacts that does not end.
    KeyboardInterrupt
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import numpy as np, vibrochain as vc
    >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
    >>> orbit = model.breathers("double-sided").physical()
    >>> run = vc.simulate(orbit, times=np.linspace(0.1, 10 * orbit.period, 50))
    >>> run.displacement.shape, run.impacts
    ((50, 21), 21)
    >>> bool(np.allclose(run.displacement, orbit.displacement(run.times), atol=1e-9))
    True
    """
    if isinstance(start, Orbit):
        if displacement is not None or velocity is not None or psi != 0.0:
            raise RequestError("displacement, velocity and psi are those of the orbit: give a Model to start from a state")
        model = start.model
        time, u, v, psi = _vibrochain._start(start)
        if perturbation is not None:
            du, dv = (_vibrochain._numbers("perturbation", change) for change in perturbation)
            u, v = u + np.broadcast_to(du, u.shape), v + np.broadcast_to(dv, v.shape)
    elif isinstance(start, Model):
        if displacement is None or velocity is None:
            raise RequestError("a run from a Model needs a state: give displacement and velocity, one number a mass in each")
        if perturbation is not None:
            raise RequestError("perturbation is of a run from an Orbit: add it to displacement and velocity")
        model, time = start, 0.0
        u = _vibrochain._numbers("displacement", displacement).reshape(-1)
        v = _vibrochain._numbers("velocity", velocity).reshape(-1)
    else:
        raise TypeError(f"start is {start!r}: give an Orbit or a Model")
    if times is not None:
        if periods is not None or samples:
            raise RequestError("times are given, and periods or samples as well: give either")
        times = _vibrochain._numbers("times", times).reshape(-1)
    return Run(_vibrochain._simulate(model, time, (u, v), float(psi), periods, samples, times, max_impacts))
