#!/usr/bin/env bash
# package.sh: builds the release preset and a Debian package of it, build/release/firn_*.deb: the
# program, the library with its headers, and the Python package.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/install-packages.sh run build python package >&2
scripts/build.sh release firn firn-unite-mesh man firn_calibrate_library firn_python -- -DFIRN_PYTHON=ON
(cd build/release && cpack -G DEB >cpack.log 2>&1) || { cat build/release/cpack.log >&2; exit 1; }
ls build/release/firn_*.deb
