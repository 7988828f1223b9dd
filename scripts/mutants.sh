#!/usr/bin/env bash
# Draws faults with cargo-mutants and says which of them no test notices. All are compiled into one build of all tests, each behind a switch. One run
# of every test, alone and without a fault, tells which it reaches; then each fault meets those tests, the quickest first, until one fails, twice, and
# passes without. What is committed counts. Not for CI. Equivalent faults are in .cargo/mutants.toml, with reasons.
#
#     scripts/mutants.sh [SEED [COUNT [CRATE…]]]         1 30, and lattice breather floquet eventsim fate maps
#
# MINUTES=60 is how long it may take; what is left then is named as not tried. Fails where fewer than nine of ten are caught.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v cargo-mutants >/dev/null || cargo install --locked cargo-mutants
exec python3 scripts/mutants.py "$@"
