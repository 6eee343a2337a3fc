#!/usr/bin/env bash
# build.sh PRESET TARGET... [-- CMAKE-OPTION...]: configures a preset where need be and builds
# targets, one caller at a time. Quick and silent when nothing changed; progress goes to stderr.
set -euo pipefail
exec >&2

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
preset="$1"
shift
targets=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do targets+=("$1"); shift; done
[ $# -eq 0 ] || shift
options=("$@")
folder="$root/build/$preset"

mkdir -p "$folder"
exec 9>"$folder/.lock"
flock 9   # given back when this script ends

# A tree that was moved or copied cannot use its old cache.
if [ -f "$folder/CMakeCache.txt" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$folder/CMakeCache.txt"; then
  find "$folder" -mindepth 1 -maxdepth 1 ! -name .lock -exec rm -rf {} +
fi

if [ ! -f "$folder/build.ninja" ] || [ ${#options[@]} -gt 0 ]; then
  if [ ! -f "$folder/build.ninja" ]; then
    rm -f "$folder/CMakeCache.txt"   # of a configuration that failed: its options may be the reason
    echo "firn: configuring the $preset build"
  fi
  if ! (cd "$root" && cmake --preset "$preset" "${options[@]}") >"$folder/configure.log" 2>&1; then
    cat "$folder/configure.log"
    echo "firn: the configuration failed"
    exit 1
  fi
fi

# A compiler takes up to 1.5 GB.
memory=$(awk '/^MemAvailable/ { print int($2 / 1500000) }' /proc/meminfo)
jobs=$(nproc)
[ "$memory" -ge "$jobs" ] || jobs=$((memory > 0 ? memory : 1))

# Ninja's status lines become one progress line on a terminal, and a line now and then elsewhere;
# anything else it says is a compiler's message and is passed on.
terminal=0
[ ! -t 2 ] || terminal=1
NINJA_STATUS='[%f/%t] ' ninja -C "$folder" -j "$jobs" "${targets[@]}" 2>&1 | awk -v terminal="$terminal" '
  /^ninja: Entering directory/ || /^ninja: no work to do/ || /Re-checking globbed/ || /write_version.cmake/ { next }
  /^-- / || /Re-running CMake/ { next }
  /^\[[0-9]+\/[0-9]+\] / {
    split(substr($1, 2, length($1) - 2), part, "/")
    if (!started++) { print "firn: building (the first time takes some minutes)"; last = 0 }
    if (terminal) { printf "\r\033[K%s %s", $1, $NF; fflush(); open = 1 }
    else if (part[2] > 0 && part[1] / part[2] >= last + 0.1) {
      last = part[1] / part[2]
      print "firn: built " part[1] " of " part[2]; fflush()
    }
    next
  }
  { if (open) printf "\r\033[K"; open = 0; print; fflush() }
  END { if (open) printf "\r\033[K" }'
