"""Maps of breathers over parameters."""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from . import _vibrochain
from ._errors import RequestError

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

# The colours of mapgen's pictures: blues for stable, orange and yellow for unstable.
_COLOURS = {
    "none": (255, 255, 255),
    "stable-double": (16, 50, 98),
    "double": (16, 50, 98),
    "stable-single": (46, 134, 171),
    "single": (46, 134, 171),
    "unstable-double": (236, 138, 60),
    "unstable-single": (250, 224, 120),
    "stable-word": (0, 110, 84),
    "word": (0, 110, 84),
    "unstable-word": (226, 160, 196),
}
_UNKNOWN = (204, 121, 167)

_PARTS = ("title", "model", "sweep", "compute")


def read_scene(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Reads a scene file, or the manifest of a table, as a dictionary.

    Parameters
    ----------
    path : str or os.PathLike
        The file.

    Returns
    -------
    dict
        ``model``, ``sweep``, ``compute`` and perhaps ``title``, with all defaults in place; `sweep` takes it, changed or not.

    Raises
    ------
    RequestError
        For a file that cannot be read or is no scene; the message points at the line.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/conservative-n20.toml")
    >>> scene["model"]
    {'sites': 21, 'gamma1': 0.2, 'asymmetry': 0.4, 'amplitude': 0.0, 'restitution': 1.0}
    >>> scene["sweep"]["x"]["points"] = 40
    """
    scene: dict[str, Any] = json.loads(_vibrochain._scene(os.fspath(path)))
    return scene


def _as_text(scene: dict[str, Any]) -> str:
    unknown = [key for key in scene if key not in _PARTS] if "program" not in scene else []
    if unknown:
        raise RequestError(f"scene: {unknown[0]!r} is unknown: give {', '.join(_PARTS)}")

    def plain(value: Any) -> Any:
        # Numbers and arrays of NumPy.
        if hasattr(value, "tolist"):
            return value.tolist()
        raise RequestError(f"scene: {value!r} cannot be part of one: give numbers, texts, lists and dictionaries")

    try:
        return json.dumps(scene, allow_nan=False, default=plain)
    except ValueError as error:
        if isinstance(error, RequestError):
            raise
        raise RequestError(f"scene: {error}: give finite numbers") from None


def sweep(
    scene: str | os.PathLike[str] | dict[str, Any],
    *,
    threads: SupportsIndex | None = None,
    progress: bool | Callable[[int, int], object] = False,
) -> Map:
    """Computes the map of a scene, as ``mapgen sweep`` does, in memory.

    Parameters
    ----------
    scene : str, os.PathLike or dict
        A scene file, the manifest of a table, or a dictionary with the same keys (`read_scene`).
    threads : int, optional
        Threads to compute on, 1 to 1024; one a core if not given. The map is the same to the bit whatever their number.
    progress : bool or callable
        Whether to tell on standard error how far it is; or what is called as ``progress(done, cells)`` now and then.

    Returns
    -------
    Map

    Raises
    ------
    RequestError
        For a scene that is wrong; the message points at the line.
    TooLargeError
        For more than 100 million cells: those belong into a file.
    KeyboardInterrupt
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/conservative-n20.toml")
    >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 40, 30
    >>> table = vc.sweep(scene)
    >>> table
    <Map of 1200 cells: gamma2 (30) × omega (40)>
    >>> table["spectral_radius"].shape
    (30, 40)
    """
    text, path = (_as_text(scene), "scene") if isinstance(scene, dict) else (None, os.fspath(scene))
    if progress is not True:
        return Map(_vibrochain._sweep(text, path, threads, progress or None))
    line = _Progress()
    try:
        return Map(_vibrochain._sweep(text, path, threads, line))
    finally:
        line.close()


class _Progress:
    """A line that is written over and over."""

    def __init__(self, what: str = "cells") -> None:
        self.told = ""
        self.what = what

    def __call__(self, done: int, cells: int) -> None:
        line = f"\r{100 * done // cells:3} %  {done}/{cells} {self.what}"
        if line != self.told:
            self.told = line
            sys.stderr.write(line)
            sys.stderr.flush()

    def close(self) -> None:
        if self.told:
            sys.stderr.write("\r" + " " * len(self.told) + "\r")
            sys.stderr.flush()


class Map:
    """The cells of a sweep, as columns of the grid's shape.

    Columns are those of ``mapgen``'s tables (`columns`), by name: ``table["margin"]``. Where a cell has no value a number is NaN and
    a word is empty. Cells run as in tables: the last axis of an array is the scene's fastest one.

    Attributes
    ----------
    scene : dict
        What was computed; `sweep` takes it once more.
    dims : tuple of str
        The parameters along the axes of every array, the slowest first.
    coords : dict of str to numpy.ndarray
        Their values.
    shape : tuple of int
        The number of values of each.
    columns : tuple of str
        The names of all columns, in the order of tables.
    classes, statuses : dict of str to int
        How many cells there are of each class and status.
    worst_residual : float
        Largest residual of any physical orbit in its defining equations.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/conservative-n20.toml")
    >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 40, 30
    >>> table = vc.sweep(scene)
    >>> table.dims, float(table.coords["gamma2"][-1])
    (('gamma2', 'omega'), 0.3)
    >>> bool((table["class"] == "stable-double").sum() == table.classes["stable-double"])
    True
    """

    def __init__(self, parts: dict[str, Any]) -> None:
        self.scene: dict[str, Any] = json.loads(parts["scene"])
        self.coords: dict[str, NDArray[np.float64]] = dict(parts["axes"])
        self.dims = tuple(self.coords)
        self.shape = tuple(len(values) for values in self.coords.values())
        self.classes: dict[str, int] = parts["classes"]
        self.statuses: dict[str, int] = parts["statuses"]
        self.worst_residual: float = parts["worst_residual"]
        self._places: dict[str, float] = dict(parts["parameters"])
        self._numbers: dict[str, NDArray[Any]] = {}
        self._words: dict[str, tuple[NDArray[np.int8], tuple[str, ...]]] = {}
        for name, values in parts["columns"]:
            if isinstance(values, tuple):
                codes, words = values
                self._words[name] = codes.reshape(self.shape), tuple(words)
            else:
                self._numbers[name] = values.reshape(self.shape)
        self.columns = (*self._places, *(name for name, _ in parts["columns"]))

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name in self._numbers:
            return self._numbers[name]
        if name in self._words:
            codes, words = self._words[name]
            # A cell without one has the last code, -1.
            return np.array([*words, ""])[codes]
        if name in self.coords:
            axis = self.dims.index(name)
            values = self.coords[name].reshape([-1 if i == axis else 1 for i in range(len(self.dims))])
            return np.broadcast_to(values, self.shape)
        if name in self._places:
            return np.broadcast_to(self._places[name], self.shape)
        raise KeyError(f"{name!r} is no column of this map: it has {', '.join(self.columns)}")

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        return int(np.prod(self.shape))

    def __repr__(self) -> str:
        axes = " × ".join(f"{name} ({len(values)})" for name, values in self.coords.items())
        return f"<Map of {len(self)} cells: {axes}>"

    def codes(self, name: str) -> tuple[NDArray[np.int8], tuple[str, ...]]:
        """A column of words as numbers.

        Parameters
        ----------
        name : str
            "class", "mechanism" or "status".

        Returns
        -------
        codes : numpy.ndarray of int8, of the grid's shape
            For each cell the place of its word in `words`; -1 where it has none.
        words : tuple of str

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 4, 3
        >>> codes, words = vc.sweep(scene).codes("status")
        >>> words, codes.dtype
        (('ok',), dtype('int8'))
        """
        if name not in self._words:
            raise KeyError(f"{name!r} is no column of words: those are {', '.join(self._words)}")
        return self._words[name]

    def to_pandas(self) -> pandas.DataFrame:
        """The map as a table, one row a cell, as in ``mapgen``'s CSV.

        Returns
        -------
        pandas.DataFrame
            Words are categories.

        Raises
        ------
        ImportError
            Without pandas.

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 4, 3
        >>> vc.sweep(scene).to_pandas().shape  # doctest: +PANDAS
        (12, 8)
        """
        library = _needed("pandas", "to_pandas")

        def column(name: str) -> Any:
            if name in self._words:
                codes, words = self._words[name]
                return library.Categorical.from_codes(codes.reshape(-1), categories=list(words))
            return self[name].reshape(-1)

        frame: pandas.DataFrame = library.DataFrame({name: column(name) for name in self.columns}, copy=False)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """The map as a labelled array for each column.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        ImportError
            Without xarray.

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 4, 3
        >>> dict(vc.sweep(scene).to_xarray().sizes)  # doctest: +XARRAY
        {'gamma2': 3, 'omega': 4}
        """
        library = _needed("xarray", "to_xarray")
        data = {name: (self.dims, self[name]) for name in (*self._words, *self._numbers)}
        fixed = {name: value for name, value in self._places.items() if name not in self.coords}
        dataset: xarray.Dataset = library.Dataset(data, coords={**self.coords, **fixed})
        return dataset

    def plot(self, column: str = "class", ax: Axes | None = None) -> Axes:
        """Draws the map: coloured by class, or by a column of numbers. A sweep over one parameter is a curve.

        Parameters
        ----------
        column : str
            "class", or a column of numbers such as "spectral_radius" or "margin".
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ImportError
            Without matplotlib.
        RequestError
            For a map over more than two parameters, or a column that cannot be drawn.

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 40, 30
        >>> ax = vc.sweep(scene).plot()  # doctest: +MATPLOTLIB
        >>> ax.get_xlabel(), ax.get_ylabel()  # doctest: +MATPLOTLIB
        ('omega', 'gamma2')
        """
        _needed("matplotlib", "plot")
        from matplotlib import pyplot
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        if len(self.dims) > 2:
            axes = ", ".join(self.dims)
            raise RequestError(f"a map over {axes} has {len(self.dims)} axes: pictures have one or two, sweep fewer parameters")
        if column != "class" and column not in self._numbers:
            known = ", ".join(["class", *self._numbers])
            raise RequestError(f"{column!r} cannot be drawn: give one of {known}")
        if ax is None:
            _, ax = pyplot.subplots()
        ax.set_xlabel(self.dims[-1])
        ax.set_title(self.scene.get("title", ""))
        if len(self.dims) == 1:
            [values] = self.coords.values()
            if column == "class":
                ax.plot(values, self["class"], ".")
            else:
                ax.plot(values, self[column])
                ax.set_ylabel(column)
            return ax
        y, x = (self.coords[name] for name in self.dims)
        ax.set_ylabel(self.dims[0])
        if column != "class":
            mesh = ax.pcolormesh(x, y, self[column], shading="nearest")
            ax.figure.colorbar(mesh, ax=ax, label=column)
            return ax
        codes, words = self._words["class"]
        names = [*words, "unknown"]
        colours = [(r / 255, g / 255, b / 255) for r, g, b in (_COLOURS.get(name, _UNKNOWN) for name in names)]
        shown = np.where(codes < 0, len(words), codes)
        ax.pcolormesh(x, y, shown, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) - 0.5, shading="nearest")
        there = [i for i in range(len(names)) if i < len(words) or (codes < 0).any()]
        ax.legend(handles=[Patch(facecolor=colours[i], edgecolor="grey", label=names[i]) for i in there], fontsize="small")
        return ax


def _needed(package: str, method: str) -> Any:
    try:
        return importlib.import_module(package)
    except ImportError as error:
        message = f"Map.{method} needs {package}, which is not installed: pip install {package}"
        raise ImportError(message, name=package) from error
