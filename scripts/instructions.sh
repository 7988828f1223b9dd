#!/usr/bin/env bash
# Counts the instructions of the inner loops (`studies loop`), which no other load of the machine changes, and holds them against those
# kept in scripts/instructions.txt: more than 3 % beyond is a failure.
#
#   scripts/instructions.sh            compare
#   scripts/instructions.sh --renew    keep what is counted now, for a change that is worth its price or makes a loop cheaper
#
# Needs valgrind, and says so where it is missing: exit code 3, nothing was compared. Figures belong to a compiler, which the file names.
set -euo pipefail
cd "$(dirname "$0")/.."

loops=(conservative-cells structure-cells forced-cells damped-cells table-rows simulated-breather hot-ring)
kept=scripts/instructions.txt
most=3

case "${1-}" in
"" | --renew) ;;
*)
    echo "usage: scripts/instructions.sh [--renew]" >&2
    exit 2
    ;;
esac

if ! command -v valgrind >/dev/null; then
    echo "instructions of inner loops: NOT COUNTED, valgrind is missing (apt-get install valgrind)" >&2
    exit 3
fi

# As .ci/run builds it: with the features of the README's command.
cargo build --locked --release --quiet --workspace --exclude vibrochain-python --bin studies
program=${CARGO_TARGET_DIR:-target}/release/studies
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What is counted is between entering and leaving one function of the program.
count() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='*loops*measured*' \
        "$program" loop "$1" >"$work/out" 2>"$work/log" || { cat "$work/log" >&2; return 1; }
    local found
    found=$(sed -n 's/^==[0-9]*== Collected : //p' "$work/log")
    # Nothing collected is no count: the function has another name, say.
    if [ -z "$found" ] || [ "$found" -eq 0 ]; then
        cat "$work/log" >&2
        return 1
    fi
    echo "$found"
}

{
    echo "# Instructions of \`studies loop NAME\`, made by scripts/instructions.sh --renew, $(rustc --version | cut -d' ' -f1,2)"
    for name in "${loops[@]}"; do
        found=$(count "$name")
        echo "$name $found"
    done
} >"$work/counted"

if [ "${1-}" = --renew ]; then
    cp "$work/counted" "$kept"
    cat "$kept"
    exit
fi

awk -v most="$most" '
    FNR == 1 { compiler[++files] = $NF; next }
    files == 1 { before[$1] = $2; next }
    {
        compared++
        if (!($1 in before)) { printf "%s: not in the file\n", $1; failed = 1; next }
        change = 100 * ($2 / before[$1] - 1)
        printf "%-20s %12d instructions, %+.2f %%\n", $1, $2, change
        if (change > most) { printf "%s: more than %d %% beyond\n", $1, most; failed = 1 }
        if (change < -most) better = 1
    }
    END {
        if (compiler[1] != compiler[2]) printf "the file is of compiler %s, this is %s\n", compiler[1], compiler[2]
        if (better) print "a loop has become cheaper: keep that with scripts/instructions.sh --renew"
        if (compared == 0) failed = 1
        exit failed
    }' "$kept" "$work/counted"
