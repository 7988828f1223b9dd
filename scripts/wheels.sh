#!/usr/bin/env bash
# Builds what is released for Linux: wheels of the Python package, one for every Python from 3.9 on, with the program mapgen in them, and archives
# of mapgen alone, into a folder (default: out/release). The wheel for this machine is then tested where there is no Rust.
#
#     scripts/wheels.sh [FOLDER] [MACHINE...]      machines: x86_64, aarch64; without one both
#                                                  LOCAL=yes: for this machine and its C library alone, from target/release
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
[ -z "${LOCAL:-}" ] || machines=("$here")
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")

# Tools stay where they are from run to run: the linker's path is a part of what cargo compares.
tools=$target/release-tools
# What stands in this folder goes into wheels: programs to the environment's bin, the rest to its share.
data=$PWD/vibrochain._vibrochain.data
trap 'rm -rf "$data"' EXIT
[ -d "$tools/venv" ] || python3 -m venv "$tools/venv"
"$tools/venv/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2'
# With the tools' folder in front maturin finds zig.
PATH=$tools/venv/bin:$PATH
if [ -z "${LOCAL:-}" ] && ! pip install --quiet --disable-pip-version-check ziglang; then
    echo "zig cannot be had: a wheel for this machine's C library and newer ones alone"
    LOCAL=yes machines=("$here")
fi

writer=
for machine in "${machines[@]}"; do
    triple=$machine-unknown-linux-gnu
    if [ -n "${LOCAL:-}" ]; then
        cargo build --locked --release
        program=$target/release/mapgen how=(--compatibility linux)
    elif rustup target add "$triple" 2>/dev/null; then
        # A target of its own, so that nothing else is built anew by it.
        export CARGO_PROFILE_RELEASE_STRIP=symbols
        how=(--zig --target "$triple" --compatibility manylinux2014)
        # Maturin links the program by zig, too; the wheel of the program alone is thrown away.
        maturin build --release --locked --manifest-path crates/cli/Cargo.toml --bindings bin --out "$tools/thrown-away" "${how[@]}"
        program=$target/$triple/release/mapgen
    else
        echo "$machine: NOT BUILT, its standard library cannot be had"
        continue
    fi
    # Completions and pages are written by a program that runs here.
    [ "$machine" != "$here" ] || writer=$program
    if [ -z "$writer" ]; then
        cargo build --locked --release
        writer=$target/release/mapgen
    fi
    archive=$(WRITER=$writer scripts/archive.sh "$program" "$folder")
    unpacked=${archive%.tar.gz}
    rm -rf "$data"
    mkdir -p "$data"/{scripts,data/share/{man,doc/vibrochain}}
    cp "$unpacked/mapgen" "$data/scripts"
    cp -r "$unpacked/man/man1" "$data/data/share/man"
    cp "$unpacked/LICENSES-of-dependencies.txt" "$data/data/share/doc/vibrochain"
    rm -r "$unpacked"
    maturin build --release --out "$folder" "${how[@]}"
done
ls -l "$folder"

wheel=$(ls -t "$folder"/vibrochain-*"$here".whl | head -n 1)
WHEEL=$wheel scripts/python-tests.sh ${TESTS:+-k "$TESTS"}
