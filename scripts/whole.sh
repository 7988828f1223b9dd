#!/usr/bin/env bash
# What takes longer than a change can wait for: tests at their full size, every picture of the gallery. A quarter of an hour on two cores,
# once tests are built. Before a version, and now and then.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo test --workspace --tests -- --ignored slow
JULIA=yes scripts/data-snippets.sh
