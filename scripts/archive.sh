#!/usr/bin/env bash
# Packs the program as one archive: completions, manual pages, scenes, and the licences of all that is linked into it.
#
#     scripts/archive.sh PROGRAM [FOLDER]        default: out/archives; prints the archive's name, the folder beside it has what it holds
#                                                WRITER=PROGRAM: writes completions and pages where the one that is packed does not run
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/.."
writer=${WRITER:-$program}
mkdir -p "${2:-out/archives}"
folder=$(realpath "${2:-out/archives}")

# The machine that a program is for stands in its head.
case $(od -An -tx1 -j18 -N1 "$program" | tr -d ' ') in
3e) machine=x86_64 ;;
b7) machine=aarch64 ;;
*) echo "scripts/archive.sh: $program is a program for neither x86-64 nor aarch64 Linux" >&2 && exit 1 ;;
esac
version=$("$writer" --version)
name=${version/ /-}-$machine-linux
rm -rf "${folder:?}/$name"
mkdir -p "$folder/$name"/{completions,man/man1}
cp "$program" "$folder/$name/mapgen"
strip "$folder/$name/mapgen" 2>/dev/null || true    # one for another machine may stay as it is
cp -r scenes README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$folder/$name"
"$writer" man "$folder/$name/man/man1" --quiet
for shell in bash elvish fish powershell zsh; do
    "$writer" completions "$shell" > "$folder/$name/completions/mapgen.$shell"
done
python3 scripts/licences.py > "$folder/$name/LICENSES-of-dependencies.txt"

tar -czf "$folder/$name.tar.gz" -C "$folder" --owner=0 --group=0 --numeric-owner --sort=name "$name"
# All of it is there.
tar -tzf "$folder/$name.tar.gz" > "$folder/$name.txt"
for file in mapgen README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE LICENSES-of-dependencies.txt scenes/conservative-n20.toml \
    scenes/structures/cantilever.toml man/man1/mapgen.1 man/man1/mapgen-sweep.1 completions/mapgen.bash; do
    grep -qx "$name/$file" "$folder/$name.txt" || { echo "scripts/archive.sh: $file is missing" >&2 && exit 1; }
done
rm "$folder/$name.txt"
echo "$folder/$name.tar.gz"
