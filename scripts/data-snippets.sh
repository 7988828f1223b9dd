#!/usr/bin/env bash
# Runs what docs/data.md shows, block by block in the order of the page, each language in a folder with the files of its first block. What
# cannot be run here is said, and is no failure.
#
#     scripts/data-snippets.sh          VENV=FOLDER: a virtual environment of Python to use, and to keep
#                                       MAPGEN=PROGRAM: instead of that of the tests, one with the feature `parquet` for example
#                                       JULIA=yes: a Julia, if there is none, takes minutes to install or to look for in vain
set -euo pipefail
cd "$(dirname "$0")/.."
page=$PWD/docs/data.md example=$PWD/examples/julia/breather.jl

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
if [ -z "${MAPGEN:-}" ]; then
    # With the features of the workspace's tests: it is built already.
    cargo build --locked --quiet --workspace ${FEATURES:+--features "$FEATURES"} --bin mapgen --test imports
    MAPGEN=$CARGO_TARGET_DIR/debug/mapgen
fi
mkdir "$work/bin"
ln -s "$(realpath "$MAPGEN")" "$work/bin/mapgen"
ln -s "$PWD/scenes" "$work/scenes"
export PATH=$work/bin:$PATH
cd "$work"

# All blocks of these kinds, one after the other: ```python, or ```python parquet for those that need more.
blocks() {
    awk -v kinds="$*" '
        BEGIN { count = split(kinds, list, ","); for (i = 1; i <= count; i++) wanted[list[i]] = 1 }
        /^```/ { open = !open; shown = open && (substr($0, 4) in wanted); next }
        open && shown { print }' "$page"
}
skipped() { echo "docs/data.md: $*"; }

blocks sh > files.sh
grep -q '^mapgen orbit' files.sh
bash -euo pipefail files.sh 2> told || { cat told; exit 1; }
test "$(wc -l < map.csv)" -eq 120001

parquet=
if mapgen sweep scenes/conservative-n5.toml --out map.parquet --quiet 2> told; then
    parquet=parquet
else
    grep -q parquet told
    skipped "PARQUET IS NOT READ HERE, this mapgen writes none: name one built with --features parquet by MAPGEN=…"
fi

if python3 -m venv "${VENV:=$work/venv}" 2> /dev/null; then
    python=$VENV/bin/python
    install() { "$python" -m pip install --quiet --no-compile --disable-pip-version-check "$@" 2> /dev/null; }
    if install pandas; then
        kinds=python
        for pair in zstandard:zstandard jsonschema:jsonschema ${parquet:+pyarrow:parquet}; do
            if install "${pair%:*}"; then
                kinds=$kinds,"python ${pair#*:}"
            else
                skipped "${pair%:*} cannot be had, its blocks are not run"
            fi
        done
        blocks "$kinds" > snippets.py
        test "$(grep -c assert snippets.py)" -ge 10
        "$python" snippets.py
        echo "docs/data.md: $(grep -c assert snippets.py) demands of Python hold ($kinds)"
    else
        skipped "pandas cannot be had, the blocks of Python are not run"
    fi
else
    skipped "there is no python3 that makes virtual environments, the blocks of Python are not run"
fi

# One minute to install, where that is allowed.
if ! command -v octave-cli > /dev/null && command -v apt-get > /dev/null && [ "$(id -u)" = 0 ]; then
    { apt-get update && DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends octave; } > /dev/null 2>&1 || true
fi
if command -v octave-cli > /dev/null; then
    blocks octave > snippets.m
    test "$(grep -c assert snippets.m)" -ge 7
    echo 'disp("all of it ran")' >> snippets.m
    # Without pictures it complains as it ends.
    octave-cli --quiet --no-init-file snippets.m 2> >(grep -v "preparing to exit" >&2) | tee told
    grep -qx "all of it ran" told
    echo "docs/data.md: $(grep -c assert snippets.m) demands of Octave hold"
else
    skipped "Octave cannot be had, its blocks are not run"
fi

if command -v Rscript > /dev/null && Rscript -e 'library(jsonlite)' 2> /dev/null; then
    blocks r > snippets.R
    test "$(grep -c stopifnot snippets.R)" -ge 6
    Rscript snippets.R
    echo "docs/data.md: $(grep -c stopifnot snippets.R) demands of R hold"
else
    skipped "THE BLOCKS OF R ARE NOT RUN: there is no Rscript here, or not its package jsonlite"
fi

# Julia: what the system's packages have, else what its own servers give through `jill`, where they can be reached.
if [ -n "${JULIA:-}" ] && ! command -v julia > /dev/null; then
    if command -v apt-get > /dev/null && [ "$(id -u)" = 0 ]; then
        DEBIAN_FRONTEND=noninteractive timeout 300 apt-get install -y --no-install-recommends julia > /dev/null 2>&1 || true
    fi
    if ! command -v julia > /dev/null && [ -n "${python:-}" ] && install jill; then
        timeout 300 "$VENV/bin/jill" install --confirm --install_dir "$work/julias" --symlink_dir "$work/bin" > /dev/null 2>&1 || true
    fi
fi

export JULIA_DEPOT_PATH=$work/julia:${JULIA_DEPOT_PATH:-}
packages="\"CSV\", \"DataFrames\", \"CodecZlib\", \"JSON\"${parquet:+, \"Parquet2\"}"
if ! command -v julia > /dev/null; then
    skipped "THE BLOCKS OF JULIA AND examples/julia ARE NOT RUN: there is no julia here${JULIA:+, and neither apt-get nor jill can have one}"
elif ! julia --startup-file=no --project=. -e "import Pkg; Pkg.add([$packages])" 2> told; then
    skipped "packages of Julia cannot be had, its blocks are not run"
else
    blocks "julia${parquet:+,julia parquet}" > snippets.jl
    test "$(grep -c @assert snippets.jl)" -ge 6
    julia --startup-file=no --project=. snippets.jl
    echo "docs/data.md: $(grep -c @assert snippets.jl) demands of Julia hold"
    julia --startup-file=no --project=. "$example" | tee told
    test "$(grep -c 'ω = ' told)" -eq 5
    echo "examples/julia: sound"
fi
