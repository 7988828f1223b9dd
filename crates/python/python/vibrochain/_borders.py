"""All borders of a scene's window."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, SupportsIndex

from . import _vibrochain
from ._map import given, telling
from ._vibrochain import Borders


def curves(
    scene: str | os.PathLike[str] | dict[str, Any],
    *,
    tolerance: float = 1e-6,
    places: SupportsIndex = 100_000,
    special: bool = False,
    threads: SupportsIndex | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Borders:
    """Finds every border in a scene's window, as ``mapgen curves`` does, and what lives between them.

    Parameters
    ----------
    scene : str, os.PathLike or dict
        A scene file with two equally spaced axes, the manifest of a table, or a dictionary with the same keys (`read_scene`).
    tolerance : float
        How far a straight line between two neighbouring points may be from its border, as a part of the window's sides.
    places : int
        Places of the window, spread by area, that are asked what lives there once all borders are known.
    special : bool
        Whether points of codimension two are wanted.
    threads : int, optional
        Threads to compute on, 1 to 1024; one a core if not given.
    progress : bool or callable
        Whether to tell on standard error how far a stage of the search is; or what is called as ``progress(done, all)`` now and then.

    Returns
    -------
    Borders

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    RequestError
        For a scene that is wrong, without two equally spaced axes, or for a tolerance out of range.
    KeyboardInterrupt
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import vibrochain as vc
    >>> found = vc.curves("scenes/conservative-n5.toml", places=2000)
    >>> found
    <Borders: 40 over omega and gamma2, 8 stripes among them>
    >>> share, error = found.areas["none"]
    >>> bool(abs(sum(share for share, _ in found.areas.values()) - 1) < 1e-9)
    True
    """
    with telling(progress, "steps") as told:
        return _vibrochain._curves(*given(scene), tolerance, places, special, threads, told)
