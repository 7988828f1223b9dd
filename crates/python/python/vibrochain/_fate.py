"""What becomes of perturbed breathers."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, SupportsIndex

from . import _vibrochain
from ._map import _Table, given, telling


class Fates(_Table):
    """What the runs from the breathers of a scene's cells have come to, as columns of the grid's shape.

    Columns are those of ``mapgen fate``'s tables (`columns`), by name: ``found["share_chaos"]``. Where there is no value a number is
    NaN, a count 0 and a word empty. If runs start from one breather a cell at most (``breathers="class"`` or ``"rest"``), each array has the grid's
    shape; else those of breathers have one axis more, at its end, with a place for each physical breather of a cell, in their order.

    Attributes
    ----------
    scene : dict
        What was computed.
    dims : tuple of str
        The parameters along the axes of the grid, the slowest first.
    coords : dict of str to numpy.ndarray
        Their values.
    shape : tuple of int
        The number of values of each.
    columns : tuple of str
        The names of all columns.
    ends : dict of str to int
        How many runs end in which way.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/fate-n20.toml")
    >>> scene["model"]["sites"], scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 5, 3, 2
    >>> found = vc.fate(scene, starts=2, periods=50)
    >>> found.dims, found["end"].shape, found["share_breather"].dtype
    (('gamma2', 'omega'), (2, 3), dtype('float64'))
    """

    def __init__(self, parts: dict[str, Any]) -> None:
        self._each: int | None = parts["places"]
        super().__init__(parts)
        self.ends: dict[str, int] = parts["ends"]

    def _shape(self, name: str) -> tuple[int, ...]:
        return self.shape if self._each is None or name in ("solutions", "status") else (*self.shape, self._each)


def fate(
    scene: str | os.PathLike[str] | dict[str, Any],
    *,
    breathers: str = "class",
    starts: SupportsIndex = 16,
    perturb: float = 1e-3,
    seed: SupportsIndex = 1,
    periods: SupportsIndex = 2000,
    transient: float = 0.5,
    tolerance: float = 0.02,
    leave: float = 0.1,
    in_sequence: bool = False,
    threads: SupportsIndex | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Fates:
    """Simulates many perturbed runs from the breathers of every cell of a scene, as ``mapgen fate`` does, and tells how they end.

    Parameters
    ----------
    scene : str, os.PathLike or dict
        A scene file, of a chain or of a structure, the manifest of a table, or a dictionary with the same keys (`read_scene`).
    breathers : {"class", "every", "unstable", "rest"}
        From which breathers of a cell runs start: the one that gives the cell its class, all physical ones, all unstable ones; of a
        structure also from rest, on none: "words" then tells what it settles on.
    starts : int
        Runs from each.
    perturb : float
        Largest change of a displacement, or of a velocity over ω, at the start.
    seed : int
        What all perturbations are drawn from, 0 to 2⁶⁴ − 1.
    periods : int
        Periods of the force of each run.
    transient : float
        Share of a run that is left out before its end is looked at.
    tolerance, leave : float
        By how much impacts may differ and still be the same; by how much before the breather counts as left.
    in_sequence : bool
        Of a structure: whether contacts that share coordinates and hit at one instant do so in the order of their numbers, again until none moves
        into its barrier. Otherwise such a run is incomplete. A scene says it by ``in_sequence = true`` in ``[structure]``.
    threads : int, optional
        Threads to compute on, 1 to 1024; one a core if not given. The result is the same to the bit whatever their number.
    progress : bool or callable
        Whether to tell on standard error how far it is; or what is called as ``progress(done, runs)`` now and then.

    Returns
    -------
    Fates

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    RequestError
        For a scene that is wrong, or a value out of range.
    TooLargeError
        For more than a million cells: those belong into a file.
    KeyboardInterrupt
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/fate-n20.toml")
    >>> scene["model"]["sites"], scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 5, 3, 2
    >>> found = vc.fate(scene, starts=2, periods=50)
    >>> found
    <Fates of 6 cells: gamma2 (2) × omega (3)>
    >>> sum(found.ends.values()) == int(found["starts"].sum())
    True
    >>> every = vc.fate(scene, breathers="every", starts=1, periods=50)
    >>> every["spectral_radius"].shape == (2, 3, int(every["number"].max()))
    True
    """
    asked = (breathers, starts, perturb, seed, periods, transient, tolerance, leave, in_sequence)
    with telling(progress, "runs") as told:
        return Fates(_vibrochain._fate(*given(scene), *asked, threads, told))
