#!/usr/bin/env bash
# Tests at their full size (`slow_…`), file by file: all of them, or as many as end within so many seconds. A file whose time runs out is ended and
# named as not tested, like those that were not begun. Which comes first changes from commit to commit, so that those left out today are run tomorrow.
#
#     scripts/slow-tests.sh [SECONDS]
set -euo pipefail
cd "$(dirname "$0")/.."
most=${1:-unlimited}

mapfile -t files < <(grep -lr 'fn slow_' tests crates/*/tests --include='*.rs' | sed -E 's#^(.*/)?tests/##; s#/.*##; s#\.rs$##' | sort -u)
test "${#files[@]}" -ge 10
first=$(($(git rev-list --count HEAD 2>/dev/null || echo 0) % ${#files[@]}))

# Fewer seconds than this are not worth beginning with: the shortest files take as long.
least=5
left=()
told=$(mktemp)
trap 'rm -f "$told"' EXIT
for file in "${files[@]:first}" "${files[@]:0:first}"; do
    limit=()
    if [ "$most" != unlimited ]; then
        rest=$((most - SECONDS))
        if [ "$rest" -lt "$least" ]; then
            left+=("$file")
            continue
        fi
        # The test is a child of cargo: both are in the group that is ended.
        limit=(timeout --kill-after=5 "$rest")
    fi
    began=$SECONDS
    status=0
    "${limit[@]}" cargo test --locked --quiet --workspace ${FEATURES:+--features "$FEATURES"} --test "$file" -- --ignored slow --nocapture \
        >"$told" 2>&1 || status=$?
    # One that has failed by the time that the others are ended has failed.
    if [ "$status" != 0 ] && grep -q -- 'FAILED' "$told"; then
        cat "$told"
        exit 1
    fi
    # 124 by the first signal, 137 by the second.
    if [ "$status" = 124 ] || [ "$status" = 137 ] && [ "${#limit[@]}" -gt 0 ]; then
        echo "slow tests of $file: ended after $((SECONDS - began)) s, NOT TESTED"
        left+=("$file")
    elif [ "$status" != 0 ]; then
        cat "$told"
        exit "$status"
    else
        echo "slow tests of $file: $((SECONDS - began)) s"
    fi
done
[ "${#left[@]}" -eq 0 ] || echo "slow tests NOT TESTED this time: ${left[*]}"
