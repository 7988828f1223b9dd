"""Any linear structure with stops: M q'' + C q' + K q = s + f cos w(t + psi), contacts between barriers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from . import _vibrochain
from ._errors import RequestError
from ._fate import Fates, fate
from ._map import Map, sweep
from ._pictures import sharing
from ._structure_orbits import StructureBranch, StructureCurve, StructureOrbit, StructureOrbits


def _dense(name: str, matrix: Any) -> list[list[float]]:
    """A matrix as rows of numbers; of scipy.sparse, too."""
    whole = _vibrochain._numbers(name, matrix.toarray() if hasattr(matrix, "toarray") else matrix)
    if whole.ndim == 1:
        whole = np.diag(whole)
    if whole.ndim != 2 or whole.shape[0] != whole.shape[1]:
        raise RequestError(f"{name} of shape {whole.shape} is not square: give (n, n), or (n,) for a diagonal")
    rows: list[list[float]] = whole.tolist()
    return rows


def _row(name: str, values: Any) -> list[float]:
    """Numbers in a row; one number is a row of one."""
    row: list[float] = np.atleast_1d(_vibrochain._numbers(name, values)).tolist()
    return row


def _scenes(contacts: Any) -> list[dict[str, Any]]:
    """Contacts as scenes have them."""
    if isinstance(contacts, Contact):
        raise RequestError("contacts is one Contact: give a list, contacts=[Contact(...)]")
    scenes = []
    for number, contact in enumerate(contacts):
        if not isinstance(contact, Contact):
            raise RequestError(f"contacts[{number}] is of type {type(contact).__name__}: give vibrochain.Contact(...)")
        scenes.append(contact._scene())
    return scenes


@dataclass(frozen=True)
class Contact:
    """Where a coordinate, or a combination of some, is stopped.

    Parameters
    ----------
    at : int, optional
        The coordinate.
    between : tuple of two int, optional
        Instead, the difference of two coordinates, the first less the second.
    weights : sequence of float, shape (n,), optional
        Instead, w of g = w . q.
    lower, upper : float, optional
        The barriers, in the units of the coordinates; None: no stop there.
    restitution : float
        e, from 0 to 1.

    Raises
    ------
    RequestError
        For what is no coordinate, no pair of them or no number.

    Examples
    --------
    >>> import vibrochain as vc
    >>> vc.Contact(at=1, upper=0.3, restitution=0.7)
    Contact(at=1, between=None, weights=None, lower=None, upper=0.3, restitution=0.7)
    """

    at: int | None = None
    between: tuple[int, int] | None = None
    weights: tuple[float, ...] | None = None
    lower: float | None = None
    upper: float | None = None
    restitution: float = 1.0

    def __post_init__(self) -> None:
        if self.at is not None and not isinstance(self.at, SupportsIndex):
            raise RequestError(f"at = {self.at} is no coordinate: give its number, from 0")
        if self.between is not None:
            pair = self.between if isinstance(self.between, (list, tuple, np.ndarray)) else ()
            if len(pair) != 2 or not all(isinstance(place, SupportsIndex) for place in pair):
                raise RequestError(
                    f"between = {self.between} is no pair of coordinates: give two, between=(0, 1); barriers are given by their names, lower= and upper="
                )
        if self.weights is not None:
            object.__setattr__(self, "weights", tuple(_row("weights", self.weights)))
        for name in ("lower", "upper", "restitution"):
            value = getattr(self, name)
            if value is None and name != "restitution":
                continue
            try:
                float(value)
            except (TypeError, ValueError, OverflowError):
                raise RequestError(f"{name} = {value!r} is no number") from None

    def _scene(self) -> dict[str, Any]:
        parts: dict[str, Any] = {
            "lower": None if self.lower is None else float(self.lower),
            "upper": None if self.upper is None else float(self.upper),
            "restitution": float(self.restitution),
        }
        if self.weights is not None:
            parts["weights"] = list(self.weights)
        if self.between is not None:
            parts["between"] = [int(place) for place in self.between]
        if self.at is not None:
            parts["at"] = int(self.at)
        return {key: value for key, value in parts.items() if value is not None}


class Structure:
    """A linear structure with stops, from its matrices.

    Parameters
    ----------
    mass, stiffness : array_like, shape (n, n) or (n,), or scipy.sparse matrix
        M and K, symmetric; of shape (n,) the diagonal. Units are yours.
    damping : array_like, the same, optional
        C, which need not be a combination of M and K.
    contacts : sequence of Contact
        Where it is stopped.
    load : array_like, shape (n,), optional
        f of f cos w(t + psi); complex for a phase of each coordinate.
    static_load : array_like, shape (n,), optional
        s.
    harmonic : int
        The load's harmonic.
    modes : int, optional
        Keep so many modes, the slowest, and leave out what the others do; all of them if not given. Of light ends of beams the impacts feel more
        mass then.

    Examples
    --------
    >>> import numpy as np
    >>> import vibrochain as vc
    >>> stop = vc.Contact(at=1, lower=-0.7, upper=0.6, restitution=0.8)
    >>> both = vc.Structure([1.0, 1.4], np.array([[1.0, -0.3], [-0.3, 0.8]]), damping=[0.02, 0.02], contacts=[stop], load=[0.5, 0.0])
    >>> [orbit.physical for orbit in both.orbits("0+", omega=0.6)]
    [False, True]

    Examples of its methods go on from here:

    >>> one = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[vc.Contact(at=0, upper=0.1, restitution=0.8)], load=[1.0])
    >>> first, _ = one.orbits("0+", omega=2.325)
    """

    def __init__(
        self,
        mass: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike | None = None,
        *,
        contacts: list[Contact] | tuple[Contact, ...],
        load: ArrayLike | None = None,
        static_load: ArrayLike | None = None,
        harmonic: int = 1,
        modes: SupportsIndex | None = None,
    ) -> None:
        self._structure: dict[str, Any] = {"mass": _dense("mass", mass), "stiffness": _dense("stiffness", stiffness)}
        if modes is not None:
            self._structure["modes"] = modes.__index__()
        if damping is not None:
            self._structure["damping"] = _dense("damping", damping)
        self._contacts = _scenes(contacts)
        self._force: dict[str, Any] = {}
        if load is not None:
            amplitude = np.atleast_1d(_vibrochain._numbers("load", load, "complex128"))
            self._force = {"load": np.abs(amplitude).tolist(), "phases": np.angle(amplitude).tolist(), "harmonic": int(harmonic)}
        if static_load is not None:
            self._force["static"] = _row("static_load", static_load)

    @classmethod
    def modal(
        cls,
        frequencies: ArrayLike,
        ratios: ArrayLike,
        contact_shapes: ArrayLike,
        *,
        contacts: list[Contact] | tuple[Contact, ...],
        load_shapes: ArrayLike | None = None,
        static_shapes: ArrayLike | None = None,
        harmonic: int = 1,
    ) -> Structure:
        """A structure by its modes.

        Parameters
        ----------
        frequencies, ratios : array_like, shape (k,)
            Frequencies and damping ratios.
        contact_shapes : array_like, shape (contacts, k)
            What each contact sees of each mode, shapes with mass 1.
        contacts : sequence of Contact
            Barriers and restitutions alone.
        load_shapes, static_shapes : array_like, shape (k,), optional
            What the load that changes, and the static one, are on each mode.
        harmonic : int
            The load's harmonic.

        Returns
        -------
        Structure

        Raises
        ------
        RequestError
            At the first question, for shapes of other lengths.

        Examples
        --------
        >>> import vibrochain as vc
        >>> tip = vc.Contact(upper=0.1, restitution=0.8)
        >>> one = vc.Structure.modal([1.0], [0.05], [[1.0]], contacts=[tip], load_shapes=[1.0])
        >>> len(one.orbits("0+", omega=2.325))
        2
        """
        whole = cls.__new__(cls)
        whole._structure = {
            "frequencies": _row("frequencies", frequencies),
            "ratios": _row("ratios", ratios),
            "contact_shapes": np.atleast_2d(_vibrochain._numbers("contact_shapes", contact_shapes)).tolist(),
        }
        if load_shapes is not None:
            whole._structure["load_shapes"] = _row("load_shapes", load_shapes)
        if static_shapes is not None:
            whole._structure["static_shapes"] = _row("static_shapes", static_shapes)
        whole._contacts = _scenes(contacts)
        whole._force = {"harmonic": int(harmonic)}
        return whole

    def _scene(self, omega: float | None) -> str:
        parts: dict[str, Any] = {"structure": self._structure, "contact": self._contacts, "force": self._force}
        if omega is not None:
            parts["omega"] = float(omega)
        return json.dumps(parts)

    def _answer(
        self, omega: float | None, word: str | None, force_periods: int, threshold: float, near: list[Any], psi: float
    ) -> StructureOrbits:
        text, completeness = _vibrochain._structure(self._scene(omega), word, force_periods, threshold, near, psi)
        answer = json.loads(text)
        # A period of its own is where Newton's method begins again.
        own = [2 * np.pi / parts["period"] if "period_error" in parts else float(omega or 0.0) for parts in answer["solutions"]]
        orbits = tuple(StructureOrbit._of(parts, self._scene(at), at) for parts, at in zip(answer["solutions"], own))
        periods = answer["periods"]
        return StructureOrbits(orbits, completeness, periods if periods is None else tuple(periods))

    def orbits(self, word: str, omega: float | None = None, *, force_periods: int = 1, threshold: float = 0.0) -> StructureOrbits:
        """Orbits of a word: of one impact all, of two all where `completeness` says so, of more what starts lead to.

        Parameters
        ----------
        word : str
            Contacts and barriers in their order, as in "0+" or "0-,1+".
        omega : float, optional
            Frequency of the load, above 0; nothing has it where no load acts and dashpots feed the motion, whose period is its own.
        force_periods : int
            Periods of the load in one of the word.
        threshold : float
            Excess a period from which on an orbit counts as unstable.

        Returns
        -------
        StructureOrbits
            The orbits, physical or not, and how they were sought.

        Raises
        ------
        RequestError
            For a structure that is none, or a contact that it does not have.

        Examples
        --------
        >>> import vibrochain as vc
        >>> stop = vc.Contact(at=0, lower=-0.5, upper=0.5, restitution=0.8)
        >>> one = vc.Structure([1.0], [1.0], damping=[0.05], contacts=[stop], load=[1.0])
        >>> sum(orbit.physical for orbit in one.orbits("0+,0-", omega=1.5))
        3
        """
        return self._answer(omega, word, force_periods, threshold, [], 0.0)

    def near(self, orbit: StructureOrbit, omega: float | None = None, *, threshold: float = 0.0) -> StructureOrbit:
        """The orbit next to one of a neighbouring structure or frequency, by Newton's method.

        Parameters
        ----------
        orbit : StructureOrbit
            Where to begin.
        omega : float, optional
            Frequency of the load; if not given that of the orbit.
        threshold : float
            Excess a period from which on an orbit counts as unstable.

        Returns
        -------
        StructureOrbit

        Raises
        ------
        NotConvergedError
            Where no orbit is near enough.

        Examples
        --------
        >>> round(first.impacts[0]["impulse"], 9), round(one.near(first, omega=2.33).impacts[0]["impulse"], 9)
        (-1.097937536, -1.074207568)
        """
        omega = orbit._frequency(omega)
        near, psi, periods = orbit._start(omega)
        return self._answer(omega, None, periods, threshold, near, psi)[0]

    def _along(
        self,
        orbit: StructureOrbit,
        omega: float | None,
        free: list[str],
        ends: tuple[list[float], list[float]],
        events: list[str],
        generations: int,
        tolerance: float,
        threshold: float,
    ) -> dict[str, Any]:
        omega = orbit._frequency(omega)
        near, psi, periods = orbit._start(omega)
        told = _vibrochain._structure_along(
            self._scene(omega), near, psi, periods, free, *ends, events, generations, tolerance, threshold
        )
        answer: dict[str, Any] = json.loads(told)
        return answer

    def branch(
        self,
        orbit: StructureOrbit,
        omega: float | None = None,
        free: str = "",
        *,
        from_: float,
        to: float,
        events: tuple[str, ...] | list[str] = (),
        generations: SupportsIndex = 0,
        threshold: float = 0.0,
    ) -> StructureBranch:
        """An orbit as one number of the structure varies, followed both ways, with the events on it, and the branches that leave it.

        Parameters
        ----------
        orbit : StructureOrbit
            Where to begin.
        omega : float, optional
            Frequency of the load there; if not given that of the orbit.
        free : str
            "omega", "load", "static", "damping", "asymmetry", "restitution", "contact.0.upper", "stiffness.0.1" and the like.
        from_, to : float
            From where to where, the start between.
        events : sequence of str
            grazing, pitchfork, period-doubling, neimark-sacker, fold, sticking; empty: all.
        generations : int
            How often a branch may leave another; 0 is the orbit's own alone.
        threshold : float
            Excess a period from which on an orbit counts as unstable.

        Returns
        -------
        StructureBranch

        Raises
        ------
        RequestError
            For a number that the structure does not have, or a range without the start.

        Examples
        --------
        >>> branch = one.branch(first, omega=2.325, free="load", from_=0.5, to=2)
        >>> branch.ends
        [(0.5, 'range'), (2.0, 'range')]
        >>> both = one.branch(first, omega=2.325, free="omega", from_=2.3, to=2.5, generations=1)
        >>> [(leaving.word, leaving.force_periods) for leaving in both.leaving if leaving.physical.any()]
        [('0+,0+', 2)]
        """
        ends = ([float(from_)], [float(to)])
        count = generations.__index__()
        if not 0 <= count < 2**32:
            raise RequestError(f"generations = {count} is out of range: give a whole number from 0")
        return StructureBranch._all(free, self._along(orbit, omega, [free], ends, _vibrochain._items("events", events), count, 1e-4, threshold))

    def curves(
        self,
        orbit: StructureOrbit,
        omega: float | None = None,
        event: str = "",
        free: tuple[str, str] = ("", ""),
        *,
        from_: tuple[float, float],
        to: tuple[float, float],
        tolerance: float = 1e-4,
    ) -> list[StructureCurve]:
        """The events of one kind on the branch of an orbit along the first of two numbers, each followed through a window of both.

        Parameters
        ----------
        orbit : StructureOrbit
            Where to begin.
        omega : float, optional
            Frequency of the load there; if not given that of the orbit.
        event : str
            grazing, pitchfork, period-doubling, neimark-sacker, fold or sticking.
        free : tuple of two str
            The numbers that vary, as for `branch`.
        from_, to : tuple of two float
            The window, the start in it.
        tolerance : float
            How far a straight line between neighbouring points may be from the curve, as a part of the window's sides.

        Returns
        -------
        list of StructureCurve
            Empty where there is no such event.

        Raises
        ------
        RequestError
            For a number that the structure does not have, or a window without the start.

        Examples
        --------
        >>> import vibrochain as vc
        >>> stop = vc.Contact(at=0, upper=1.0, restitution=0.8)
        >>> one = vc.Structure([1.0], [1.0], damping=[0.1], contacts=[stop], load=[1.0])
        >>> found = one.curves(one.orbits("0+", omega=1.0)[0], omega=1.0, event="grazing", free=("omega", "load"), from_=(0.5, 0.5), to=(2, 2))
        >>> sorted(curve.ends[0] for curve in found)
        ['at the edge of the window', 'at the edge of the window']
        """
        ends = ([float(one) for one in from_], [float(one) for one in to])
        answer = self._along(orbit, omega, _vibrochain._items("free", free), ends, [event], 0, float(tolerance), 0.0)
        told = answer["labels"], answer["heading"]
        found = zip(answer["curves"], answer["touches"])
        return [StructureCurve._of((free[0], free[1]), parts, touch, *told) for parts, touch in found]

    @sharing
    def sweep(
        self,
        words: list[str] | tuple[str, ...],
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int] | None = None,
        *,
        omega: float | None = None,
        title: str | None = None,
        compute: Mapping[str, Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> Map:
        """What lives at each point of one or two of the structure's numbers, as ``mapgen sweep`` tells it.

        Parameters
        ----------
        {axes}
        {titled}
        threads : int, optional
            Threads to compute on, one a core if not given.

        Returns
        -------
        Map

        Raises
        ------
        RequestError
            For a number that the structure does not have, or a word that is none.

        Examples
        --------
        >>> table = one.sweep(["0+"], ("omega", 2.0, 3.0, 20), ("contact.0.upper", 0.05, 0.3, 10))
        >>> table, sorted(table.classes)
        (<Map of 200 cells: contact.0.upper (10) × omega (20)>, ['none', 'stable', 'unstable'])
        """
        scene = self.scene(words, x, y, omega=omega, title=title, compute=compute)
        return sweep(scene, threads=threads)

    @sharing
    def fate(
        self,
        words: list[str] | tuple[str, ...],
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int] | None = None,
        *,
        omega: float | None = None,
        **asked: Any,
    ) -> Fates:
        """What runs come to that start near the orbits of these words, or without words from rest, at each point of one or two numbers.

        Parameters
        ----------
        {axes}
        asked : dict
            The keywords of `vibrochain.fate`: ``breathers``, ``starts``, ``periods``, ``perturb`` and so on.

        Returns
        -------
        Fates

        Raises
        ------
        RequestError
            As `sweep`; for a value out of range.

        Examples
        --------
        >>> found = one.fate([], ("omega", 2.2, 2.4, 3), starts=1, periods=200)
        >>> found["words"].tolist()
        ['0+ 1', '0+ 1', '0+ 1']
        """
        if not _vibrochain._items("words", words):
            asked = {"breathers": "rest", **asked}
        return fate(self.scene(words, x, y, omega=omega), **asked)

    @sharing
    def scene(
        self,
        words: list[str] | tuple[str, ...],
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int] | None = None,
        *,
        omega: float | None = None,
        title: str | None = None,
        compute: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """The scene of a map over the structure, which `vibrochain.sweep`, `vibrochain.fate` and `vibrochain.sweep_shares` take.

        Parameters
        ----------
        {axes}
        {titled}

        Returns
        -------
        dict
            With the keys of a scene file; as JSON ``mapgen`` reads it.

        Examples
        --------
        >>> sorted(one.scene(["0+"], ("omega", 2.0, 3.0, 20)))
        ['compute', 'contact', 'force', 'structure', 'sweep']
        """
        axes = {"x": x} if y is None else {"x": x, "y": y}
        names = ("parameter", "from", "to", "points")
        scene: dict[str, Any] = {"structure": self._structure, "contact": self._contacts, "force": self._force}
        scene["sweep"] = {key: dict(zip(names, axis)) for key, axis in axes.items()}
        scene["compute"] = {"families": _vibrochain._items("words", words), **(compute or {})}
        scene.update({key: value for key, value in (("omega", omega), ("title", title)) if value is not None})
        return scene

    def __repr__(self) -> str:
        parts = self._structure
        size = len(parts["mass"]) if "mass" in parts else len(parts["frequencies"])
        kind = "coordinates" if "mass" in parts else "modes"
        count = len(self._contacts)
        return f"Structure({size} {kind[:-1] if size == 1 else kind}, {count} contact{'' if count == 1 else 's'})"
