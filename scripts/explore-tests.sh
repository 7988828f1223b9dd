#!/usr/bin/env bash
# The page of `mapgen explore` in a browser without a window: it loads, zooms, is used by keys alone, keeps its memory. Says so and passes
# where Chromium or the Python module that speaks with it cannot be had. PICTURES=DIR keeps screenshots; MAPGEN=FILE takes a program that is built
# already. PANS=200 instead of a thousand random pans and zooms.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v chromium >/dev/null && command -v apt-get >/dev/null; then
    { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends chromium; } >/dev/null 2>&1 || true
fi
if ! command -v chromium >/dev/null; then
    echo "the explorer in a browser: NOT TESTED here, Chromium cannot be had"
    exit 0
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if ! { python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install --quiet 'websocket-client>=1.6,<2'; } >/dev/null 2>&1; then
    echo "the explorer in a browser: NOT TESTED here, Python's websocket-client cannot be had"
    exit 0
fi
if [ -z "${MAPGEN:-}" ]; then
    # With the features of the workspace's tests: it is built already.
    cargo build --locked --quiet --workspace ${FEATURES:+--features "$FEATURES"} --bin mapgen --test imports
    MAPGEN=${CARGO_TARGET_DIR:-target}/debug/mapgen
fi
"$folder/venv/bin/python" scripts/explore_tests.py "$MAPGEN" "${PICTURES:-}"
