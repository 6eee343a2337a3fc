#!/usr/bin/env bash
# Brings the table of docs/calibration-proof.md up to date with tests/calibration_proof/coverage_record.csv,
# problems.toml and the present engine. Usage: scripts/update-coverage-page.sh [FIRN_COVERAGE_PROOF]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program="${1:-build/release/tests/calibration_proof/firn_coverage_proof}"
folder=tests/calibration_proof
table="$(mktemp)"
trap 'rm -f "$table"' EXIT
"$program" "$folder/problems.toml" --record "$folder/coverage_record.csv" --table >"$table"
sed -i -e '/^<!-- coverage -->$/,/^<!-- end -->$/{/^<!-- coverage -->$/{r '"$table"'
p};/^<!-- end -->$/p;d}' docs/calibration-proof.md
