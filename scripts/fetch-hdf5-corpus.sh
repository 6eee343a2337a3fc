#!/usr/bin/env bash
# Unpacks the HDF5 files of the library's own tests, malformed ones among them, from Debian's source
# package. Usage: scripts/fetch-hdf5-corpus.sh FOLDER. Needs a line "deb-src" among apt's sources.
# Then: FIRN_HDF5_CORPUS=FOLDER ./test --long
set -euo pipefail
mkdir -p "$1"
cd "$1"
apt-get source --download-only hdf5
tar --wildcards -xzf hdf5_*.orig.tar.gz '*.h5'
