#!/usr/bin/env bash
# Builds wheels of the Python package for Linux, one for every Python from 3.9 on, into a folder (default: out/wheels).
#
#     scripts/wheels.sh [FOLDER]
#
# With zig (pip install ziglang) they are linked against an old C library and run on every Linux since 2014 (manylinux2014);
# without it against this machine's, which is what the wheel's name then says. The processor needs AVX2 and FMA, as all
# builds do; RUSTFLAGS="-C target-cpu=x86-64" makes a wheel for any.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-out/wheels}

tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
python3 -m venv "$tools/venv"
"$tools/venv/bin/pip" install --quiet 'maturin>=1.9.4,<2'
maturin=$tools/venv/bin/maturin
if "$tools/venv/bin/pip" install --quiet ziglang; then
    how=(--zig --compatibility manylinux2014)
else
    echo "zig cannot be had: wheels for this C library and newer ones"
    how=()
fi
# With the tools' folder in front maturin finds zig.
PATH="$tools/venv/bin:$PATH" "$maturin" build --release --out "$folder" "${how[@]}"
ls -l "$folder"
