#!/usr/bin/env bash
# Builds what is released for Linux: wheels of the Python package, one for every Python from 3.9 on, with the program mapgen in them, and archives
# of mapgen alone, into a folder (default: out/release). The wheel for this machine is then tested where there is no Rust.
#
#     scripts/wheels.sh [FOLDER] [MACHINE...]      machines: x86_64, aarch64; without one both
#                                                  LOCAL=yes: for this machine and its C library alone
#                                                  LOCAL=tests: the same from the build of the workspace's tests, untested: it prints the wheel's name
#
# With zig (it comes from PyPI) programs are linked against an old C library and run on every Linux since 2014 (manylinux2014). For another machine
# the compiler needs that machine's standard library, which rustup has (`rustup target add aarch64-unknown-linux-gnu`). A processor for x86_64 needs AVX2
# and FMA, as for all builds; RUSTFLAGS="-C target-cpu=x86-64" makes programs for any.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-out/release}
shift || true
machines=("$@")
here=$(uname -m)
[ "${#machines[@]}" -gt 0 ] || machines=(x86_64 aarch64)
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")

# Tools stay where they are from run to run: the linker's path is a part of what cargo compares.
tools=$target/release-tools
# What stands in this folder goes into wheels: programs to the environment's bin, the rest to its share.
export DATA=$PWD/vibrochain._vibrochain.data
trap 'rm -rf "$DATA"' EXIT
[ -d "$tools/venv" ] || python3 -m venv "$tools/venv"
"$tools/venv/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2' >&2
# With the tools' folder in front maturin finds zig.
PATH=$tools/venv/bin:$PATH
if [ -z "${LOCAL:-}" ] && ! pip install --quiet --disable-pip-version-check ziglang; then
    echo "zig cannot be had: a wheel for this machine's C library and newer ones alone"
    LOCAL=yes
fi
[ -z "${LOCAL:-}" ] || machines=("$here")

# Maturin asks cargo for the extension; the script in cargo's place builds the program in the same call.
export CARGO=$PWD/scripts/wheel-cargo.sh
export PACKAGES="--package vibrochain-python --package vibrochain-cli"
for machine in "${machines[@]}"; do
    triple=$machine-unknown-linux-gnu
    profile=release how=(--compatibility linux)
    if [ "${LOCAL:-}" = tests ]; then
        # One test among what is built, and all parts have the features of the tests'.
        profile=dev PACKAGES="--workspace --test imports ${FEATURES:+--features $FEATURES}"
        export PROGRAM=$target/debug/mapgen
    elif [ -n "${LOCAL:-}" ]; then
        export PROGRAM=$target/release/mapgen
    elif rustup target add "$triple" 2>/dev/null; then
        # A target of its own, so that nothing else is built anew by it.
        export CARGO_PROFILE_RELEASE_STRIP=symbols PROGRAM=$target/$triple/release/mapgen
        how=(--zig --target "$triple" --compatibility manylinux2014)
    else
        echo "$machine: NOT BUILT, its standard library cannot be had"
        continue
    fi
    # Completions and pages are written by a program that runs here.
    [ "$machine" != "$here" ] || export WRITER=$PROGRAM
    if [ -z "${WRITER:-}" ]; then
        "${CARGO_HOME:-$HOME/.cargo}/bin/cargo" build --locked --release --bin mapgen
        export WRITER=$target/release/mapgen
    fi
    export ARCHIVES=$folder
    mkdir -p "$DATA"
    maturin build --profile "$profile" --out "$folder" "${how[@]}" >&2
    rm -r "$DATA"
done

wheel=$(ls -t "$folder"/vibrochain-*"$here".whl | head -n 1)
if [ "${LOCAL:-}" = tests ]; then
    echo "$wheel"
    exit
fi
ls -l "$folder"
WHEEL=$wheel scripts/python-tests.sh ${TESTS:+-k "$TESTS"}
