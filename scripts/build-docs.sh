#!/usr/bin/env bash
# build-docs.sh [FOLDER]: builds the documentation as a site in FOLDER (build/docs). It works without a
# network and without a server: open FOLDER/docs/README.html. Broken links are errors.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
out="$(realpath -m "${1:-$root/build/docs}")"
"$root/scripts/install-packages.sh" docs
cd "$root"
sphinx-build -q -W --keep-going -b html -c docs/site -d "$out/.doctrees" . "$out"
echo "$out/docs/README.html"
