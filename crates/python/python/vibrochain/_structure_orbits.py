"""What is found of a structure: orbits, branches of them as a number varies, and curves of events over two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _vibrochain
from ._pictures import curve_pane, curves_there, draw, drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._vibrochain import Completeness


@dataclass(frozen=True, repr=False)
class StructureOrbit:
    """A periodic orbit of a structure, with all that is said of it. Times, places and impulses are in the structure's units.

    Attributes
    ----------
    word : str
        Contacts and barriers in their order, "0+,1-".
    period : float
        Its period.
    period_error : float or None
        A bound of its error, of an orbit whose period is its own: that of others is a load's.
    psi : float or None
        The load's phase at the first impact, as a time.
    impacts : list of dict
        contact, barrier, time, impulse, velocity_before, velocity_after, acceleration_before, and errors.
    physical : bool
        Whether every contact stays inside its barriers.
    margin : float or None
        The smallest distance of a contact to a barrier at a turning point.
    obstruction : dict or None
        What is in the way.
    stability : dict or None
        stable, undecided, mechanism, spectral_radius, excess, resolution.
    multipliers : numpy.ndarray of complex128
        All Floquet multipliers, the largest first.

    Examples
    --------
    >>> import vibrochain as vc
    >>> beam = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[vc.Contact(at=0, upper=0.1, restitution=0.8)], load=[1.0])
    >>> [(orbit.physical, round(orbit.stability["spectral_radius"], 12)) for orbit in beam.orbits("0+", omega=2.325)]
    [(True, 0.698887274904), (False, 0.698887274904)]

    Examples of its methods go on from here:

    >>> orbit = beam.orbits("0+", omega=2.325)[0]
    """

    word: str
    period: float
    period_error: float | None
    psi: float | None
    impacts: list[dict[str, Any]]
    physical: bool
    margin: float | None
    obstruction: dict[str, Any] | None
    stability: dict[str, Any] | None
    residual: float
    multipliers: NDArray[np.complex128] = field(compare=False)
    # What it is an orbit of, as JSON, and the frequency there.
    _scene: str = field(compare=False, default="")
    _omega: float = field(compare=False, default=0.0)

    @classmethod
    def _of(cls, parts: dict[str, Any], scene: str, omega: float) -> StructureOrbit:
        stability = parts["stability"]
        pairs = [] if stability is None else stability.pop("multipliers")
        multipliers = np.array([complex(re, im) for re, im in pairs], dtype=np.complex128)
        kept = ("word", "period", "psi", "impacts", "physical", "margin", "obstruction", "residual")
        known = {key: parts[key] for key in kept}
        period_error = parts.get("period_error")
        return cls(**known, period_error=period_error, stability=stability, multipliers=multipliers, _scene=scene, _omega=omega)

    def __repr__(self) -> str:
        hits = ", ".join(str(hit["impulse"]) for hit in self.impacts)
        told, verdict = "physical" if self.physical else "not physical", self.stability
        if verdict is not None:
            state = "undecided" if verdict["undecided"] else "stable" if verdict["stable"] else f"unstable ({verdict['mechanism']})"
            told += f", {state}, spectral radius {verdict['spectral_radius']}"
        return f"<StructureOrbit {self.word}: period {self.period}, impulses {hits}; {told}>"

    def _frequency(self, omega: float | None) -> float:
        """That of a load, as given or as the orbit has it; of an orbit whose period is its own the orbit's."""
        return self._omega if omega is None or self.period_error is not None else float(omega)

    def _start(self, omega: float) -> tuple[list[tuple[int, str, float, float]], float, int]:
        """Its impacts, its phase and the periods of a load of this frequency that it lasts: where to begin from it."""
        near = [(hit["contact"], hit["barrier"], hit["time"], hit["impulse"]) for hit in self.impacts]
        return near, self.psi or 0.0, max(1, round(self.period * omega / (2 * np.pi)))

    def motion(self, t: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places and velocities of all contacts at given times.

        Parameters
        ----------
        t : array_like of float
            Times, of any shape; the motion repeats with the period.

        Returns
        -------
        place, velocity : numpy.ndarray of float64
            Of the shape of `t`, followed by the number of contacts; at an impact the velocity just after it.

        Examples
        --------
        >>> place, velocity = orbit.motion([0.0, 1.0])
        >>> place.shape, round(float(place[0, 0]), 12)
        ((2, 1), 0.1)
        >>> bool(abs(velocity[0, 0] - orbit.impacts[0]["velocity_after"]) < 1e-12)
        True
        """
        times = _vibrochain._numbers("t", t)
        near, psi, periods = self._start(self._omega)
        values = _vibrochain._structure_motion(self._scene, near, psi, periods, times.ravel().tolist())
        values = values.reshape(*times.shape, -1, 2)
        return values[..., 0], values[..., 1]

    def _pane(self, what: str) -> tuple[_vibrochain._Pane, str]:
        near, psi, periods = self._start(self._omega)
        return _vibrochain._structure_pane(self._scene, near, psi, periods, what)

    @drawing
    def plot(self, what: str = "motion", ax: Axes | None = None) -> Axes:
        """Draws the orbit, as ``mapgen orbit --plot`` does.

        Parameters
        ----------
        what : {"motion", "portrait", "multipliers"}
            The contacts that are hit over a period, between their barriers; the phase portrait of the first, impacts as jumps; the
            Floquet multipliers. Of contacts between different barriers the first are drawn.
        {drawn}
        RequestError
            For another word.

        Examples
        --------
        >>> orbit.plot().get_ylabel()  # doctest: +MATPLOTLIB
        'g of contact 0'
        """
        pane, heading = self._pane(what)
        return draw(pane, ax, heading)


@dataclass(frozen=True, repr=False)
class StructureOrbits:
    """Orbits of a word, a sequence, with what is known of the list.

    Attributes
    ----------
    orbits : tuple of StructureOrbit
        The orbits, physical or not.
    completeness : Completeness
        Whether these are all, and how that is known.
    periods : tuple (float, float) or None
        The least and the largest period that was searched, where orbits have periods of their own: of others nothing is known.

    Examples
    --------
    >>> import vibrochain as vc
    >>> stop = vc.Contact(at=0, lower=-0.5, upper=0.5, restitution=0.8)
    >>> one = vc.Structure([1.0], [1.0], damping=[0.05], contacts=[stop], load=[1.0])
    >>> one.orbits("0+,0-", omega=1.5).completeness.by
    'enclosures'
    """

    orbits: tuple[StructureOrbit, ...]
    completeness: Completeness
    periods: tuple[float, float] | None = None

    def __repr__(self) -> str:
        physical = sum(orbit.physical for orbit in self.orbits)
        return f"<{len(self)} orbit{'' if len(self) == 1 else 's'}, {physical} physical, {self.completeness}>"

    def __len__(self) -> int:
        return len(self.orbits)

    def __getitem__(self, place: int) -> StructureOrbit:
        return self.orbits[place]

    def __iter__(self) -> Iterator[StructureOrbit]:
        return iter(self.orbits)


@dataclass(frozen=True, eq=False, repr=False)
class StructureBranch:
    """An orbit of a structure as one of its numbers varies, in the order of the way, through folds.

    Attributes
    ----------
    free : str
        The number that varies.
    values : numpy.ndarray of float64, shape (points,)
        Its values.
    impulses : numpy.ndarray of float64, shape (points, impacts)
        Of each impact.
    period, margin, spectral_radius : numpy.ndarray of float64, shape (points,)
        The orbit's period, the smallest distance of a contact to a barrier, the largest modulus of a multiplier; nan where not known.
    physical, stable : numpy.ndarray of bool, shape (points,)
        False also where it is not known.
    events : list of dict
        event, value, error, evidence, physical, period, psi, times, impulses, sides; branching, where it is known how orbits branch off:
        value, side, orbits, these with period, psi, times, impulses, physical, stability.
    ends : list of tuple (float, str)
        Where and how it ends at the first and behind the last point.
    unresolved : list of tuple (float, float)
        Ranges in which there is a sign of more events that rounding hides.
    word : str
        That of its first orbit.
    force_periods : int
        Periods of the load in one of it.
    leaving : tuple of StructureBranch
        The branches that leave it, and those that leave these, as far as they were asked for.
    origin : tuple (int, float) or None
        Which branch it leaves, 0 the first and then by their places in `leaving`, and where.

    Examples
    --------
    >>> import vibrochain as vc
    >>> stop = vc.Contact(at=0, upper=0.1, restitution=0.8)
    >>> one = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])
    >>> branch = one.branch(one.orbits("0+", omega=2.325)[0], omega=2.325, free="omega", from_=2.3, to=2.6)
    >>> [(found["event"], round(found["value"], 9)) for found in branch.events]
    [('period-doubling', 2.456715356)]
    >>> len(branch.events[0]["branching"]["orbits"][0]["impulses"])
    2

    Examples of its methods go on from here.
    """

    free: str
    values: NDArray[np.float64]
    impulses: NDArray[np.float64]
    period: NDArray[np.float64]
    margin: NDArray[np.float64]
    spectral_radius: NDArray[np.float64]
    physical: NDArray[np.bool_]
    stable: NDArray[np.bool_]
    events: list[dict[str, Any]]
    ends: list[tuple[float, str]]
    unresolved: list[tuple[float, float]] = field(default_factory=list)
    word: str = ""
    force_periods: int = 1
    leaving: tuple[StructureBranch, ...] = ()
    origin: tuple[int, float] | None = None
    # How many points lie before each event; how many branches lie before it; what stands at the axis and above the picture.
    _places: list[int] = field(default_factory=list)
    _generation: int = 0
    _told: tuple[str, str] = field(default=("", ""))

    @classmethod
    def _all(cls, free: str, answer: dict[str, Any]) -> StructureBranch:
        """The first branch with all that leave it."""
        told = answer["labels"][0], answer["heading"]
        first, *others = answer["branches"]
        return cls._of(free, first, told, tuple(cls._of(free, parts, told, ()) for parts in others))

    @classmethod
    def _of(cls, free: str, parts: dict[str, Any], told: tuple[str, str], leaving: tuple[StructureBranch, ...]) -> StructureBranch:
        points = parts["points"]
        numbers = lambda values: np.array([np.nan if one is None else one for one in values], dtype=np.float64)  # noqa: E731
        stability = [point["stability"] or {} for point in points]
        return cls(
            free=free,
            values=numbers(point["value"] for point in points),
            impulses=np.array([point["impulses"] for point in points], dtype=np.float64),
            period=numbers(point["period"] for point in points),
            margin=numbers(point["margin"] for point in points),
            spectral_radius=numbers(one.get("spectral_radius") for one in stability),
            physical=np.array([point["physical"] is True for point in points]),
            stable=np.array([one.get("stable") is True and not one.get("undecided") for one in stability]),
            events=parts["events"],
            ends=[(value, name) for value, name in parts["ends"]],
            unresolved=[(low, high) for low, high in parts["unresolved"]],
            word=parts["word"],
            force_periods=parts["force_periods"],
            leaving=leaving,
            origin=None if parts["origin"] is None else (parts["origin"][0], parts["origin"][1]),
            _places=parts["places"],
            _generation=parts["generation"],
            _told=told,
        )

    def __repr__(self) -> str:
        hidden = f", in {len(self.unresolved)} ranges a sign of more" if self.unresolved else ""
        return f"<StructureBranch of {self.word} in {self.free}: {len(self.values)} points, {len(self.events)} events{hidden}>"

    def _rows(self) -> tuple[str, int, int, list[Any]]:
        known = lambda value: None if np.isnan(value) else float(value)  # noqa: E731
        rows: list[tuple[Any, ...]] = [
            (None, value, hits, None, None, period, known(margin), physical, stable, known(radius))
            for value, hits, period, margin, physical, stable, radius in zip(
                self.values.tolist(),
                self.impulses.tolist(),
                self.period.tolist(),
                self.margin,
                self.physical.tolist(),
                self.stable.tolist(),
                self.spectral_radius,
            )
        ]
        for shift, (event, place) in enumerate(zip(self.events, self._places)):
            row = (event["event"], event["value"], event["impulses"], None, event["psi"], event["period"], None)
            rows.insert(place + shift, (*row, event["physical"], None, None))
        return self.word, self._generation, self.force_periods, rows

    def _pane(self, show: str, all: bool) -> tuple[_vibrochain._Pane, str]:
        label, heading = self._told
        return _vibrochain._branch_pane(label, [branch._rows() for branch in (self, *self.leaving)], show, all), heading

    @drawing
    def plot(self, show: str = "impulse", ax: Axes | None = None, *, all: bool = False) -> Axes:
        """Draws the branch, and those that leave it, over what varies, as ``mapgen branch --plot`` does: stable orbits solid, unstable
        dashed, events marked.

        Parameters
        ----------
        show : {"impulse", "margin", "spectral_radius"}
            What stands along the vertical axis; impulses have a line each.
        {all}
        {drawn}
        RequestError
            For another word.

        Examples
        --------
        >>> branch.plot("spectral_radius").get_xlabel()  # doctest: +MATPLOTLIB
        'frequency ω'
        """
        pane, heading = self._pane(show, all)
        return draw(pane, ax, heading)


@dataclass(frozen=True, eq=False, repr=False)
class StructureCurve:
    """An event of a structure's orbits over two of its numbers.

    Attributes
    ----------
    event : str
        Which.
    free : tuple of two str
        The numbers that vary.
    values : numpy.ndarray of float64, shape (points, 2)
        Their values, in the order of the way.
    error : numpy.ndarray of float64, shape (points,)
        How far the curve may pass, as a part of the window's sides.
    physical : numpy.ndarray of bool, shape (points,)
        Whether the orbit there is.
    special : list of dict
        special, point, values, error: what else happens on the way.
    ends : list of str
        How it ends before the first and behind the last point.
    touch : str
        Of a curve of grazing, which contact touches which barrier; empty of other events.

    Examples
    --------
    >>> import vibrochain as vc
    >>> stop = vc.Contact(at=0, upper=0.1, restitution=0.8)
    >>> one = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])
    >>> doubling, = one.curves(one.orbits("0+", omega=2.325)[0], omega=2.325, event="period-doubling", free=("omega", "contact.0.upper"),
    ...                        from_=(2.3, 0.05), to=(2.6, 0.15))
    >>> doubling.event, bool(doubling.error.max() < 1e-9)
    ('period-doubling', True)

    Examples of its methods go on from here.
    """

    event: str
    free: tuple[str, str]
    values: NDArray[np.float64]
    error: NDArray[np.float64]
    physical: NDArray[np.bool_]
    special: list[dict[str, Any]]
    ends: list[str]
    touch: str = ""
    # What stands at the axes and above the picture.
    _told: tuple[tuple[str, str], str] = field(default=(("", ""), ""))

    @classmethod
    def _of(cls, free: tuple[str, str], parts: dict[str, Any], touch: str, labels: list[str], heading: str) -> StructureCurve:
        points = parts["points"]
        return cls(
            event=parts["event"],
            free=free,
            values=np.array([point["values"] for point in points], dtype=np.float64).reshape(-1, 2),
            error=np.array([np.nan if point["error"] is None else point["error"] for point in points], dtype=np.float64),
            physical=np.array([point["physical"] is True for point in points]),
            special=parts["special"],
            ends=parts["ends"],
            touch=touch,
            _told=((labels[0], labels[1]), f"{_vibrochain._in_words(parts['event'])}, {heading}"),
        )

    def __repr__(self) -> str:
        return f"<StructureCurve of {self.event} in {' and '.join(self.free)}: {len(self.values)} points>"

    @drawing
    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the curve in the plane of its two numbers, as ``mapgen curve --plot`` does.

        {curve}
        {drawn}

        Examples
        --------
        >>> doubling.plot().get_ylabel()  # doctest: +MATPLOTLIB
        'upper barrier of contact 0'
        """
        labels, heading = self._told
        special = [(one["special"], one["point"]) for one in self.special]
        return draw(curve_pane(self.values, self.physical, special, labels, curves_there(ax), self.touch), ax, heading)
