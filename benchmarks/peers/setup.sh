#!/usr/bin/env bash
# Install the programs that the benchmarks compare with, in their own environment benchmarks/.peers.
#
#   benchmarks/peers/setup.sh              the renderers of cornell.py; uses python3.11 where there is one (bpy needs it)
#   benchmarks/peers/setup.sh view-factors the view-factor programs of factors.py, without the renderers
#   PYTHON=/path/to/python3.11 benchmarks/peers/setup.sh
#
# What cannot be installed is explained and left out; the benchmark then reports it as not available.
set -u
cd "$(dirname "$0")/.." || exit 1
python=${PYTHON:-$(command -v python3.11 || command -v python3)}
venv=.peers
missing=0

explain() {
    missing=1
    printf '\n' >&2
    printf '%s\n' "$@" >&2
}

install() {
    "$venv/bin/pip" install --quiet --disable-pip-version-check "$@"
}

[ -x "$venv/bin/python" ] || "$python" -m venv "$venv" || exit 1

if [ "${1:-renderers}" = view-factors ]; then
    install "pyviewfactor==1.1.0" numpy ||
        explain "pyviewfactor 1.1.0 could not be installed from PyPI."
    install "raystrack==2.0.0" scipy numpy ||
        explain "raystrack 2.0.0, Numba and SciPy could not be installed; the exact values of pairs need the last two."
    [ -n "${VIEW3D:-}" ] || command -v View3D >/dev/null || command -v view3d >/dev/null ||
        explain "View3D is not on PyPI. If you have its executable, set VIEW3D to its path or put it in PATH."
    [ "$missing" = 0 ] && echo "All view-factor programs are ready in benchmarks/$venv."
    exit 0
fi

install "mitsuba==3.9.1" numpy ||
    explain "Mitsuba 3.9.1 could not be installed from PyPI."
install "bpy==4.5.*" numpy ||
    explain "bpy 4.5 could not be installed: it needs Python 3.11, and $("$venv/bin/python" -V) is here." \
        "Remove benchmarks/$venv and run this script again with PYTHON=/path/to/python3.11."

# Mitsuba's llvm variants load LLVM 17 or later at run time; DRJIT_LIBLLVM_PATH chooses a file.
llvm_works() {
    "$venv/bin/python" -c 'from peers.peer_mitsuba import start_backend; start_backend(2)' 2>/dev/null
}

if ! llvm_works && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update --quiet=2 && apt-get install --yes --quiet=2 --no-install-recommends libllvm19
fi
llvm_works || explain "Mitsuba's llvm variant does not start: it wants the shared library of LLVM 17 or later." \
    "As root: apt-get install libllvm19 (Debian 12 or later)." \
    "Without root: apt-get download libllvm19 && dpkg -x libllvm19_*.deb DIR, then" \
    "  export DRJIT_LIBLLVM_PATH=DIR/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1" \
    "  (on other machines the name of the last folder but one differs)"

"$venv/bin/python" -c 'import bpy' 2>/dev/null ||
    explain "bpy does not import; it may lack system libraries. The message is:" \
        "$("$venv/bin/python" -c 'import bpy' 2>&1 | tail -n 1)"

[ "$missing" = 0 ] && echo "All peers are ready in benchmarks/$venv."
exit 0
