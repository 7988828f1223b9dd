"""What scripts/mutants.sh does: draws mutants, compiles them behind switches, runs of each the tests that reach it."""
import concurrent.futures
import json
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

BEGAN = time.monotonic()
ROOT = pathlib.Path(__file__).resolve().parent.parent
SEED = int(sys.argv[1]) if len(sys.argv) > 1 else 1
COUNT = int(sys.argv[2]) if len(sys.argv) > 2 else 30
CRATES = sys.argv[3:] or ["lattice", "breather", "floquet", "eventsim", "fate", "maps"]
MINUTES = float(os.environ.get("MINUTES", 60))
# All that CI tests, in its one build.
ALL = ["--workspace", "--features", "vibrochain-cli/parquet"]
# Whose items all crates see.
LIBRARY = "crates/lattice/src/lib.rs"
SWITCH = """
/// Which fault is switched on: for `scripts/mutants.sh` alone. The first time that a program asks for one it says so in the file REACHED.
#[doc(hidden)]
pub fn fault(number: usize) -> bool {
    use std::sync::{LazyLock, atomic::{AtomicBool, Ordering::Relaxed}};
    static ON: LazyLock<usize> = LazyLock::new(|| std::env::var("FAULT").ok().and_then(|on| on.parse().ok()).unwrap_or(usize::MAX));
    static ASKED: [AtomicBool; COUNT] = [const { AtomicBool::new(false) }; COUNT];
    if !ASKED[number].load(Relaxed) && !ASKED[number].swap(true, Relaxed) && let Some(name) = std::env::var_os("REACHED") {
        let file = std::fs::OpenOptions::new().append(true).create(true).open(name);
        let _ = file.and_then(|mut file| std::io::Write::write_all(&mut file, format!("{number}\\n").as_bytes()));
    }
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
    # Each has its own lot: what is added or left out elsewhere changes no other one's.
    return sorted(mutants, key=lambda one: random.Random(f"{SEED} {one['name']}").random())[:COUNT]


def place(starts, at):
    """Of a line and a column, both from 1, the place in the text."""
    return starts[at["line"] - 1] + at["column"] - 1


def body(text, start, end):
    """Where a function's body begins and ends, within its braces; nothing of a constant one."""
    line = text.rfind("\n", 0, start) + 1
    head = re.compile(r"^[ \t]*(?:pub(?:\([^)]*\))? )?(?:unsafe )?fn \w+", re.M).search(text, line, end)
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
        told = "".join(pieces) + text[last:] + (SWITCH.replace("COUNT", str(len(mutants))) if name == LIBRARY else "")
        if (tree / name).read_text() != told:
            (tree / name).write_text(told)
    return blocks


def built(tree, words, command=("test", "--no-run")):
    """The test programs with the folders they run in, and the errors by file and line."""
    told = run(["cargo", command[0], "--locked", *command[1:], "--message-format", "json", *words], tree)
    programs, errors = [], []
    for line in told.stdout.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and message["executable"] and message["profile"]["test"]:
            programs.append((message["executable"], pathlib.Path(message["manifest_path"]).parent))
        elif message["reason"] == "compiler-message" and message["message"]["level"] == "error":
            errors += [(span["file_name"], span["line_start"], span["line_end"]) for span in message["message"]["spans"]]
    if told.returncode != 0 and not errors:
        sys.exit(told.stderr)
    return programs, errors


def listed(programs):
    """Of all programs each test that is not left for later: program, folder, name."""
    tests = []
    for program, folder in programs:
        names, ignored = (
            [line.removesuffix(": test") for line in run([program, "--list", "--format", "terse", *some], folder).stdout.splitlines()]
            for some in ([], ["--ignored"]))
        tests += [(program, folder, name) for name in names if name not in ignored]
    return tests


def took(test, limit=None, **more):
    """Whether a test passes, alone in its process, and in how many seconds; nothing where it takes longer than its limit."""
    program, folder, name = test
    began = time.monotonic()
    environment = {**os.environ, "CARGO_MANIFEST_DIR": str(folder), **more}
    process = subprocess.Popen([program, "--exact", name], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        passed = process.wait(limit) == 0
    except subprocess.TimeoutExpired:
        passed = None
    # With what the test has begun.
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()
    return passed, time.monotonic() - began


def reached(test, note):
    """Whether a test passes without a fault, its seconds, and the faults that it reaches."""
    note.unlink(missing_ok=True)
    passed, seconds = took(test, REACHED=str(note))
    return passed, seconds, {int(line) for line in note.read_text().split()} if note.exists() else set()


def notices(test, usual, fault):
    """Whether a test fails with a fault, twice, and passes without: what waits for a clock may fail on a busy machine."""
    limit = 20 + 10 * usual
    return all(took(test, limit, FAULT=str(fault))[0] is not True for _ in range(2)) and took(test, limit / 2)[0] is True


def tried(tests, fault):
    """By which test a fault is noticed, of those that reach it, the cheapest first; nothing where none does; False where time is over."""
    for seconds, test in tests:
        if time.monotonic() - BEGAN > 60 * MINUTES:
            return False
        if notices(test, seconds, fault):
            return test
    return None


def told(test):
    program, _, name = test
    return f"{pathlib.Path(program).name.rsplit('-', 1)[0]} {name}"


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
    checked(["git", "fetch", "--quiet", str(ROOT), head], tree)
    checked(["git", "checkout", "--quiet", "--force", "--detach", head], tree)
    examine(tree)


def compiled(tree, mutants):
    """The tests of the program with all faults behind switches, and the numbers of those that the compiler takes."""
    texts = {name: (tree / name).read_text() for name in {LIBRARY, *(one["file"] for one in mutants)}}
    dead, blocks, errors = set(), {}, [None]
    while errors:
        blocks = switched(tree, texts, mutants, dead)
        _, errors = built(tree, ["--lib", *ALL], ("check",))
        refused = {number for number, (name, first, last) in blocks.items()
                   for file, low, high in errors if file.endswith(name) and low <= last and high >= first}
        if errors and not refused:
            sys.exit(f"not compiled, for no fault: {errors[:3]}")
        dead |= refused
    programs, errors = built(tree, ALL)
    if errors:
        sys.exit(f"tests are not compiled: {errors[:3]}")
    return listed(programs), sorted(blocks)


def minutes():
    return f"{(time.monotonic() - BEGAN) / 60:.0f} minutes"


def examine(tree):
    mutants = drawn(tree)
    tests, numbers = compiled(tree, mutants)
    print(f"{len(numbers)} compiled, {len(tests)} tests, after {minutes()}", flush=True)
    # A fault may ask for all memory.
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, resource.getrlimit(resource.RLIMIT_AS)[1]))
    reaching = {number: [] for number in numbers}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool, tempfile.TemporaryDirectory() as notes:
        runs = pool.map(lambda i: reached(tests[i], pathlib.Path(notes) / str(i)), range(len(tests)))
        for test, (passed, seconds, faults) in zip(tests, runs):
            if not passed:
                print(f"fails without a fault, and counts for none: {told(test)}")
            for number in faults if passed else ():
                reaching[number].append((seconds, test))
        print(f"which test reaches which fault is known after {minutes()}", flush=True)
        caught, missed, left = 0, [], []
        for number, by in zip(numbers, pool.map(lambda number: tried(sorted(reaching[number]), number), numbers)):
            name, by_which = mutants[number]["name"], sorted(reaching[number])
            if by:
                caught += 1
                print(f"caught: {name}, by {told(by)}", flush=True)
            elif by is False:
                left.append(f"not tried: {name}")
            else:
                near = f"{len(by_which)} tests reach it, first {told(by_which[0][1])}" if by_which else "no test reaches it"
                missed.append(f"MISSED: {name}; {near}")
    print("\n".join(missed + left))
    print(f"drawn {len(mutants)}, refused by the compiler {len(mutants) - len(numbers)}, caught {caught}, "
          f"missed {len(missed)}, not tried {len(left)}; {minutes()}")
    sys.exit(0 if 10 * caught >= 9 * (caught + len(missed)) else 1)


if __name__ == "__main__":
    main()
