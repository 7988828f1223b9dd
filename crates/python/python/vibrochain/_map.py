"""Maps of breathers over parameters."""

from __future__ import annotations

import builtins
import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from . import _vibrochain
from ._errors import RequestError
from ._pictures import BESIDE, STYLE, axes_for, class_colour, colour, drawing, needed, scaled, titled

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

# How stability is lost, as textures.
_HATCHES = {"neimark-sacker": "", "period-doubling": "///", "plus-one": "...", "pitchfork": "||"}

# What mapgen's pictures call columns of numbers.
_LABELS = {
    "spectral_radius": "largest |μ|",
    "margin": "margin, the smallest distance to a barrier",
    "impulse": "strongest impulse |P|",
    "solutions": "physical breathers",
}

# The most numbers of an array in a scene: more cells than any sweep in memory has.
_MOST = 10_000_000

# An excess below this is none; excesses are drawn by logarithms where the largest is so many times the smallest.
_LEAST_EXCESS = 1e-8
_DECADES = 100

# A value in digits is that of an axis if it is no farther from it than this part of the largest one.
_SAME = 16 * np.finfo(float).eps

# What the legend calls cells whose class is not known.
_UNKNOWN = _vibrochain._class_words([""])[0]

_PARTS = ("title", "model", "sweep", "compute")
_OF_STRUCTURES = ("title", "omega", "word", "force_periods", "structure", "contact", "force", "sweep", "compute")


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
    FileNotFoundError
        If there is no such file.
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
    known = _OF_STRUCTURES if "structure" in scene else _PARTS
    unknown = [key for key in scene if key not in known] if "program" not in scene else []
    if unknown:
        raise RequestError(f"scene: {unknown[0]!r} is unknown: give {', '.join(known)}")

    def plain(value: Any) -> Any:
        # Numbers and arrays of NumPy.
        if hasattr(value, "tolist"):
            if np.size(value) > _MOST:
                raise RequestError(f"scene: an array of {np.size(value)} numbers is too long: give at most {_MOST}")
            return value.tolist()
        raise RequestError(f"scene: {value!r} cannot be part of one: give numbers, texts, lists and dictionaries")

    try:
        return json.dumps(scene, allow_nan=False, default=plain)
    except ValueError as error:
        if isinstance(error, RequestError):
            raise
        raise RequestError(f"scene: {error}: give finite numbers") from None


def given(scene: str | os.PathLike[str] | dict[str, Any]) -> tuple[str | None, str]:
    """The text of a scene that is no file, and where messages say that it stands."""
    return (_as_text(scene), "scene") if isinstance(scene, dict) else (None, os.fspath(scene))


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
        A scene file, of a chain or of a structure, the manifest of a table, or a dictionary with the same keys (`read_scene`).
    threads : int, optional
        Threads to compute on, 1 to 1024; one a core if not given. The map is the same to the bit whatever their number.
    progress : bool or callable
        Whether to tell on standard error how far it is; or what is called as ``progress(done, cells)`` now and then.

    Returns
    -------
    Map

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    RequestError
        For a scene that is wrong, where the message points at the line.
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
    with telling(progress, "cells") as told:
        return Map(_vibrochain._sweep(*given(scene), threads, told))


class _Progress:
    """A line that is written over and over."""

    def __init__(self, what: str) -> None:
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


@contextlib.contextmanager
def telling(progress: bool | Callable[[int, int], object], what: str) -> Iterator[Callable[[int, int], object] | None]:
    """What is called with how many of these are done: a line on standard error, the caller's own, or nothing."""
    if progress is not True:
        yield progress or None
        return
    line = _Progress(what)
    try:
        yield line
    finally:
        line.close()


class _Table:
    """Columns of the cells of a scene."""

    def __init__(self, parts: dict[str, Any]) -> None:
        self.scene: dict[str, Any] = json.loads(parts["scene"])
        self.coords: dict[str, NDArray[np.float64]] = {name: values for name, values, _ in parts["axes"]}
        self._labels: dict[str, str] = {name: label for name, _, label in parts["axes"]}
        self._caption: tuple[str, str, str] = parts["caption"]
        self.dims = tuple(self.coords)
        self.shape = tuple(len(values) for values in self.coords.values())
        self._places: dict[str, float] = dict(parts["parameters"])
        self._numbers: dict[str, NDArray[Any]] = {}
        self._words: dict[str, tuple[NDArray[np.signedinteger[Any]], tuple[str, ...]]] = {}
        self._texts: dict[str, NDArray[np.str_]] = {}
        for name, values in parts["columns"]:
            if isinstance(values, tuple):
                codes, words = values
                self._words[name] = codes.reshape(self._shape(name)), tuple(words)
            elif isinstance(values, list):
                self._texts[name] = np.array(values, dtype=np.str_).reshape(self._shape(name))
            else:
                self._numbers[name] = values.reshape(self._shape(name))
        self.columns = (*self._places, *(name for name, _ in parts["columns"]))

    def _shape(self, name: str) -> tuple[int, ...]:
        """The shape of a column."""
        return self.shape

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name in self._numbers:
            return self._numbers[name]
        if name in self._words:
            codes, words = self._words[name]
            # A cell without one has the last code, -1.
            return np.array([*words, ""])[codes]
        if name in self._texts:
            return self._texts[name]
        if name in self.coords:
            axis = self.dims.index(name)
            values = self.coords[name].reshape([-1 if i == axis else 1 for i in range(len(self.dims))])
            return np.broadcast_to(values, self.shape)
        if name in self._places:
            return np.broadcast_to(self._places[name], self.shape)
        raise KeyError(f"{name!r} is no column of this table: it has {', '.join(self.columns)}")

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        return int(np.prod(self.shape))

    def __repr__(self) -> str:
        axes = " × ".join(f"{name} ({len(values)})" for name, values in self.coords.items())
        return f"<{type(self).__name__} of {len(self)} cells: {axes}>"

    def codes(self, name: str) -> tuple[NDArray[np.signedinteger[Any]], tuple[str, ...]]:
        """A column of words as numbers.

        Parameters
        ----------
        name : str
            A column of words, such as "status".

        Returns
        -------
        codes : numpy.ndarray of int8, of int32 where there are more than 128 words, of the grid's shape
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


class Map(_Table):
    """The cells of a sweep, as columns of the grid's shape.

    Columns are those of ``mapgen``'s tables (`columns`), by name: ``table["margin"]``. Numbers are dimensionless; those of a structure
    are in its own units. Where a cell has no value a number is NaN and
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
        Largest residual of any physical orbit in its defining equations; NaN of a structure's map.

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
        super().__init__(parts)
        codes, words = self._words["class"]
        counts = np.bincount(codes.ravel() + 1, minlength=len(words) + 1)[1:]
        self.classes: dict[str, int] = {word: int(count) for word, count in zip(words, counts)}
        self.statuses: dict[str, int] = parts["statuses"]
        self.worst_residual: float = parts["worst_residual"]
        # Classes as colours know them, and as the legend calls them.
        shown = parts.get("shown") or (codes, words, _vibrochain._class_words(list(words)))
        self._shown = np.reshape(shown[0], self.shape), tuple(shown[1]), tuple(shown[2])

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
        library = needed("pandas", "Map.to_pandas")

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
            What stands at an axis is its ``long_name``, which xarray's pictures show.

        Raises
        ------
        ImportError
            Without xarray.

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 4, 3
        >>> data = vc.sweep(scene).to_xarray()  # doctest: +XARRAY
        >>> dict(data.sizes), data["omega"].attrs["long_name"]  # doctest: +XARRAY
        ({'gamma2': 3, 'omega': 4}, 'frequency ω')
        """
        library = needed("xarray", "Map.to_xarray")
        def named(name: str) -> dict[str, str]:
            # What xarray writes at axes.
            label = self._labels.get(name) or _LABELS.get(name)
            return {"long_name": label} if label else {}

        data = {name: (self.dims, self[name], named(name)) for name in (*self._words, *self._numbers)}
        axes = {name: (name, values, named(name)) for name, values in self.coords.items()}
        fixed = {name: value for name, value in self._places.items() if name not in self.coords}
        dataset: xarray.Dataset = library.Dataset(data, coords={**axes, **fixed})
        return dataset

    @drawing
    def plot(self, color: str = "class", ax: Axes | None = None, *, slice: Mapping[str, float] | None = None) -> Axes:
        """Draws the map: coloured by class, or by a column of numbers. A sweep over one parameter is curves.

        How stability is lost is a texture over the classes, all that is fixed stands below the title, and the legend beside the
        axes. In a script the picture must be saved or shown: ``table.plot().figure.savefig("map.png")``, or
        ``matplotlib.pyplot.show()``.

        Over one parameter stable breathers are solid lines, unstable ones dashed, with gaps where none is; there is a colour for each
        family.

        Parameters
        ----------
        color : str
            "class", or a column of numbers such as "spectral_radius", "margin" or "solutions". By its class a map over one parameter
            has no height: the curve is then that of the first column of numbers that has values.
        slice : mapping of str to float, optional
            A value for each axis that is not drawn: ``slice={"asymmetry": 0.4}``. One or two axes must be left.
        {drawn}
        RequestError
            For a map over more than two parameters without `slice`, a value that is none of its axis, or a column that cannot be drawn.

        Examples
        --------
        >>> import vibrochain as vc
        >>> scene = vc.read_scene("scenes/conservative-n20.toml")
        >>> scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 40, 31
        >>> table = vc.sweep(scene)
        >>> ax = table.plot()  # doctest: +MATPLOTLIB
        >>> ax.get_xlabel(), ax.get_ylabel()  # doctest: +MATPLOTLIB
        ('frequency ω', 'coupling stiffness γ₂')
        >>> ax = table.plot("margin", slice={"gamma2": 0.1})  # doctest: +MATPLOTLIB
        >>> ax.get_xlabel(), ax.get_ylabel()  # doctest: +MATPLOTLIB
        ('frequency ω', 'margin, the smallest distance to a barrier')
        """
        where = self._where(slice or {})
        dims = tuple(name for name, at in zip(self.dims, where) if isinstance(at, builtins.slice))
        if len(dims) not in (1, 2):
            axes = ", ".join(dims) or "no axis"
            example = f": fix the others by slice={{{dims[0]!r}: {self.coords[dims[0]][0]}}}" if dims else ""
            raise RequestError(f"pictures have one or two axes, here are {len(dims)}, {axes}{example}")
        if color != "class" and color not in self._numbers:
            known = ", ".join(["class", *self._numbers])
            raise RequestError(f"{color!r} cannot be drawn: give one of {known}")
        ax = axes_for(ax)
        ax.set_xlabel(self._labels[dims[-1]])
        heading, fixed, criterion = self._caption
        # Numbers of a structure have no symbols.
        symbols = {**self._labels, **STYLE["symbols"]}
        at = [f"{symbols[name]} = {self.coords[name][at]:g}" for name, at in zip(self.dims, where) if name not in dims]
        titled(ax, heading, ", ".join(part for part in (fixed, *at, criterion) if part))
        if len(dims) == 1:
            self._curves(ax, dims[0], where, color)
        else:
            ax.set_ylabel(self._labels[dims[0]])
            y, x = (self.coords[name] for name in dims)
            # Lists in the order of their values.
            order = np.ix_(np.argsort(y), np.argsort(x))
            y, x = np.sort(y), np.sort(x)
            if color == "class":
                (classes, names, words), (codes, mechanisms) = self._shown, self._words["mechanism"]
                _classes(ax, x, y, (classes[where][order], names, words), (codes[where][order], mechanisms))
            else:
                self._colours(ax, x, y, color, self._numbers[color][where][order].astype(float))
        return ax

    def _where(self, fixed: Mapping[str, float]) -> tuple[int | builtins.slice, ...]:
        """The index of the cells at these values of axes."""
        unknown = [name for name in fixed if name not in self.coords]
        if unknown:
            raise RequestError(f"slice: {unknown[0]!r} is no axis of this map: give one of {', '.join(self.dims)}")
        return tuple(_place(name, self.coords[name], fixed[name]) if name in fixed else builtins.slice(None) for name in self.dims)

    def _colours(
        self, ax: Axes, x: NDArray[Any], y: NDArray[Any], color: str, values: NDArray[Any]
    ) -> None:
        from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm

        label = _LABELS.get(color, color)
        norm: Any = None
        excess = values - 1.0
        there = excess[excess >= _LEAST_EXCESS]
        if color == "spectral_radius" and there.size and there.max() >= _DECADES * there.min():
            # Next to grazing a few are without bound.
            low, high = np.floor(np.log10(there.min())), np.ceil(np.log10(np.quantile(there, 0.99)))
            ends = 10.0**low, 10.0 ** max(high, low + 1)
            none = excess < ends[0]
            ax.pcolormesh(x, y, np.ma.masked_where(~none, none), cmap=ListedColormap([colour(STYLE["below"])]), shading="nearest")
            values, label, norm = np.ma.masked_where(none, excess), f"excess |μ| − 1 a period (grey: less than {ends[0]:g})", LogNorm(*ends)
        elif color == "solutions":
            values[values == 0] = np.nan
            most = max(int(np.nanmax(values, initial=1)), 1)
            norm = BoundaryNorm(np.arange(0.5, most + 1), 256) if most < 10 else None
        mesh = ax.pcolormesh(x, y, values, cmap="viridis", norm=norm, shading="nearest")
        beyond = isinstance(norm, LogNorm) and np.ma.max(values) > ends[1]
        bar = ax.figure.colorbar(mesh, ax=ax, label=label, extend="max" if beyond else "neither")
        if color == "solutions" and norm is not None:
            bar.set_ticks(range(1, most + 1))

    def _curves(self, ax: Axes, dim: str, where: tuple[Any, ...], color: str) -> None:
        if color == "class":
            color = next((name for name, values in self._numbers.items() if not np.isnan(values[where]).all()), "margin")
        ax.set_ylabel(_LABELS.get(color, color) + (", logarithmic" if color == "spectral_radius" else ""))
        place = self.coords[dim]
        order = np.argsort(place)
        codes, names, words = self._shown
        values, codes = self._numbers[color][where][order].astype(float), codes[where][order]
        place = place[order]
        axis: dict[str, Any] = next(axis for axis in _axes(self.scene) if axis["parameter"] == dim)
        if axis.get("spacing") == "log":
            ax.set_xscale("log")
        for code in dict.fromkeys(codes.tolist()):
            name, label = (names[code], words[code]) if code >= 0 else ("", _UNKNOWN)
            if name == "none":
                continue
            # A line is one class's, and ends halfway to the next.
            shown = np.where(codes == code, values, np.nan)
            # Of lines, each family has the colour of its stable class.
            own = class_colour(name.removeprefix("un")) if name else "grey"
            style = "--" if name.startswith("unstable") else "-"
            alone = ~np.isnan(shown)
            alone[1:] &= np.isnan(shown[:-1])
            alone[:-1] &= np.isnan(shown[1:])
            ax.plot(place, shown, style, color=own, label=label)
            ax.plot(place[alone], shown[alone], ".", color=own, markersize=3)
        if color == "spectral_radius":
            scaled(ax, _vibrochain._Pane("", "", "", [("", 0, 1, "", 0, list(zip(place.tolist(), values.tolist())))], moduli=True))
        if ax.get_legend_handles_labels()[1]:
            ax.legend(**BESIDE)


def _axes(scene: dict[str, Any]) -> list[dict[str, Any]]:
    sweep = scene["sweep"]
    return [*(sweep[name] for name in ("x", "y") if name in sweep), *sweep.get("axes", [])]


def _place(name: str, values: NDArray[np.float64], wanted: float) -> int:
    """Which of an axis' values this is, as it is written by people."""
    nearest = int(np.argmin(np.abs(values - wanted)))
    if abs(values[nearest] - wanted) <= _SAME * np.abs(values).max():
        return nearest
    beside = [values[values < wanted].max(initial=-np.inf), values[values > wanted].min(initial=np.inf)]
    near = " and ".join(repr(float(value)) for value in beside if np.isfinite(value))
    raise RequestError(f"slice: {name} = {wanted} is none of its {len(values)} values: next to it are {near}")


def _classes(
    ax: Axes,
    x: NDArray[Any],
    y: NDArray[Any],
    classes: tuple[NDArray[np.int8], tuple[str, ...], tuple[str, ...]],
    mechanisms: tuple[NDArray[np.signedinteger[Any]], tuple[str, ...]],
) -> None:
    from matplotlib import rc_context
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    codes, names, words = classes
    colours, words = [class_colour(name) for name in (*names, "unknown")], (*words, _UNKNOWN)
    shown = np.where(codes < 0, len(names), codes)
    ax.pcolormesh(x, y, shown, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) + 0.5, shading="nearest")
    known = [*STYLE["classes"], "unknown"]
    there = sorted((i for i in range(len(words)) if (shown == i).any()), key=lambda i: known.index((*names, "unknown")[i]))
    legend = [Patch(facecolor=colours[i], edgecolor="grey", label=words[i]) for i in there]
    with rc_context({"hatch.color": (0.0, 0.0, 0.0, 0.5), "hatch.linewidth": 0.5}):
        for code, name in enumerate(mechanisms[1]):
            lost = mechanisms[0] == code
            if not lost.any():
                continue
            hatch = _HATCHES[name]
            legend.append(Patch(facecolor=colour(STYLE["loss"]), edgecolor="grey", hatch=hatch, label=STYLE["mechanisms"][name]))
            # A map of one row or column has no areas.
            if hatch and min(lost.shape) > 1:
                ax.contourf(x, y, lost.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch])
    ax.legend(handles=legend, **BESIDE)
