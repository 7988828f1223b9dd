"""What becomes of a state, event by event."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vibrochain
from ._errors import RequestError
from ._pictures import STYLE, axes_for, colour, draw, drawing, titled
from ._vibrochain import Model, Orbit, _Pane

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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

# Periods at the end of the run of which a mass is shown.
_SHOWN = 8

# Impacts that are drawn at most, sites that have a colour, and more dots than this are small.
_DOTS, _COLOURS, _FEW = 20_000, 5, 400


class Run:
    """What a simulation leaves. Times, displacements and velocities are dimensionless.

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
    start : Orbit or Model
        What it began from.

    Examples
    --------
    >>> import vibrochain as vc
    >>> model = vc.Model(vc.Chain(1, 1.0, 0.0), omega=1.0, asymmetry=0.0, restitution=0.5)
    >>> run = vc.simulate(model, displacement=[0.0], velocity=[2.0], periods=0.25)
    >>> [str(kind) for kind in run.events["kind"]], round(float(run.events["time"][0]), 12)
    (['impact'], 0.523598775598)
    """

    def __init__(self, parts: dict[str, Any], start: Orbit | Model) -> None:
        self.start = start
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

    @drawing
    def plot(self, what: str | None = None, ax: Axes | None = None, *, mass: SupportsIndex | None = None) -> Axes:
        """Draws the run, as ``mapgen simulate --plot`` does: one mass at its end, all masses, or all impacts.

        Parameters
        ----------
        what : {"motion", "field", "impacts"}, optional
            A mass over the last eight periods of the force, over the orbit that the run began on, if it did; the displacements of all
            masses in space and time; how fast masses are before their impacts. Without it "motion", or of a run without samples
            "impacts".
        mass : int, optional
            Which one, counted through all layers; the first that hits if not given.
        {drawn}
        RequestError
            For another word, a mass that there is not, or a run that was not looked at (``samples=50`` in `simulate`).

        Examples
        --------
        >>> import vibrochain as vc
        >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
        >>> run = vc.simulate(model.breathers("double-sided").physical(), periods=20, samples=50)
        >>> run.plot().get_xlabel()  # doctest: +MATPLOTLIB
        'time in periods (end of the run)'
        """
        heading = f"{self._whose()}: {_vibrochain._caption([self._model()])}"
        if what == "field":
            return self._field(ax, heading)
        return draw(self._pane(what, mass), ax, heading)

    def _model(self) -> Model:
        return self.start.model if isinstance(self.start, Orbit) else self.start

    def _whose(self) -> str:
        if isinstance(self.start, Model):
            return "from a state"
        return f"{self.start.word if self.start.family == 'word' else self.start.family} breather"

    def _home(self, mass: SupportsIndex | None) -> int:
        """The mass that is asked for, or the first that hits."""
        model = self._model()
        masses = model.chain.masses
        if mass is None:
            first = self.events[:1]
            mass = int(first["layer"][0]) * (masses // model.chain.layers) + int(first["site"][0]) if len(first) else 0
        if not 0 <= operator.index(mass) < masses:
            raise RequestError(f"mass = {mass} is out of range: give a whole number from 0 to {masses - 1}")
        return operator.index(mass)

    def _sampled(self) -> None:
        if not len(self.times):
            raise RequestError("the run was not looked at: give samples=50 or times to simulate")

    def _pane(self, what: str | None, mass: SupportsIndex | None = None) -> _Pane:
        model = self._model()
        if what is None:
            what = "motion" if len(self.times) else "impacts"
        if what == "impacts":
            return self._impacts()
        if what != "motion":
            raise RequestError(f"what = {what!r} is unknown: give one of 'motion', 'field', 'impacts'")
        self._sampled()
        home = self._home(mass)
        late = self.times >= self.end - _SHOWN * model.period
        times = self.times[late]
        layer, site = divmod(home, model.chain.masses // model.chain.layers)
        # Between samples the tips of a trace, which are its impacts, would be cut off.
        hits = self.events[(self.events["site"] == site) & (self.events["layer"] == layer) & (self.events["time"] >= times[0])]
        walls = model.asymmetry + np.where(hits["barrier"] == "upper", 1.0, -1.0)
        every = np.concatenate([times, hits["time"]])
        order = np.argsort(every, kind="stable")
        simulated = np.column_stack([every / model.period, np.concatenate([self.displacement[late, home], walls])])[order]
        analytic = np.empty((0, 2))
        if isinstance(self.start, Orbit):
            fine = np.linspace(times[0], times[-1], 1200)
            analytic = np.column_stack([fine / model.period, self.start.displacement(fine, home)])
        y = f"displacement of mass {home}"
        levels = [model.asymmetry - 1, model.asymmetry + 1]
        as_pairs = lambda points: [(x, u) for x, u in points.tolist()]  # noqa: E731
        return _vibrochain._run_pane(y, as_pairs(simulated), as_pairs(analytic), levels)

    def _impacts(self) -> _Pane:
        hits = self.events[self.events["kind"] == "impact"]
        # Some for every pixel.
        hits = hits[:: max(1, len(hits) // _DOTS)]
        sites = list(dict.fromkeys(zip(hits["site"].tolist(), hits["layer"].tolist())))[:_COLOURS]
        series = []
        for number, (site, layer) in enumerate(sites):
            own = hits[(hits["site"] == site) & (hits["layer"] == layer)]
            name = "" if len(sites) == 1 else f"site {site}" + (f":{layer}" if self._model().chain.layers > 1 else "")
            mark = "dot" if len(own) > _FEW else "small"
            points = list(zip((own["time"] / self._model().period).tolist(), own["velocity_before"].tolist()))
            series.append((name, number, 0, mark, number, points))
        x, y = "time in periods (whole run)", "velocity before impacts"
        return _Pane("", x, y, series, x_range=(0.0, max(self.end / self._model().period, 1e-9)), levels=[0.0])

    def _field(self, ax: Axes | None, heading: str) -> Axes:
        from matplotlib.colors import ListedColormap

        self._sampled()
        model, ax = self._model(), axes_for(ax)
        # Rest is white, and what is as far from it as the farther barrier has full colour.
        most = 1 + abs(model.asymmetry)
        shades = ListedColormap([colour(rgb) for rgb in STYLE["diverging"]])
        times, masses, name = self.times / model.period, np.arange(model.chain.masses), "site"
        shown = self.displacement.T
        if model.chain.layers > 1:
            name = "site, layer upon layer"
        elif model.chain.ends == "closed":
            # What hits is in the middle of a ring.
            home, name = self._home(None), f"site, from site {self._home(None)}"
            masses = masses - (len(masses) - 1) // 2
            shown = shown[(masses + home) % len(masses)]
        mesh = ax.pcolormesh(times, masses, shown, cmap=shades, vmin=-most, vmax=most, shading="nearest")
        ax.figure.colorbar(mesh, ax=ax, label="displacement u")
        ax.set_xlabel("time in periods (whole run)")
        ax.set_ylabel(name)
        titled(ax, heading)
        return ax

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
    >>> run = vc.simulate(orbit, times=np.linspace(0.1, 9.9 * orbit.period, 50))
    >>> run.displacement.shape, run.impacts
    ((50, 21), 20)
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
    return Run(_vibrochain._simulate(model, time, (u, v), float(psi), periods, samples, times, max_impacts), start)
