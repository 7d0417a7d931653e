#!/usr/bin/env bash
# Format, lint and layering of all sources. Fails at the first kind of trouble found.
#   tools/check.sh              everything
#   tools/check.sh format       without clang-tidy, which takes minutes
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mapfile -t sources < <(git ls-files '*.cpp' '*.h')
clang-format --dry-run --Werror "${sources[@]}"
python3 tools/check_floors.py
[ "${1:-}" = format ] && exit 0

# Through the compile commands of the release build; not those files that include ITK or Highway,
# whose own headers clang 14 can't digest.
mapfile -t units < <(git ls-files '*.cpp' | grep -vE '^tests/|ItkReader|Kernel\.cpp$|VdbReader')
printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy --quiet -p build/release
