#!/usr/bin/env bash
# What each crate costs when it is used alone, as a Markdown table: crates compiled (its own and procedural macros
# included), size of its library and of the program, both as `cargo build --release` leaves them.
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
    cargo build --release --quiet -p "$package" "$@"
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
# The full program last: it is the one that stays.
row "\`vibrochain-cli\` without features" vibrochain-cli --no-default-features
row "\`vibrochain-cli\`" vibrochain-cli
