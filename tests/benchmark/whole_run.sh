#!/usr/bin/env bash
# Wall time, steps and memory of the whole drained repose experiment (fill, settle, drain), a line a
# seed, as CSV on standard output.
#
# Usage: tests/benchmark/whole_run.sh [-c CORES] [-t THREADS] [SEED...]     (default: core 0, seed 1)
set -euo pipefail
root="$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
cores=0 threads=1
while getopts "c:t:" option; do
  case $option in
    c) cores=$OPTARG ;;
    t) threads=$OPTARG ;;
    *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))
[[ $# -gt 0 ]] || set -- 1

"$root/firn" --version >&2 # builds what is stale
firn="$root/build/release/firn"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "seed,threads,wall_s,simulated_s,timestep_s,steps,us_per_particle_step,peak_memory_MB,file_MB,responses"
for seed in "$@"; do
  taskset -c "$cores" "$firn" run "$root/cases/drained_repose/case.toml" --seed "$seed" \
    --threads "$threads" -o "$work/run.h5" --json >"$work/run.json" 2>"$work/log" &
  program=$!
  peak=0
  while kill -0 "$program" 2>/dev/null; do
    now=$(awk '/^VmHWM:/ { print $2 }' "/proc/$program/status" 2>/dev/null || true)
    peak=${now:-$peak}
    sleep 0.2
  done
  wait "$program" || { tail -3 "$work/log" >&2; exit 1; }
  size=$(stat -c %s "$work/run.h5")
  python3 - "$work/run.json" "$seed" "$threads" "$peak" "$size" <<'PY'
import json, sys

run = json.load(open(sys.argv[1]))
seed, threads, peak, size = sys.argv[2], sys.argv[3], int(sys.argv[4]) / 1024, int(sys.argv[5]) / 1e6
micro = 1e6 * run["wall"] / run["steps"] / run["particles"]
print(f'{seed},{threads},{run["wall"]:.1f},{run["simulated"]:.3f},{run["timestep"]:.4g},{run["steps"]},'
      f'{micro:.3f},{peak:.0f},{size:.1f},"{json.dumps(run["responses"])[:400]}"')
PY
done
