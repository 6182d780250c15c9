#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Inside a fresh tree of Debian with an archive of the sources in /given: builds it by CMake and by pip and runs both. Run by
# ./dev package --source --try, as root.
set -eu

say() { printf '%s\n' "try: $*"; }
fail() { say "$*"; exit 1; }
apt() {
  DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o Dir::Cache::Archives=/var/cache/apt/archives -o APT::Keep-Downloaded-Packages=true \
    -o DPkg::Options::=--force-unsafe-io "$@" >/tmp/apt.log 2>&1 || { tail -n 30 /tmp/apt.log; fail "apt-get $1 failed"; }
}
quietly() { "$@" >/tmp/log 2>&1 || { tail -n 40 /tmp/log; fail "$1 failed"; }; }
seconds() { date +%s; }

export HOME=/root # without which Open MPI's compilers crash
export CCACHE_DIR=/ccache CCACHE_NOHASHDIR=1 CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
mkdir /build
cd /build
tar xzf /given/signorini-*.tar.gz
sources=$(echo /build/signorini-*)
[ ! -e "$sources/.git" ] || fail "the archive has git's files"
apt update
apt install --no-install-recommends $(sed -e 's/#.*//' "$sources/.packages") nanobind-dev python3-build python3-dev python3-pip python3-scikit-build-core python3-venv
command -v git >/dev/null && fail "git is there, which the build must not need"

start=$(seconds)
quietly cmake -S "$sources" -B /build/cmake -G Ninja -DCMAKE_UNITY_BUILD=ON -DBUILD_TESTING=OFF -DCMAKE_INSTALL_PREFIX=/opt/signorini
quietly cmake --build /build/cmake
quietly cmake --install /build/cmake
cd /tmp
quietly /opt/signorini/bin/signorini simulate /opt/signorini/share/signorini/scenes/block.toml --out /tmp/by-cmake
say "by CMake without git: $(($(seconds) - start)) s, $(du -sm /opt/signorini | cut -f1) MB installed"

start=$(seconds)
export CMAKE_ARGS=-DCMAKE_UNITY_BUILD=ON
(cd "$sources" && quietly python3 -m build --sdist --no-isolation --skip-dependency-check --outdir /tmp/sdist .)
quietly python3 -m venv --system-site-packages /tmp/venv
quietly /tmp/venv/bin/pip install --no-build-isolation --no-index --no-deps /tmp/sdist/signorini-*.tar.gz
say "by pip from an sdist of $(du -k /tmp/sdist/signorini-*.tar.gz | cut -f1) kB: $(($(seconds) - start)) s, $(du -sm /tmp/venv | cut -f1) MB installed"
quietly /tmp/venv/bin/signorini simulate /tmp/venv/share/signorini/scenes/block.toml --out /tmp/by-pip
/tmp/venv/bin/python3 - <<'END' || fail "the module that pip installed does not work"
import signorini
import numpy as np
assert signorini.__file__.startswith("/tmp/venv/"), signorini.__file__
runs = [signorini.read(f"/tmp/by-{name}") for name in ("cmake", "pip")]
energies = [run.steps["kinetic_energy"] for run in runs]
assert np.array_equal(*energies), "the two programs differ"
scene = signorini.Scene("/tmp/venv/share/signorini/scenes/half-disc.toml", {"mesh.size": 3})
problem = scene.problem()
J, derivative = problem.value_and_gradient(problem.first_guess())
assert J > 0 and derivative.any()
print(f"try: J(0) = {J:.6e} from Python, and both programs made the same motion")
END
say "all of it holds"
