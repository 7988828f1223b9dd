#!/usr/bin/env bash
# Stands in cargo's place for scripts/wheels.sh. Maturin asks for the extension alone, with the features of its crate alone: a build of all crates
# for the extension, and another for the program. Here one call builds both; the archive of the program is packed, and what of it belongs into the
# wheel is laid into the folder DATA.
set -euo pipefail
unset CARGO
[ "${1:-}" = rustc ] || exec cargo "$@"
shift
given=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    case $1 in
    --manifest-path) shift ;;
    --lib) ;;
    *) given+=("$1") ;;
    esac
    shift
done
# Maturin reads what cargo writes; what else is said goes elsewhere.
read -ra packages <<<"$PACKAGES"
cargo build "${given[@]}" "${packages[@]}" --lib --bin mapgen

archive=$(scripts/archive.sh "$PROGRAM" "$ARCHIVES")
unpacked=${archive%.tar.gz}
mkdir -p "$DATA"/{scripts,data/share/{man,doc/vibrochain}}
cp "$unpacked/mapgen" "$DATA/scripts"
cp -r "$unpacked/man/man1" "$DATA/data/share/man"
cp -r "$unpacked/LICENSES-of-dependencies.txt" "$unpacked/scenes" "$DATA/data/share/doc/vibrochain"
rm -r "$unpacked"
