#!/usr/bin/env bash
# Tests the Python package against the program, both as `cargo test --locked --workspace` builds them. Further arguments are pytest's.
#
#     scripts/python-tests.sh [-k WORDS]          VENV=FOLDER: a virtual environment to use, and to keep
#                                                 WHEEL=FILE: tests this wheel and the program in it, in a new environment and without Rust
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ -z "${WHEEL:-}" ] || VENV=$work/venv
if ! python3 -m venv "${VENV:=$work/venv}" 2>/dev/null; then
    echo "the Python package: not tested here, there is no python3 that makes virtual environments"
    exit 0
fi
python=$VENV/bin/python
if ! "$python" -m pip install --quiet --no-compile --disable-pip-version-check 'maturin>=1.9.4,<2' numpy pytest; then
    echo "the Python package: not tested, NumPy and pytest cannot be had" >&2
    exit 1
fi
# What maps are handed on to; tests that need what is not there say so and are skipped.
"$python" -m pip install --quiet --no-compile --disable-pip-version-check pandas xarray matplotlib jsonschema scipy 'dask[distributed]' || true

if [ -n "${WHEEL:-}" ]; then
    "$python" -m pip install --quiet --no-compile --disable-pip-version-check "$WHEEL"
    export MAPGEN=$VENV/bin/mapgen PATH=$VENV/bin:/usr/bin:/bin
    if command -v cargo rustc; then
        echo "the wheel: tested beside a Rust toolchain, which stands in a folder of the system"
    fi
    (
        cd "$work"
        mapgen init plane.toml --quiet
        mapgen sweep plane.toml --out map.csv --plot map.png
        head -c 8 map.png | grep -q PNG
    )
    MPLBACKEND=Agg "$python" -m pytest -q -rs -p no:cacheprovider "$@"
    echo "the wheel: sound, $(mapgen --version)"
    exit
fi

# The features are those of the workspace's tests, so that all but the last crate is built already.
cargo build --locked --workspace ${FEATURES:+--features "$FEATURES"} --lib --bin mapgen --test imports
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
mkdir "$work/package"
cp -r crates/python/python/vibrochain "$work/package"
cp "$CARGO_TARGET_DIR/debug/lib_vibrochain.so" "$work/package/vibrochain/_vibrochain.abi3.so"
PYTHONPATH=$work/package MPLBACKEND=Agg "$python" -m pytest -q -rs -p no:cacheprovider "$@"

# The package's description is sound: maturin finds crate, sources and licences. (Built it is by scripts/wheels.sh.)
"$VENV/bin/maturin" pep517 write-dist-info --metadata-directory "$work/description" --interpreter "$python" >/dev/null
grep -qx 'Name: vibrochain' "$work"/description/*/METADATA
echo "the Python package: sound"
