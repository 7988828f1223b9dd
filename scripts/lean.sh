#!/usr/bin/env bash
# What is paid for what, as Markdown: crates compiled for each crate used alone (its own and procedural macros included), the size of the program,
# allocations of a cell of each kind of map. Usage: scripts/lean.sh > docs/accuracy/lean.md
set -euo pipefail
cd "$(dirname "$0")/.."

# One line: name in the table, package, flags of cargo.
row() {
    local name=$1
    shift
    # A crate met again is marked (*): the same crate.
    echo "| $name | $(cargo tree --locked -p "$@" -e normal --prefix none | sed 's/ (\*)$//' | sort -u | wc -l) |"
}

echo "| crate | crates compiled |"
echo "|---|---|"
for layer in lattice breather floquet eventsim; do
    row "\`vibrochain-$layer\`" "vibrochain-$layer"
done
row "\`vibrochain-cli\` without features" vibrochain-cli --no-default-features
row "\`vibrochain-cli\`" vibrochain-cli

cargo build --locked --release --quiet --bin mapgen
echo
printf 'The program `mapgen` has %.0f MB.\n' "$(wc -c < "${CARGO_TARGET_DIR:-target}/release/mapgen")e-6"

# "name: x allocations a cell", a line each.
echo
echo "| map, N = 20 | allocations a cell |"
echo "|---|---|"
cargo test --locked --quiet --workspace ${FEATURES:+--features "$FEATURES"} --test lean -- --nocapture | sed -n 's/^\(.*\): \(.*\) allocations a cell$/| \1 | \2 |/p'
