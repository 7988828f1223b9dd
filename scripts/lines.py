#!/usr/bin/env python3
"""Counts lines of product code by crate: without tests, comments and blank lines; or words of the documents by page.

    python3 scripts/lines.py
    python3 scripts/lines.py --words
"""
import pathlib
import re
import sys

CRATES = ["lattice", "breather", "floquet", "eventsim", "maps", "fate", "plot", "explore", "cli", "python"]
ROOT = pathlib.Path(__file__).resolve().parent.parent


def lines():
    total = 0
    for crate in CRATES:
        count = 0
        for path in sorted((ROOT / "crates" / crate / "src").rglob("*.rs")):
            if "tests" in path.relative_to(ROOT).with_suffix("").parts:
                continue
            text = re.split(r"^#\[cfg\(test\)\]\n(?:pub\(crate\) )?mod \w+ \{", path.read_text(), maxsplit=1, flags=re.M)[0]
            inner = (line.strip() for line in text.splitlines())
            count += sum(bool(line) and not line.startswith("//") for line in inner)
        print(f"{crate:10} {count:6}")
        total += count
    print(f"{'all':10} {total:6}")


def words():
    """A word is what stands between blanks and has a letter: numbers and the bars of tables are none."""
    total = in_tables = 0
    # The paper is about the project, for a journal: no page of its manual.
    pages = {*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")} - {ROOT / "paper.md"}
    for path in sorted(pages):
        counts = [0, 0]
        for line in path.read_text().splitlines():
            counts[line.lstrip().startswith("|")] += sum(any(letter.isalpha() for letter in word) for word in line.split())
        print(f"{str(path.relative_to(ROOT)):28} {sum(counts):6}" + (f", {counts[1]:5} of them in tables" if counts[1] else ""))
        total += sum(counts)
        in_tables += counts[1]
    print(f"{'all':28} {total:6}, {in_tables:5} of them in tables")


words() if "--words" in sys.argv else lines()
