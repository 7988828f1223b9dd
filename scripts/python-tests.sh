#!/usr/bin/env bash
# Tests a wheel of the Python package, and the program that it brings, in a new environment and without Rust. Further arguments are pytest's.
#
#     scripts/python-tests.sh [-k WORDS]          WHEEL=FILE: this one, instead of one from the build of the workspace's tests
#                                                 VENV=FOLDER: the environment, which is kept
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! python3 -m venv "${VENV:=$work/venv}" 2>/dev/null; then
    echo "the Python package: not tested here, there is no python3 that makes virtual environments"
    exit 0
fi
python=$VENV/bin/python
install() { "$python" -m pip install --quiet --no-compile --disable-pip-version-check "$@"; }
if ! install numpy pytest; then
    echo "the Python package: not tested, NumPy and pytest cannot be had" >&2
    exit 1
fi
# What maps are handed on to; tests that need what is not there say so and are skipped.
install pandas xarray matplotlib jsonschema scipy 'dask[distributed]' || true
# On both processors, where that can be had.
install pytest-xdist && both='-n 2 --dist loadfile' || both=

[ -n "${WHEEL:-}" ] || WHEEL=$(LOCAL=tests scripts/wheels.sh "$work/wheels")
install --force-reinstall --no-deps "$WHEEL"
export PATH=$VENV/bin:/usr/bin:/bin MPLBACKEND=Agg
unset MAPGEN
if command -v cargo rustc; then
    echo "the wheel: tested beside a Rust toolchain, which stands in a folder of the system"
fi
# The README's lines, with what the wheel brings.
(
    cd "$work"
    mapgen init plane.toml --quiet
    mapgen sweep plane.toml --out map.csv --plot map.png
    head -c 8 map.png | grep -q PNG
)
MAPGEN=$VENV/bin/mapgen "$python" -m pytest -q -rs -p no:cacheprovider $both "$@"
for file in "$VENV"/share/man/man1/mapgen.1 "$VENV"/share/doc/vibrochain/scenes/conservative-n20.toml "$VENV"/share/doc/vibrochain/LICENSES-of-dependencies.txt \
    "$VENV"/lib/python3*/site-packages/vibrochain-*.dist-info/licenses/LICENSE-MIT; do
    test -s "$file" || { echo "the wheel: it does not bring $file" >&2 && exit 1; }
done
echo "the wheel: sound, $(mapgen --version)"
