#!/usr/bin/env bash
# Brings the table of docs/results.md up to date with experiments/results/results_schema.cpp.
# Usage: scripts/update-results-page.sh [FIRN]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
firn="${1:-build/release/firn}"
table="$(mktemp)"
trap 'rm -f "$table"' EXIT
"$firn" check-results --describe >"$table"
sed -i -e '/^<!-- schema -->$/,/^<!-- end -->$/{/^<!-- schema -->$/{r '"$table"'
p};/^<!-- end -->$/p;d}' docs/results.md
