#!/usr/bin/env bash
# What is paid for what, as Markdown. Usage: scripts/lean.sh > docs/accuracy/lean.md
#
# Each crate used alone: crates compiled (its own and procedural macros included), size of its library and of the program,
# both as `cargo build --locked --release` leaves them. Each kind of map: time and allocations a cell (`cargo bench --locked --bench lean`).
set -euo pipefail
cd "$(dirname "$0")/.."

# Size of a file in KiB, or MiB from 10 MiB on.
size() {
    awk -v bytes="$(wc -c < "$1")" 'BEGIN {
        if (bytes < 10485760) printf "%.0f KiB", bytes / 1024; else printf "%.1f MiB", bytes / 1048576
    }'
}

# One line: name in the table, package, flags of cargo.
row() {
    local name=$1 package=$2
    shift 2
    local crates library program="–"
    # A crate met again is marked (*): the same crate.
    crates=$(cargo tree -p "$package" "$@" -e normal --prefix none | sed 's/ (\*)$//' | sort -u | wc -l)
    cargo build --locked --release --quiet -p "$package" "$@"
    library=$(size "${CARGO_TARGET_DIR:-target}/release/lib${package//-/_}.rlib")
    if [ "$package" = vibrochain-cli ]; then
        program=$(size "${CARGO_TARGET_DIR:-target}/release/mapgen")
    fi
    echo "| $name | $crates | $library | $program |"
}

echo "| crate | crates compiled | library | \`mapgen\` |"
echo "|---|---|---|---|"
for layer in lattice breather floquet eventsim; do
    row "\`vibrochain-$layer\`" "vibrochain-$layer"
done
row "\`vibrochain-cli\`" vibrochain-cli

# "name", "time: [low mean high]" and "name: x allocations a cell" of the benchmark, a line each.
echo
echo "| map, N = 20, one core | cells a second | allocations a cell |"
echo "|---|---|---|"
cargo bench --locked --quiet --bench lean -- --quick 2> /dev/null | awk '
    /^lean\// { name = $0; sub(/^lean\//, "", name); sub(/ *time:.*/, "", name) }
    /thrpt:/ { line = $0; sub(/.*\[/, "", line); split(line, part, " "); rate[name] = part[3] " " part[4] }
    / allocations a cell$/ { split($0, part, ": "); sub(/ allocations.*/, "", part[2]); printf "| %s | %s | %s |\n", part[1], rate[part[1]], part[2] }
' | sed 's|elem/s||; s/ K / thousand /; s/ K |/ thousand |/'
