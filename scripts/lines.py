#!/usr/bin/env python3
"""Counts lines of product code by crate: without tests, comments and blank lines.

    python3 scripts/lines.py
"""
import pathlib
import re

CRATES = ["lattice", "breather", "floquet", "eventsim", "maps", "fate", "plot", "explore", "cli", "python"]
root = pathlib.Path(__file__).resolve().parent.parent / "crates"
total = 0
for crate in CRATES:
    count = 0
    for path in sorted((root / crate / "src").rglob("*.rs")):
        if "tests" in path.relative_to(root).parts:
            continue
        text = re.split(r"^#\[cfg\(test\)\]\nmod \w+ \{", path.read_text(), maxsplit=1, flags=re.M)[0]
        lines = (line.strip() for line in text.splitlines())
        count += sum(bool(line) and not line.startswith("//") for line in lines)
    print(f"{crate:10} {count:6}")
    total += count
print(f"{'all':10} {total:6}")
