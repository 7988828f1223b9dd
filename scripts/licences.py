"""Prints the licences of every crate that mapgen is linked with, and that of its font: a text once, however many crates have it.

    python3 scripts/licences.py
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def cargo(*arguments):
    done = subprocess.run(["cargo", *arguments, "--locked", "--offline"], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout


metadata = json.loads(cargo("metadata", "--format-version=1"))
packages = {(package["name"], package["version"]): package for package in metadata["packages"]}
# Crates that only build others are not in the program.
tree = cargo("tree", "--package=vibrochain-cli", "--edges=normal,no-proc-macro", "--prefix=none", "--format={p}")
linked = sorted({tuple(line.split()[:2]) for line in tree.splitlines() if line})

texts, without = {}, []
for name, version in linked:
    package = packages[name, version.removeprefix("v")]
    if package["source"] is None:
        continue
    folder = pathlib.Path(package["manifest_path"]).parent
    words = ("LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE")
    files = [file for file in sorted(folder.iterdir()) if file.name.upper().startswith(words) and file.is_file()]
    # A library in C has its own folder.
    files += sorted(folder.glob("*/LICENSE*"))
    crate = f"{name} {version} ({package['license'] or 'see its text'})"
    if not files:
        without.append(f"{crate}, by {', '.join(package['authors']) or 'its authors'}")
    for file in files:
        texts.setdefault(file.read_text(errors="replace").strip(), []).append(crate)
font = ROOT / "crates/plot/assets/DejaVuSans-LICENSE.txt"
texts.setdefault(font.read_text().strip(), []).append("the font DejaVu Sans, of pictures")

if len(linked) < 50 or len(texts) < 20:
    sys.exit(f"only {len(linked)} crates and {len(texts)} texts were found")
print("mapgen is linked with what follows, each under its own licence.\n\nWithout a text of their own:")
print("\n".join(without))
for text, crates in texts.items():
    print(f"\n{'=' * 80}\n" + "\n".join(sorted(set(crates))) + f"\n{'-' * 80}\n{text}")
