#!/usr/bin/env bash
# Tests at their full size (`slow_…`), file by file: all of them, or as many as are begun within so many seconds. Which comes first changes from
# commit to commit, so that those left out today are run tomorrow.
#
#     scripts/slow-tests.sh [SECONDS]
set -euo pipefail
cd "$(dirname "$0")/.."
most=${1:-unlimited}

mapfile -t files < <(grep -lr 'fn slow_' tests crates/*/tests --include='*.rs' | sed -E 's|/all/.*|/all.rs|; s|.*/||; s|\.rs$||' | sort -u)
test "${#files[@]}" -ge 10
first=$(($(git rev-list --count HEAD 2>/dev/null || echo 0) % ${#files[@]}))

left=()
for file in "${files[@]:first}" "${files[@]:0:first}"; do
    if [ "$most" != unlimited ] && [ "$SECONDS" -ge "$most" ]; then
        left+=("$file")
        continue
    fi
    began=$SECONDS
    cargo test --locked --quiet --workspace --test "$file" -- --ignored slow
    echo "slow tests of $file: $((SECONDS - began)) s"
done
[ "${#left[@]}" -eq 0 ] || echo "slow tests NOT RUN this time: ${left[*]}"
