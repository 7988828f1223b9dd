"""What scripts/mutants.sh does: draws mutants, compiles them behind switches, runs tests with one after the other."""
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import time

BEGAN = time.monotonic()
ROOT = pathlib.Path(__file__).resolve().parent.parent
SEED = int(sys.argv[1]) if len(sys.argv) > 1 else 1
COUNT = int(sys.argv[2]) if len(sys.argv) > 2 else 100
CRATES = sys.argv[3:] or ["lattice", "breather", "floquet", "eventsim", "fate", "maps"]
MINUTES = float(os.environ.get("MINUTES", 30))
# Tests of the whole that meet what a crate's own tests may not: of each crate its own run first.
WHOLE = ["values", "secular", "reference", "structure_orbits", "structure_attractors", "simulation", "maps"]
# Whose items all crates see.
LIBRARY = "crates/lattice/src/lib.rs"
SWITCH = """
/// Which fault is switched on: for `scripts/mutants.sh` alone.
#[doc(hidden)]
pub fn fault(number: usize) -> bool {
    static ON: std::sync::LazyLock<usize> =
        std::sync::LazyLock::new(|| std::env::var("FAULT").ok().and_then(|on| on.parse().ok()).unwrap_or(usize::MAX));
    *ON == number
}
"""


def run(words, folder, **more):
    return subprocess.run(words, cwd=folder, text=True, capture_output=True, **more)


def drawn(tree):
    """The sample, from all that cargo-mutants would do and .cargo/mutants.toml does not name."""
    mutants = []
    for crate in CRATES:
        listed = run(["cargo", "mutants", "--list", "--json", "-p", f"vibrochain-{crate}"], tree)
        if listed.returncode != 0:
            sys.exit(listed.stderr)
        mutants += json.loads(listed.stdout)
    # Two values of one opaque type cannot stand behind a switch, nor can what is worked out by the compiler.
    mutants = [one for one in mutants if one["function"] and "impl " not in one["function"]["return_type"]]
    print(f"{len(mutants)} faults; seed {SEED} draws {COUNT}")
    return random.Random(SEED).sample(mutants, min(COUNT, len(mutants)))


def place(starts, at):
    """Of a line and a column, both from 1, the place in the text."""
    return starts[at["line"] - 1] + at["column"] - 1


def body(text, start, end):
    """Where a function's body begins and ends, within its braces; nothing of a constant one."""
    head = re.compile(r"^[ \t]*(?:pub(?:\([^)]*\))? )?(?:unsafe )?fn \w+", re.M).search(text, start, end)
    if not head:
        return None
    at, depth = head.end(), 0
    while text[at] != "{" or depth > 0:
        # The arrow of a result closes nothing.
        if text[at] in "(<[" or (text[at] == "{"):
            depth += 1
        elif text[at] in ")]" or (text[at] == ">" and text[at - 1] != "-") or text[at] == "}":
            depth -= 1
        at += 1
    return at + 1, text.rindex("}", at, end)


def switched(tree, texts, mutants):
    """Writes the files with all faults behind switches; of each fault the file and its lines."""
    files = {}
    for number, one in enumerate(mutants):
        files.setdefault(one["file"], []).append((number, one))
    blocks = {}
    for name, text in texts.items():
        faults = files.get(name, [])
        starts = [0] + [match.end() for match in re.finditer("\n", text)]
        functions = {}
        for number, one in faults:
            span = one["function"]["span"]
            whole = body(text, place(starts, span["start"]), place(starts, span["end"]))
            if whole:
                functions.setdefault(whole, []).append((number, one))
        pieces, last = [], 0
        for (start, end), own in sorted(functions.items()):
            if start < last:
                continue
            pieces.append(text[last:start])
            for number, one in own:
                at, to = (place(starts, one["span"][which]) for which in ["start", "end"])
                before = "".join(pieces).count("\n") + 1
                path = "crate" if name.startswith("crates/lattice/") else "vibrochain_lattice"
                block = f"if {path}::fault({number}) {{{text[start:at]}{one['replacement']}{text[to:end]}}} else "
                pieces.append(block)
                blocks[number] = (name, before, before + block.count("\n"))
            pieces.append(f"{{{text[start:end]}}}")
            last = end
        (tree / name).write_text("".join(pieces) + text[last:])
    library = tree / LIBRARY
    library.write_text(library.read_text() + SWITCH)
    return blocks


def built(tree, words):
    """The test programs with the folders they run in, and the errors by file and line."""
    told = run(["cargo", "test", "--locked", "--no-run", "--message-format", "json", *words], tree)
    programs, errors = [], []
    for line in told.stdout.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and message["executable"]:
            package = pathlib.Path(message["manifest_path"]).parent
            programs.append((message["executable"], str(package), message["target"]["kind"][0]))
        elif message["reason"] == "compiler-message" and message["message"]["level"] == "error":
            errors += [(span["file_name"], span["line_start"], span["line_end"]) for span in message["message"]["spans"]]
    if told.returncode != 0 and not errors:
        sys.exit(told.stderr)
    return programs, errors


def module(name):
    """The path of a file's module, by which its own tests are picked; of the crate's root nothing."""
    names = pathlib.Path(name).with_suffix("").parts[3:]
    return "::".join(names[:-1] if names[-1] in ("mod", "lib") else names)


def is_caught(programs, fault, limits):
    """By which program a fault is noticed; one that takes far longer than usual is, too."""
    for program, folder, *some in programs:
        began = time.monotonic()
        environment = {**os.environ, "CARGO_MANIFEST_DIR": folder}
        environment.update({} if fault is None else {"FAULT": str(fault)})
        try:
            words = [program, "--quiet", *some[1:]]
            if run(words, folder, env=environment, timeout=limits.get(program)).returncode != 0:
                return pathlib.Path(program).name
        except subprocess.TimeoutExpired:
            return pathlib.Path(program).name + " (too long)"
        if fault is None:
            limits[program] = 20 + 5 * (time.monotonic() - began)
    return None


def main():
    # Apart from what is compiled without faults: cargo takes the same files of another tree for its own.
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "mutants"
    tree = target / "tree"
    os.environ["CARGO_TARGET_DIR"] = str(target)
    run(["git", "worktree", "remove", "--force", str(tree)], ROOT)
    added = run(["git", "worktree", "add", "--detach", str(tree), "HEAD"], ROOT)
    if added.returncode != 0:
        sys.exit(added.stderr)
    try:
        examine(tree)
    finally:
        run(["git", "worktree", "remove", "--force", str(tree)], ROOT)


def examine(tree):
    mutants = drawn(tree)
    texts = {name: (tree / name).read_text() for name in {LIBRARY, *(one["file"] for one in mutants)}}
    packages = [word for crate in CRATES for word in ["-p", f"vibrochain-{crate}"]]
    dead = set()
    # What the compiler refuses is no fault.
    while True:
        # Numbers of the list that is compiled.
        order = [number for number in range(len(mutants)) if number not in dead]
        blocks = switched(tree, texts, [mutants[number] for number in order])
        units, errors = built(tree, ["--lib", *packages])
        if not errors:
            break
        refused = {order[place] for place, (name, first, last) in blocks.items()
                   for file, low, high in errors if file.endswith(name) and low <= last and high >= first}
        if not refused:
            sys.exit(f"not compiled, for no fault: {errors[:3]}")
        dead |= refused
    dead |= {number for place, number in enumerate(order) if place not in blocks}
    tried = [(place, number) for place, number in enumerate(order) if place in blocks]
    print(f"{len(tried)} compiled, after {(time.monotonic() - BEGAN) / 60:.0f} minutes", flush=True)
    limits, caught, open_ones, left = {}, {}, [], []
    failed = is_caught(units, None, limits)
    if failed:
        sys.exit(f"{failed} fails without a fault")
    for place, number in tried:
        if time.monotonic() - BEGAN > 60 * MINUTES * 0.8:
            left.append(number)
            continue
        crate = mutants[number]["file"].split("/")[1]
        # The file's own tests first, then its crate's.
        own = sorted(units, key=lambda unit: not unit[1].endswith("/" + crate))
        if module(mutants[number]["file"]):
            own.insert(0, (*own[0], module(mutants[number]["file"]) + "::"))
        by = is_caught(own, place, limits)
        caught.update({number: by} if by else {})
        open_ones += [] if by else [(place, number)]
        print(f"{'caught' if by else 'open'}: {mutants[number]['name']}{', by ' + by if by else ''}", flush=True)
    if open_ones and os.environ.get("UNITS") is None:
        whole = [word for name in WHOLE for word in ["--test", name]]
        wholes, errors = built(tree, ["-p", "vibrochain", *whole])
        inner, _ = built(tree, ["--tests", *packages])
        inner = [one for one in inner if one[2] == "test"]
        failed = is_caught(inner + wholes, None, limits)
        if errors or failed:
            sys.exit(f"tests of the whole do not pass without a fault: {errors[:3] or failed}")
        for place, number in list(open_ones):
            if time.monotonic() - BEGAN > 60 * MINUTES:
                break
            crate = mutants[number]["file"].split("/")[1]
            own = sorted(inner, key=lambda unit: not unit[1].endswith("/" + crate)) + wholes
            by = is_caught(own, place, limits)
            if by:
                caught[number] = by
                open_ones.remove((place, number))
                print(f"caught: {mutants[number]['name']}, by {by}", flush=True)
    for _, number in open_ones:
        print(f"MISSED: {mutants[number]['name']}")
    for number in left:
        print(f"not tried: {mutants[number]['name']}")
    count = len(caught) + len(open_ones)
    minutes = (time.monotonic() - BEGAN) / 60
    print(f"drawn {len(mutants)}, refused by the compiler {len(mutants) - len(tried)}, caught {len(caught)}, "
          f"missed {len(open_ones)}, not tried {len(left)}; {minutes:.0f} minutes")
    sys.exit(0 if 10 * len(caught) >= 9 * count else 1)


main()
