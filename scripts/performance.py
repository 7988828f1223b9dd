#!/usr/bin/env python3
"""Makes the figures of docs/performance.md anew, on a machine that does nothing else.

    python3 scripts/performance.py          run the benches, count what is counted, write the document
    python3 scripts/performance.py --kept   write it from what the last run of the benches left in the target folder

Runs the benches map_throughput, simulation, spectrum (criterion) and chunks, and scripts/peers/conservative_map.py, which needs NumPy
(a part without a figure says so); takes instructions from scripts/instructions.txt. Each part of the document stands between two lines
`<!-- figures NAME -->` and `<!-- end -->`; all else is left as it is.
"""

import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
KEPT = TARGET / "performance"
DOCUMENT = ROOT / "docs" / "performance.md"
# Criterion's own seconds would make it half an hour.
SHORT = ["--warm-up-time", "1", "--measurement-time", "3"]
SIZES = [5, 10, 20, 40]
MASSES = [1001, 10001, 100001]
MISSING = "not measured"


def run(*command):
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def times():
    """Nanoseconds by the name of the bench; of an element where it has told how many there are."""
    found = {}
    for file in (TARGET / "criterion").rglob("new/benchmark.json"):
        bench = json.loads(file.read_text())
        median = json.loads(file.with_name("estimates.json").read_text())["median"]["point_estimate"]
        elements = (bench.get("throughput") or {}).get("Elements", 1)
        found[bench["full_id"]] = median / elements
    return found


def time(ns):
    """To two digits."""
    if ns is None:
        return MISSING
    unit, size = next(((unit, size) for unit, size in [("s", 1e9), ("ms", 1e6)] if ns >= size), ("µs", 1e3))
    text = f"{ns / size:.2g}"
    return f"{float(text):.0f} {unit}" if "e" in text else f"{text} {unit}"


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def cells(found):
    def cell(model, n, work, threads):
        return time(found.get(f"map/{model}/N={n}/{work}/threads={threads}"))

    head = ["N", "conservative: existence", "with stability", "on two threads", "floor", "forced: existence", "with stability", "on two threads"]
    rows = []
    for n in SIZES:
        row = [n]
        for model in ["conservative", "forced"]:
            row += [cell(model, n, "existence", 1), cell(model, n, "stability", 1), cell(model, n, "stability", 2)]
            row += [time(found.get(f"floor/N={n}"))] if model == "conservative" else []
        rows.append(row)
    return table(head, rows)


def simulation(found):
    sizes = [21, 100, 1000, 10000]
    rows = [[n, *(time(found.get(f"simulation/period/{kind}/{n}")) for kind in ["breather", "hot"])] for n in sizes]
    return table(["masses", "breather", "hot ring"], rows)


def spectra(found):
    sizes = [20, 40]
    rows = []
    for group, kinds, works in [
        ("conservative", {"single": "single-sided", "double": "double-sided"}, ["residues", "verdict", "all roots", "dense verdict"]),
        ("forced", {"n=1": "one impact", "n=2": "two impacts"}, ["verdict", "all multipliers", "dense verdict"]),
    ]:
        for kind, words in kinds.items():
            for work in works:
                values = [found.get(f"{group}/{work}/{kind}/N={n}") for n in sizes]
                if any(values):
                    rows.append([f"{group}, {words}: {work}", *map(time, values)])
    return table(["one orbit", *(f"N = {n}" for n in sizes)], rows)


def large(found):
    names = sorted({tuple(name.split("/")[1:3]) for name in found if name.startswith("large/")})
    rows = [[f"{work}, {kind}", *(time(found.get(f"large/{work}/{kind}/{n} sites")) for n in MASSES)] for work, kind in names]
    return table(["", *(f"{n} masses" for n in MASSES)], rows)


def instructions():
    units = {
        "conservative-cells": (960, "a cell of the conservative map, both families, with stability"),
        "structure-cells": (960, "a cell of the conservative map of the same ring as a structure"),
        "forced-cells": (960, "a cell of the forced map, all solutions"),
        "table-rows": (960, "a row of the table as text"),
        "simulated-breather": (200, "a period of a simulated breather, all masses watched"),
        "hot-ring": (20, "a period of a ring of 21 masses that all hit"),
    }
    lines = (ROOT / "scripts" / "instructions.txt").read_text().splitlines()
    counted = dict(line.split() for line in lines if not line.startswith("#"))
    rows = [[words, f"{int(counted[name]) / count:.0f}"] for name, (count, words) in units.items()]
    return f"{lines[0].split(', ')[-1]}:\n\n" + table(["loop", "instructions"], rows)


def machine():
    model = "a processor without a name"
    info = pathlib.Path("/proc/cpuinfo")
    if info.exists() and (line := re.search(r"model name\s*:\s*(.*)", info.read_text())):
        model = line[1]
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    commit = run("git", "describe", "--always", "--dirty").strip()
    load = os.getloadavg()[0]
    compiler = run("rustc", "--version").split(" (")[0]
    date = run("date", "+%Y-%m-%d").strip()
    place = f"{os.cpu_count()} cores of an {model}, {platform.system()}"
    return f"Version {version} ({commit}), {compiler}, {date}; {place}; load before the first bench {load:.1f}."


def kept(name, make):
    """What `make` tells, or what it told last."""
    file = KEPT / name
    if "--kept" not in sys.argv:
        KEPT.mkdir(parents=True, exist_ok=True)
        try:
            file.write_text(make())
        except (OSError, subprocess.CalledProcessError) as error:
            file.write_text(f"{MISSING}: {error}")
    return file.read_text().rstrip() if file.exists() else MISSING


def main():
    if wrong := [word for word in sys.argv[1:] if word != "--kept"]:
        sys.exit(f"{wrong[0]}: not known\n{__doc__}")
    stamp = kept("machine", machine)
    if "--kept" not in sys.argv:
        for bench in ["map_throughput", "simulation", "spectrum"]:
            subprocess.run(["cargo", "bench", "--locked", "--bench", bench, "--", *SHORT], cwd=ROOT, check=True)
        run("cargo", "build", "--locked", "--release")
    found = times()
    code = "```text\n{}\n```".format
    parts = {
        "machine": stamp,
        "cells": cells(found),
        "simulation": simulation(found),
        "spectra": spectra(found),
        "large": large(found),
        "instructions": instructions(),
        "chunks": code(kept("chunks", lambda: run("cargo", "bench", "--locked", "--bench", "chunks"))),
        "peers": code(kept("peers", lambda: run(sys.executable, "scripts/peers/conservative_map.py", "scenes/conservative-n20.toml"))),
    }
    text = DOCUMENT.read_text()
    for name, part in parts.items():
        pattern = re.compile(rf"(<!-- figures {name} -->\n).*?(\n<!-- end -->)", re.S)
        text, count = pattern.subn(lambda match, part=part: match[1] + "\n" + part + "\n" + match[2], text)
        if count != 1:
            sys.exit(f"{DOCUMENT.name}: {count} places for the figures {name!r} where there is to be one")
    DOCUMENT.write_text(text)
    print(f"{DOCUMENT.relative_to(ROOT)}: {len(found)} benches, {text.count(MISSING)} figures not measured")


main()
