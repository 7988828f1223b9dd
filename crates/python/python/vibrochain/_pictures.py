"""Pictures in the colours, marks and words of ``mapgen``'s, drawn by matplotlib. What they show is put together in Rust, once for both."""

from __future__ import annotations

import functools
import importlib
import inspect
import textwrap
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from . import _vibrochain
from ._vibrochain import Borders, Branch, Diagram, EventCurve, Model, Orbit, _Pane

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE = _vibrochain._style()

# Legends stand beside the axes, where no data are.
BESIDE: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.02, 1.0), "borderaxespad": 0.0, "fontsize": "small"}

# Letters of a caption in a line, and of a name in a legend.
_CAPTION, _NAME = 72, 26

# Inches of a picture with its legend.
_SIZE = (7.6, 4.8)

# The shapes of marks, in the order of the program's.
_SHAPES = "os^Dv*"
_SIZES = {"filled": 5.0, "small": 3.0, "hollow": 8.0, "dot": 1.5, "": 0.0}

# Points of a width of one pixel of the program's lines.
_POINTS = 0.75

# What `pip install 'vibrochain[…]'` brings.
_EXTRAS = {"matplotlib": "plot", "pandas": "tables", "xarray": "tables", "distributed": "cluster"}


def needed(package: str, method: str) -> Any:
    """A package that only this method takes."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        message = f"{method} needs {package}, which is not installed: pip install {package}, or 'vibrochain[{_EXTRAS[package]}]'"
        raise ImportError(message, name=package) from error


# What docstrings of several methods have in common, by the name that stands in them for it.
_SHARED = {
    "drawn": """\
ax : matplotlib.axes.Axes, optional
    Where to draw; a new figure if not given.

Returns
-------
matplotlib.axes.Axes

Raises
------
ImportError
    Without matplotlib.""",
    "all": """\
all : bool
    Whether orbits that are not physical are drawn, too.""",
    "curve": """\
Parts whose orbits are not physical are grey and dashed; points of codimension two are marked. On axes that show a curve
already it has the next colour.

Parameters
----------""",
    "axes": """\
words : sequence of str
    The words to look for, as for `orbits`; ``"0+/2"`` over two periods of the load.
x, y : tuple of (str, float, float, int)
    A number as for `branch`, from where to where, and in how many values.
omega : float, optional
    Frequency of the load, where it does not vary.""",
    "titled": """\
title : str, optional
    What stands above the picture.
compute : mapping, optional
    More of a scene's table ``compute``: ``{"threshold": 0.01}``, ``{"stability": False}``.""",
}

_Method = TypeVar("_Method", bound=Callable[..., Any])


def sharing(method: _Method) -> _Method:
    """A method whose docstring says what others say, too: ``{drawn}`` stands for `_SHARED`'s text of that name."""
    text = inspect.cleandoc(method.__doc__ or "")
    for name, shared in _SHARED.items():
        text = text.replace(f"{{{name}}}", shared)
    method.__doc__ = text
    return method


def drawing(method: _Method) -> _Method:
    """A method that draws: it needs matplotlib."""

    @functools.wraps(method)
    def plot(self: Any, *arguments: Any, **named: Any) -> Any:
        needed("matplotlib", f"{type(self).__name__}.plot")
        return method(self, *arguments, **named)

    return cast(_Method, sharing(plot))


def colour(rgb: Iterable[int]) -> str:
    """A colour as matplotlib and HTML write it."""
    return "#" + bytes(rgb).hex()


def titled(ax: Axes, heading: str, caption: str = "") -> None:
    """A heading, and what is fixed, in lines that fit."""
    # A single letter is a number's name.
    if heading[1:2].islower() and heading[:1].isascii():
        heading = heading[:1].upper() + heading[1:]
    ax.set_title("\n".join(_filled(part, _CAPTION) for part in (heading, caption) if part), fontsize="medium")


def _filled(text: str, width: int) -> str:
    """The text in lines that do not part a number from its sign or its name."""
    for sign in "=+−":
        text = text.replace(f" {sign} ", f"\xa0{sign}\xa0")
    return textwrap.fill(text, width).replace("\xa0", " ")


def axes_for(ax: Axes | None) -> Axes:
    """A figure with room for what stands beside the axes, unless there are axes."""
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained", figsize=_SIZE)[1] if ax is None else ax


def draw(pane: _Pane, ax: Axes | None, heading: str) -> Axes:
    """Draws a panel, over what the axes show already."""
    fresh = ax is None or not ax.has_data()
    ax = axes_for(ax)
    lines = [colour(rgb) for rgb in STYLE["lines"]]
    caption, x, y = pane.words()
    levels, uprights, is_round = pane.lines()
    thin: dict[str, Any] = {"color": "grey", "linestyle": "--", "linewidth": 0.8, "zorder": 1.0}
    for level in levels:
        ax.axhline(level, **thin)
    for upright in uprights:
        ax.axvline(upright, **thin)
    for name, number, width, mark, shape, points in pane.series():
        own = lines[number % len(lines)]
        size = _SIZES[mark]
        ax.plot(
            *points.T,
            color=own,
            linestyle="none" if width == 0 else "-" if width > 0 else "--",
            linewidth=_POINTS * abs(width),
            marker="none" if mark == "" else "." if mark == "dot" else _SHAPES[shape % len(_SHAPES)],
            markersize=size,
            markerfacecolor="none" if mark == "hollow" else own,
            label=_filled(name, _NAME) or "_",
        )
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    titled(ax, heading, caption)
    scaled(ax, pane, fresh)
    if is_round:
        ax.set_aspect("equal", adjustable="datalim")
    if ax.get_legend_handles_labels()[1]:
        # Dots of many points are too small to show their colour in a legend.
        dots = any(mark == "dot" for _, _, _, mark, _, _ in pane.series())
        ax.legend(**BESIDE, markerscale=6 if dots else 1)
    return ax


def scaled(ax: Axes, pane: _Pane, fresh: bool = True) -> None:
    """Gives axes the ends and the scale of a panel; axes that are not fresh grow at most."""
    x_range, y_range, moduli = pane.axes()
    for ends, name in [(x_range, "x"), (y_range, "y")]:
        if ends is not None:
            low, high = ends if fresh else getattr(ax, f"get_{name}lim")()
            ax.set(**{f"{name}lim": (min(ends[0], low), max(ends[1], high))})
    if moduli:
        _moduli(ax)


def _moduli(ax: Axes) -> None:
    """Moduli of multipliers on the logarithmic axis that pictures of ``mapgen`` have, whatever of them the axes show."""
    from matplotlib.ticker import NullFormatter

    heights = np.concatenate([np.ravel(line.get_ydata()).astype(float) for line in ax.get_lines()])
    seen = heights[np.isfinite(heights) & (heights > 0)]
    ends, ticks, marks = _vibrochain._modulus_axis([float(seen.min()), float(seen.max())] if seen.size else [])
    ax.set_yscale("log")
    ax.set_yticks([number for number, _ in ticks], [words for _, words in ticks])
    ax.set_yticks(marks, minor=True)
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_ylim(*ends)


def orbit_panes(orbit: Orbit) -> tuple[list[_Pane], str]:
    """What `mapgen` draws of an orbit: the profile, and the motion; with its caption."""
    (profile, caption), (motion, _) = (_vibrochain._orbit_pane(orbit, what) for what in ("profile", "motion"))
    return [profile, motion], caption


def branch_pane(branches: list[Branch], show: str, all: bool) -> tuple[_Pane, str]:
    """Branches over what varies, and what they have in common."""

    def rows(branch: Branch) -> list[tuple[Any, ...]]:
        listed: list[tuple[Any, ...]] = []
        for point in branch.points:
            verdict, orbit = point.verdict, point.orbit
            told = (None, None) if verdict is None else (None if verdict.undecided else verdict.stable, verdict.spectral_radius)
            listed.append((None, point.value, *_hits(orbit), point.margin, point.physical, *told))
        for shift, (event, place) in enumerate(zip(branch.events, branch.places)):
            row = (event.event, event.value, *_hits(event.orbit), None, event.physical, None, None)
            listed.insert(place + shift, row)
        return listed

    def periods(branch: Branch) -> int:
        return branch.points[0].orbit.force_periods if branch.points else 1

    told = [(branch.name, branch.generation, periods(branch), rows(branch)) for branch in branches]
    free = branches[0].free
    models: list[Model] = []
    for branch in branches:
        places = np.argsort(branch.values)
        models += [branch.points[place].orbit.model for place in {int(places[0]), int(places[-1])}] if len(places) else []
    pane = _vibrochain._branch_pane(STYLE["labels"][free], told, show, all)
    return pane, _vibrochain._caption(models)


def _hits(orbit: Orbit) -> tuple[list[float], float | None, float | None, float]:
    return [impact.impulse for impact in orbit.impacts], orbit.phi, orbit.psi, orbit.period


def curve_pane(
    values: NDArray[np.float64],
    physical: NDArray[np.bool_],
    special: Iterable[tuple[str, int]],
    labels: tuple[str, str],
    before: int = 0,
    touch: str = "",
) -> _Pane:
    """One curve of an event in the plane of two numbers, behind so many others."""
    named: dict[int, list[str]] = {}
    for name, place in special:
        named.setdefault(place, []).append(name)
    points = [(list(pair), bool(is_so), named.get(i, [])) for i, (pair, is_so) in enumerate(zip(values.tolist(), physical))]
    low, high = values.min(axis=0), values.max(axis=0)
    air = np.where(high > low, 0.03 * (high - low), 1e-6 + 0.03 * np.abs(low))
    others: list[list[Any]] = [[] for _ in range(before)]
    return _vibrochain._curve_pane(labels, (low - air).tolist(), (high + air).tolist(), [*others, points], [""] * before + [touch])


def curves_there(ax: Axes | None) -> int:
    """How many curves of events the axes show."""
    there = [] if ax is None else ax.get_legend_handles_labels()[1]
    return sum(label.startswith("curve ") for label in there)


class _Plots:
    """Methods of classes that are written in Rust, by the names of these."""

    class Orbit:
        @drawing
        def plot(self: Any, what: str = "motion", ax: Axes | None = None) -> Axes:
            """Draws the orbit, as ``mapgen orbit --plot`` does.

            Parameters
            ----------
            what : {"motion", "profile", "portrait", "multipliers"}
                What is hit over a period, between its barriers; all masses at the impacts; the phase portrait of the first mass that
                hits, impacts as jumps; the Floquet multipliers.
            {drawn}
            RequestError
                For another word.

            Examples
            --------
            >>> import vibrochain as vc
            >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
            >>> ax = model.breathers("double-sided").orbits[0].plot("portrait")  # doctest: +MATPLOTLIB
            >>> ax.get_xlabel(), ax.get_ylabel()  # doctest: +MATPLOTLIB
            ('displacement u₀', 'velocity of the impacting mass')
            """
            return draw(*_with(_vibrochain._orbit_pane(self, what), ax))

    class Branch:
        @drawing
        def plot(self: Any, show: str = "impulse", ax: Axes | None = None, *, all: bool = False) -> Axes:
            """Draws the branch, or all branches of the diagram, over what varies, as ``mapgen branch --plot`` does.

            Stable orbits are solid lines, unstable ones dashed; events are marked. Of a diagram there is a colour for each family.

            Parameters
            ----------
            show : {"impulse", "phi", "psi", "margin", "spectral_radius"}
                What stands along the vertical axis; impulses have a line each.
            {all}
            {drawn}
            RequestError
                For another word.

            Examples
            --------
            >>> import vibrochain as vc
            >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
            >>> diagram = vc.branch(model.breathers("single-sided").physical(), "amplitude", from_=0.15, to=0.17, generations=1)
            >>> ax = diagram.plot()  # doctest: +MATPLOTLIB
            >>> ax.get_xlabel(), ax.get_ylabel()  # doctest: +MATPLOTLIB
            ('force amplitude A', 'impulses |P|')
            >>> diagram.branches[0].plot("spectral_radius").get_ylabel()  # doctest: +MATPLOTLIB
            'largest |μ|, logarithmic'
            """
            return draw(*_with(branch_pane(self.branches if isinstance(self, Diagram) else [self], show, all), ax))

    Diagram = Branch

    class EventCurve:
        @drawing
        def plot(self: Any, ax: Axes | None = None) -> Axes:
            """Draws the curve in the plane of its two parameters, as ``mapgen curve --plot`` does.

            {curve}
            {drawn}

            Examples
            --------
            >>> import vibrochain as vc
            >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
            >>> point = vc.locate(model.breathers("single-sided").physical(), "period-doubling", "amplitude").points[0]
            >>> curve = vc.curve(point, "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3)
            >>> curve.plot().get_ylabel()  # doctest: +MATPLOTLIB
            'restitution e'
            """
            return draw(*_with(event_pane(self, curves_there(ax)), ax))

    class Borders:
        @drawing
        def plot(self: Any, ax: Axes | None = None, *, lines: bool = False) -> Axes:
            """Draws the regions of the window, each in the colour of what lives there, as ``mapgen curves --plot`` does.

            Parameters
            ----------
            lines : bool
                Whether to draw the borders over them, in a colour for each event.
            {drawn}

            Examples
            --------
            >>> import vibrochain as vc
            >>> found = vc.curves("scenes/conservative-n5.toml", places=2000)
            >>> ax = found.plot()  # doctest: +MATPLOTLIB
            >>> ax.get_legend().get_texts()[0].get_text()  # doctest: +MATPLOTLIB
            'no physical breather'
            """
            from matplotlib.patches import Patch, PathPatch
            from matplotlib.path import Path

            ax = axes_for(ax)
            names = [name for name in [*STYLE["classes"], "unknown"] if any(name == one for one, _, _ in self.regions)]
            colours = {name: class_colour(name) for name in names}
            for name, _, outlines in self.regions:
                # Outlines of holes run the other way round.
                path = Path.make_compound_path(*(Path(np.vstack([outline, outline[:1]]), closed=True) for outline in outlines))
                # Its own line closes the gap that smoothing leaves between neighbours.
                ax.add_patch(PathPatch(path, facecolor=colours[name], edgecolor=colours[name], linewidth=0.2))
            words = _vibrochain._class_words([name if name != "unknown" else "" for name in names])
            legend: list[Any] = [
                Patch(facecolor=colours[name], edgecolor="grey", label=word) for name, word in zip(names, words)
            ]
            if lines:
                events = list(dict.fromkeys(border.event for border in self.borders))
                # Colours of borders come behind those of lines.
                for event, rgb in zip(events, STYLE["lines"][-len(STYLE["lines"]) // 2 :]):
                    own = [border.values for border in self.borders if border.event == event]
                    parts = [ax.plot(*values.T, color=colour(rgb), linewidth=0.8)[0] for values in own]
                    parts[0].set_label(_vibrochain._in_words(event))
                    legend.append(parts[0])
            corners = np.vstack([outline for _, _, outlines in self.regions for outline in outlines])
            (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
            ax.set_xlim(left, right)
            ax.set_ylim(low, high)
            x, y = self.free
            ax.set_xlabel(STYLE["labels"][x])
            ax.set_ylabel(STYLE["labels"][y])
            heading, *notes = self.caption
            titled(ax, heading, ", ".join(note for note in notes if note))
            ax.legend(handles=legend, **BESIDE)
            return ax


def event_pane(curve: EventCurve, before: int = 0) -> tuple[_Pane, str]:
    """A curve of an event, with its caption."""
    x, y = (STYLE["labels"][name] for name in curve.free)
    special = [(name, place) for name, place, _ in curve.special]
    pane = curve_pane(curve.values, curve.physical, special, (x, y), before, curve.touch)
    ends = [curve.orbits[0], curve.orbits[-1]]
    orbit = ends[0]
    whose = orbit.word if orbit.family == "word" else orbit.family
    # What both parameters are is told by the axes, also where a curve is closed.
    symbols = [f"{STYLE['symbols'][name]} = " for name in curve.free]
    fixed = _vibrochain._caption([end.model for end in ends]).split(", ")
    caption = ", ".join(part for part in fixed if not part.startswith(tuple(symbols)))
    return pane, f"{_vibrochain._in_words(curve.event)} of {whose} breathers, {caption}"


def class_colour(name: str) -> str:
    """The colour of a class of maps; of one that is not known, another."""
    return colour(STYLE["classes"].get(name, STYLE["unknown"]))


def _with(made: tuple[_Pane, str], ax: Axes | None) -> tuple[_Pane, Axes | None, str]:
    pane, heading = made
    return pane, ax, heading


# What is drawn needs Python's packages, so these methods are written here.
for _kind in (Orbit, Branch, Diagram, EventCurve, Borders):
    setattr(_kind, "plot", getattr(_Plots, _kind.__name__).plot)
