#!/usr/bin/env bash
# install-packages.sh SECTION...: installs what is missing of these sections of packages.txt.
# Asks the network for nothing, and needs no rights, when nothing is missing. Writes to stderr only.
set -euo pipefail
exec >&2

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"

packages_of() {  # SECTION
  awk -v wanted="[$1]" '/^#/ || NF == 0 { next } /^\[/ { on = ($0 == wanted); next } on' "$here/packages.txt"
}

packages="$(for section in "$@"; do packages_of "$section"; done)"
command -v dpkg-query >/dev/null || {
  echo "firn: not a Debian or Ubuntu machine; it needs what these packages hold:" $packages
  exit 0   # they may be there under other names: the build reports what is missing
}
installed="$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' $packages 2>/dev/null | awk '/^.i/ { print $NF }' || true)"
missing="$(comm -23 <(sort -u <<<"$packages") <(sort -u <<<"$installed"))"
[ -n "$missing" ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "firn: missing packages, and no sudo to install them; as root: apt-get install" $missing
    exit 1
  }
  as_root=(sudo)
fi
echo "firn: installing missing packages:" $missing
export DEBIAN_FRONTEND=noninteractive
apt_get=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=600)
install=("${apt_get[@]}" install --no-install-recommends $missing)
# Package lists may be absent or old: fetch them first, and continue with the available ones when that fails.
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
if ! { "${apt_get[@]}" update; "${install[@]}"; } >"$log" 2>&1 </dev/null; then
  tail -n 20 "$log"
  echo "firn: the installation failed; try it by hand: apt-get install" $missing
  exit 1
fi
