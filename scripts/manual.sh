#!/usr/bin/env bash
# Builds the manual as a site, into target/manual/site: pages of docs, and the reference made from the program and the Python package. A warning
# or a link that leads nowhere fails. Where Python's packages cannot be had it says so and passes.
#
#     scripts/manual.sh          VENV=FOLDER: a virtual environment to use, and to keep; it may have the package already
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! python3 -m venv "${VENV:=$work/venv}" 2>/dev/null; then
    echo "the manual: NOT BUILT here, there is no python3 that makes virtual environments"
    exit 0
fi
install() { "$VENV/bin/python" -m pip install --quiet --no-compile --disable-pip-version-check "$@" 2>/dev/null; }
if ! install 'mkdocs>=1.6,<2' 'mkdocs-material>=9.6,<10' 'latex2mathml>=3.77,<4' numpy; then
    echo "the manual: NOT BUILT here, MkDocs, its theme or NumPy cannot be had"
    exit 0
fi
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
if [ ! -x "$VENV/bin/mapgen" ]; then
    # From the build of the workspace's tests.
    wheel=$(LOCAL=tests scripts/wheels.sh "$work")
    install --no-deps "$wheel"
fi

manual=$CARGO_TARGET_DIR/manual
mkdir -p "$manual"
PYTHONDONTWRITEBYTECODE=1 "$VENV/bin/python" scripts/manual.py "$VENV/bin/mapgen" "$manual/pages"
# (With --quiet warnings are not counted.)
MANUAL_PAGES=$manual/pages NO_MKDOCS_2_WARNING=1 "$VENV/bin/mkdocs" build --strict --site-dir "$manual/site" 2> "$work/told" || { cat "$work/told"; exit 1; }
test "$(find "$manual/site" -name '*.html' | wc -l)" -gt 50
echo "the manual: $manual/site/index.html; with its search: python3 -m http.server --directory $manual/site"
