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
# Crates that see one another, from below: a fault is noticed in its own crate or above.
FROM_BELOW = ["lattice", "breather", "eventsim", "floquet", "fate", "maps"]
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


def checked(words, folder):
    told = run(words, folder)
    if told.returncode != 0:
        sys.exit(told.stderr)
    return told.stdout


def drawn(tree):
    """The sample, from all that cargo-mutants would do and .cargo/mutants.toml does not name."""
    mutants = []
    for crate in CRATES:
        mutants += json.loads(checked(["cargo", "mutants", "--list", "--json", "-p", f"vibrochain-{crate}"], tree))
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


def switched(tree, texts, mutants, dead):
    """Writes the files with all faults but dead ones behind switches; of each fault the file and its lines."""
    files = {}
    for number, one in enumerate(mutants):
        if number not in dead:
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
        told = "".join(pieces) + text[last:] + (SWITCH if name == LIBRARY else "")
        if (tree / name).read_text() != told:
            (tree / name).write_text(told)
    return blocks


def built(tree, words, command=("test", "--no-run")):
    """The test programs with the folders they run in, and the errors by file and line."""
    told = run(["cargo", command[0], "--locked", *command[1:], "--message-format", "json", *words], tree)
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


def took(words, folder, fault, limit):
    """Whether a program ends well, and how long that takes; nothing where it takes too long."""
    began = time.monotonic()
    environment = {**os.environ, "CARGO_MANIFEST_DIR": folder}
    environment.update({} if fault is None else {"FAULT": str(fault)})
    try:
        passed = run(words, folder, env=environment, timeout=limit).returncode == 0
    except subprocess.TimeoutExpired:
        return None
    return passed, time.monotonic() - began


def is_caught(programs, fault, limits):
    """By which program a fault is noticed; one that takes far longer than usual is, too."""
    for program, folder, *some in programs:
        name, words = pathlib.Path(program).name, [program, "--quiet", *some[1:]]
        told = took(words, folder, fault, limits.get(program))
        while told is None:
            # Where the program is as slow without the fault, the machine is busy.
            _, usual = took(words, folder, None, None)
            if 3 * usual < limits[program]:
                return name + " (too long)"
            limits[program] = 10 * usual
            told = took(words, folder, fault, limits[program])
        passed, seconds = told
        if not passed:
            return name
        if fault is None:
            limits[program] = 20 + 5 * seconds
    return None


def above(programs, crate):
    """Of test programs those of a crate and of what sees it, its own first."""
    seen = FROM_BELOW[FROM_BELOW.index(crate):]
    of = [next((name for name in seen if program[1].endswith("/" + name)), None) for program in programs]
    return [program for name in seen for program, own in zip(programs, of) if own == name]


def main():
    # Apart from what is compiled without faults: cargo takes the same files of another tree for its own. What has not changed since a run
    # before is not compiled again.
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "mutants"
    tree = target / "tree"
    os.environ["CARGO_TARGET_DIR"] = str(target)
    target.mkdir(parents=True, exist_ok=True)
    if not (tree / ".git").exists():
        checked(["git", "clone", "--quiet", "--shared", "--no-checkout", str(ROOT), str(tree)], ROOT)
    head = checked(["git", "rev-parse", "HEAD"], ROOT).strip()
    checked(["git", "fetch", "--quiet", "origin", head], tree)
    checked(["git", "checkout", "--quiet", "--force", "--detach", head], tree)
    examine(tree)


def examine(tree):
    mutants = drawn(tree)
    texts = {name: (tree / name).read_text() for name in {LIBRARY, *(one["file"] for one in mutants)}}
    # The same ones for all tests: others would have other features, and be compiled twice.
    packages = ["-p", "vibrochain", *(word for crate in FROM_BELOW for word in ["-p", f"vibrochain-{crate}"])]
    dead, blocks, errors = set(), {}, [None]
    # What the compiler refuses is no fault; that is known before anything is compiled.
    while errors:
        blocks = switched(tree, texts, mutants, dead)
        _, errors = built(tree, ["--lib", *packages], ("check",))
        refused = {number for number, (name, first, last) in blocks.items()
                   for file, low, high in errors if file.endswith(name) and low <= last and high >= first}
        if errors and not refused:
            sys.exit(f"not compiled, for no fault: {errors[:3]}")
        dead |= refused
    tried = sorted(blocks)
    units, errors = built(tree, ["--lib", *packages])
    if errors:
        sys.exit(f"tests are not compiled: {errors[:3]}")
    print(f"{len(tried)} compiled, after {(time.monotonic() - BEGAN) / 60:.0f} minutes", flush=True)
    limits, caught, open_ones, left = {}, {}, [], []
    failed = is_caught(units, None, limits)
    if failed:
        sys.exit(f"{failed} fails without a fault")
    for number in tried:
        if time.monotonic() - BEGAN > 60 * MINUTES * 0.8:
            left.append(number)
            continue
        crate = mutants[number]["file"].split("/")[1]
        # The file's own tests first, then its crate's.
        own = above(units, crate)
        if module(mutants[number]["file"]):
            own.insert(0, (*own[0], module(mutants[number]["file"]) + "::"))
        by = is_caught(own, number, limits)
        caught.update({number: by} if by else {})
        open_ones += [] if by else [number]
        print(f"{'caught' if by else 'open'}: {mutants[number]['name']}{', by ' + by if by else ''}", flush=True)
    if open_ones and os.environ.get("UNITS") is None:
        # Tests of what has faults or sees it.
        lowest = min(FROM_BELOW.index(mutants[number]["file"].split("/")[1]) for number in open_ones)
        folders = [tree / "crates" / crate / "tests" for crate in FROM_BELOW[lowest:]]
        names = {path.stem for folder in folders for path in folder.glob("*.rs")}
        names |= {path.parent.name for folder in folders for path in folder.glob("*/main.rs")} | set(WHOLE)
        programs, errors = built(tree, [word for name in sorted(names) for word in ["--test", name]] + packages)
        wholes = [one for one in programs if one[1] == str(tree)]
        inner = [one for one in programs if one[1] != str(tree)]
        failed = is_caught(inner + wholes, None, limits)
        if errors or failed:
            sys.exit(f"tests of the whole do not pass without a fault: {errors[:3] or failed}")
        for number in list(open_ones):
            if time.monotonic() - BEGAN > 60 * MINUTES:
                open_ones.remove(number)
                left.append(number)
                continue
            crate = mutants[number]["file"].split("/")[1]
            by = is_caught(above(inner, crate) + wholes, number, limits)
            if by:
                caught[number] = by
                open_ones.remove(number)
                print(f"caught: {mutants[number]['name']}, by {by}", flush=True)
    for number in open_ones:
        print(f"MISSED: {mutants[number]['name']}")
    for number in left:
        print(f"not tried: {mutants[number]['name']}")
    count = len(caught) + len(open_ones)
    minutes = (time.monotonic() - BEGAN) / 60
    print(f"drawn {len(mutants)}, refused by the compiler {len(mutants) - len(tried)}, caught {len(caught)}, "
          f"missed {len(open_ones)}, not tried {len(left)}; {minutes:.0f} minutes")
    sys.exit(0 if 10 * len(caught) >= 9 * count else 1)


main()
