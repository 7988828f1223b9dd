#!/usr/bin/env bash
# Draws faults with cargo-mutants and says which of them no test notices. All are compiled into one program, each behind a switch, so that each costs
# a run of tests and no build of its own. What is committed counts. Not for CI. Equivalent ones are in .cargo/mutants.toml, with reasons.
#
#     scripts/mutants.sh [SEED [COUNT [CRATE…]]]         1 100, and lattice breather floquet eventsim fate maps
#
# MINUTES=30 is how long it may take; what is left then is named as not tried. Fails where fewer than nine of ten are caught.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v cargo-mutants >/dev/null || cargo install --locked cargo-mutants
exec python3 scripts/mutants.py "$@"
