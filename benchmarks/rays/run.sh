#!/bin/sh
# Times Embree beside our own engine: benchmarks/rays/run.sh [turns] [threads]
# Needs g++ and Embree 3 (Debian: apt-get install libembree-dev).
set -eu
cd "$(dirname "$0")"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../target/benchmarks}"
export EMBREE_DRIVER="$CARGO_TARGET_DIR/embree"
mkdir -p "$EMBREE_DRIVER"
g++ -O3 -std=c++17 -shared -fPIC embree.cpp -lembree3 -o "$EMBREE_DRIVER/libembree_driver.so"
exec cargo run --release --quiet -- "$@"
