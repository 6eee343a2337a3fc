#!/usr/bin/env bash
# nightly-coverage.sh [MINUTES [STUDIES]]: carries out coverage studies of the present engine that
# tests/calibration_proof/coverage_record.csv lacks, up to STUDIES for each row (200); starts none after MINUTES
# (0: no limit). Brings the page up to date, and fails if a row exceeds its limits. docs/calibration-proof.md
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/install-packages.sh run build test docs python
scripts/build.sh release firn_coverage_proof -- -DFIRN_TESTS=ON
program=build/release/tests/calibration_proof/firn_coverage_proof
problems=tests/calibration_proof/problems.toml
record=tests/calibration_proof/coverage_record.csv

status=0
"$program" "$problems" --record "$record" --studies "${2:-200}" --jobs "$(nproc)" --minutes "${1:-0}" >/dev/null || status=$?
[ "$status" -lt 128 ] || exit "$status"
scripts/update-coverage-page.sh "$program"
"$program" "$problems" --record "$record" --check || status=$?
exit "$status"
