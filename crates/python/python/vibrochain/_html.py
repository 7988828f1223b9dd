"""What notebooks show of a value: a table of what it says, and a small picture, which needs no other package."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Any

import numpy as np

from . import _vibrochain
from ._errors import VibrochainError
from ._map import Map
from ._pictures import STYLE, branch_pane, class_colour, event_pane, orbit_panes
from ._run import Run
from ._structure import Structure
from ._structure_orbits import StructureBranch, StructureOrbit
from ._vibrochain import Branch, Diagram, EventCurve, Model, Orbit, _Pane

# Of larger chains an orbit's verdict takes more than a blink.
_MASSES = 300

# A picture has no room for more branches, points of a branch, events of a run, and cells along an axis.
_POINTS, _EVENTS, _VALUES = 3000, 20_000, 2000


def _page(title: str, rows: Iterable[tuple[str, Any]], svg: str = "") -> str:
    th, td = "<th style='text-align:left;white-space:nowrap'>", "<td style='text-align:left'>"
    cells = "".join(f"<tr>{th}{html.escape(name)}</th>{td}{html.escape(str(told))}</td></tr>" for name, told in rows)
    picture = f"<div style='background:white;display:inline-block;max-width:100%'>{svg}</div>" if svg else ""
    return f"<div><strong>{html.escape(title)}</strong><table>{cells}</table>{picture}</div>"


def _drawn(*panes: _Pane) -> str:
    return _vibrochain._svg(list(panes))


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.12g}"


def _orbit(orbit: Orbit) -> str:
    rows: list[tuple[str, Any]] = [("period", _number(orbit.period)), ("phi", _number(orbit.phi)), ("psi", _number(orbit.psi))]
    for impact in orbit.impacts[:8]:
        told = f"t = {impact.time:.9g}, impulse {impact.impulse:.9g}, velocity {impact.velocity_before:.9g} → {impact.velocity_after:.9g}"
        rows.append((f"site {impact.site}, {impact.barrier} barrier", told))
    name = orbit.word if orbit.family == "word" else orbit.family
    if orbit.model.chain.masses > _MASSES:
        return _page(f"{name} breather of {orbit.model.chain.masses} masses", rows)
    panes, caption = orbit_panes(orbit)
    return _page(caption, rows, _drawn(*panes))


def _model(model: Model) -> str:
    names = ["gamma1", "gamma2", "omega", "asymmetry", "amplitude", "restitution"]
    rows = [(STYLE["labels"][name], _number(getattr(model.chain if name.startswith("gamma") else model, name))) for name in names]
    if model.chain.layers > 1:
        rows.insert(2, (STYLE["labels"]["gamma3"], _number(model.chain.gamma3)))
    if model.chain.masses > _VALUES:
        return _page(_vibrochain._caption([model]), rows)
    frequencies = _vibrochain._frequencies(model)
    top = max(float(frequencies.max()), model.omega)
    modes = [("modes", 0, 0, "small", 0, [(float(k), value) for k, value in enumerate(frequencies.tolist())])]
    harmonics = [j * model.omega for j in range(1, min(int(1.05 * top / model.omega), 40) + 1)]
    pane = _Pane("", "mode (dashed: harmonics of ω)", "frequency", modes, levels=harmonics)
    return _page(_vibrochain._caption([model]), rows, _drawn(pane))


def _branches(branches: list[Branch], title: str) -> str:
    rows = []
    for number, branch in enumerate(branches[:12]):
        ends = " and ".join(dict.fromkeys(f"{end.reason} at {end.value:.9g}" for end in branch.ends))
        events = ", ".join(f"{event.event} at {event.value:.9g}" for event in branch.events if event.physical)
        rows.append((f"branch {number}", f"{branch.name}: {len(branch.points)} points, {ends}" + (f"; {events}" if events else "")))
    if not branches or sum(len(branch.points) for branch in branches) > _POINTS:
        return _page(title, rows)
    panes = [branch_pane(branches, show, False) for show in ("impulse", "spectral_radius")]
    return _page(f"{title}: {panes[0][1]}", rows, _drawn(*(pane for pane, _ in panes)))


def _event_curve(curve: EventCurve) -> str:
    pane, caption = event_pane(curve)
    rows = [("points", len(curve.orbits)), ("ends", " and ".join(curve.ends))]
    rows += [(name, " , ".join(_number(value) for value in curve.values[place])) for name, place, _ in curve.special[:12]]
    return _page(caption, rows, _drawn(pane))


def _map(table: Map) -> str:
    counts = [(name, f"{count} ({count / len(table):.1%})") for name, count in table.classes.items()]
    heading, fixed, _ = table._caption
    title = ", ".join(part for part in (heading, fixed) if part)
    codes, names, words = table._shown
    if len(table.dims) == 2 and max(table.shape) <= _VALUES:
        y, x = (table.coords[name] for name in table.dims)
        axes = [(name, table._labels[name], table.coords[name].tolist()) for name in table.dims[::-1]]
        if all((np.diff(values) > 0).all() for values in (x, y)):
            rgb = [STYLE["classes"].get(name, STYLE["unknown"]) for name in names]
            legend = [*zip(words, rgb), (_vibrochain._class_words([""])[0], STYLE["unknown"])]
            shown = np.where(codes < 0, len(words), codes).astype(np.int8).ravel()
            return _page(title, counts, _vibrochain._map_svg(heading, fixed, axes, shown, legend))
    if len(table.dims) == 1 and len(table) <= _VALUES:
        [dim] = table.dims
        place = table.coords[dim].tolist()
        series = []
        for code, (name, word) in enumerate(zip(names, words)):
            values = np.where(codes == code, table["margin"], np.nan).tolist()
            if name != "none":
                series.append((word, _line(name), -2 if name.startswith("un") else 2, "", 0, list(zip(place, values))))
        return _page(title, counts, _drawn(_Pane("", table._labels[dim], "smallest distance to a barrier", series)))
    return _page(title, counts)


def _line(name: str) -> int:
    """The colour of lines that a class' family has."""
    own = STYLE["classes"][name.removeprefix("un")]
    return int(STYLE["lines"].index(own))


def _run(run: Run) -> str:
    rows = [("end", _number(run.end)), ("impacts", run.impacts), ("samples", len(run.times)), ("complete", "yes" if run.complete else "no")]
    title = f"{run._whose()}: {_vibrochain._caption([run._model()])}"
    return _page(title, rows, _drawn(run._pane(None)) if len(run.times) <= _EVENTS else "")


def _structure(structure: Structure) -> str:
    rows = []
    for number, contact in enumerate(structure._contacts):
        where = next((f"{key} {contact[key]}" for key in ("at", "between") if key in contact), "by weights")
        walls = ", ".join(f"{key} {contact[key]:g}" for key in ("lower", "upper") if key in contact)
        rows.append((f"contact {number}", f"{where}: {walls}, e = {contact['restitution']:g}"))
    frequencies = _vibrochain._structure_frequencies(structure._scene(1.0))
    rows.append(("frequencies", ", ".join(f"{value:.6g}" for value in frequencies[:6]) + (", …" if len(frequencies) > 6 else "")))
    modes = list(enumerate(frequencies[:_VALUES]))
    pane = _Pane("", "mode that swings", "frequency", [("", 0, 0, "small", 0, modes)])
    return _page(repr(structure), rows, _drawn(pane) if modes else "")


def _structure_orbit(orbit: StructureOrbit) -> str:
    (motion, caption), (portrait, _) = (orbit._pane(what) for what in ("motion", "portrait"))
    rows: list[tuple[str, Any]] = [("period", _number(orbit.period)), ("margin", _number(orbit.margin))]
    for hit in orbit.impacts[:8]:
        told = f"t = {hit['time']:.9g}, impulse {hit['impulse']:.9g}, velocity {hit['velocity_before']:.9g} → {hit['velocity_after']:.9g}"
        rows.append((f"contact {hit['contact']}, {hit['barrier']} barrier", told))
    return _page(caption, rows, _drawn(motion, portrait))


def _structure_branch(branch: StructureBranch) -> str:
    rows = [(found["event"], f"{branch.free} = {found['value']:.9g}") for found in branch.events if found["physical"]][:12]
    rows += [("end", f"{branch.free} = {value:.9g}, {name}") for value, name in branch.ends]
    panes = [branch._pane(show, False) for show in ("impulse", "spectral_radius")]
    return _page(panes[0][1], rows, _drawn(*(pane for pane, _ in panes)))


def _safe(shown: Any) -> Any:
    """A picture that cannot be drawn is no reason to show nothing: notebooks fall back on the repr."""

    def _repr_html_(self: Any) -> str | None:
        try:
            return str(shown(self))
        except VibrochainError:
            return None

    return _repr_html_


for _kind, _shown in {
    Orbit: _orbit,
    Model: _model,
    Branch: lambda branch: _branches([branch], f"Branch in {branch.free}"),
    Diagram: lambda diagram: _branches(diagram.branches, f"Diagram in {diagram.free}"),
    EventCurve: _event_curve,
    Map: _map,
    Run: _run,
    Structure: _structure,
    StructureOrbit: _structure_orbit,
    StructureBranch: _structure_branch,
}.items():
    setattr(_kind, "_repr_html_", _safe(_shown))
