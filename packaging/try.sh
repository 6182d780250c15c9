#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Inside a fresh tree of Debian with nothing but /given: installs the packages and uses them as somebody would who has just
# found them. Run by ./dev package --try, as root.
set -eu

say() { printf '%s\n' "try: $*"; }
fail() { say "$*"; exit 1; }
# What apt downloads is kept outside of the tree, for the next one; a tree that is thrown away need not outlive a loss of power.
apt() {
  DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o Dir::Cache::Archives=/var/cache/apt/archives -o APT::Keep-Downloaded-Packages=true \
    -o DPkg::Options::=--force-unsafe-io "$@" >/tmp/apt.log 2>&1 || { tail -n 30 /tmp/apt.log; fail "apt-get $1 failed"; }
}
# By somebody without rights, from another folder than anything of the package.
user() { setpriv --reuid 1000 --regid 1000 --clear-groups env HOME=/home/newcomer sh -c "cd /home/newcomer && $*"; }

apt update
[ -z "$(find /usr -name 'libdolfinx*' -o -name 'libgmsh*')" ] || fail "this is no fresh tree"
apt install --no-install-recommends /given/signorini_*.deb
say "installed signorini: $(dpkg-query -W -f='${Version}' signorini), $(du -sm --exclude=/proc --exclude=/dev --exclude=/given --exclude=/var/cache / 2>/dev/null | cut -f1) MB in all"
[ -z "$(dpkg --verify signorini)" ] || fail "files of the package are not as it has them: $(dpkg --verify signorini)"
echo 'newcomer:x:1000:1000::/home/newcomer:/bin/sh' >>/etc/passwd
mkdir /home/newcomer
chown 1000:1000 /home/newcomer

user signorini --version
scene=/usr/share/signorini/scenes/half-disc.toml
user signorini optimize $scene --set mesh.size=1 | tail -n 5
results=/home/newcomer/results/half-disc
[ "$(stat -c %U $results/run.json)" = newcomer ] || fail "no results in the user's folder"
[ -z "$(find /usr/share/signorini -newer /given/try.sh -name results)" ] || fail "results were left in the package's folder"
user signorini report results/half-disc
user signorini figures results/half-disc --time 2e-3 >/tmp/figures
python3 - $results <<'END'
import json, sys
from pathlib import Path
folder = Path(sys.argv[1])
run = json.loads((folder / "run.json").read_text())
assert run["objective"]["value"] > 0 and run["optimizer"]["iterations"] > 3, run["objective"]
page = (folder / "report.html").read_text()
assert len(page) > 1e6 and "half-disc" in page
figures = sorted(file.name for file in (folder / "figures").iterdir() if file.stat().st_size > 5000)
assert {"objective.png", "control_magnitude.png", "contact_force.png", "energy.png"} <= set(figures), figures
print(f"try: J = {run['objective']['value']:.6e} after {run['optimizer']['iterations']} iterations ({run['stop_reason'] if 'stop_reason' in run else ''}), "
      f"a page of {len(page) / 1e6:.1f} MB, {len(figures)} figures")
END
user "python3 -c 'import signorini
problem = signorini.Scene(\"$scene\", {\"mesh.size\": 2}).problem()
J, derivative = problem.value_and_gradient(problem.first_guess())
assert J > 0 and derivative.shape == problem.shape and derivative.any()
print(f\"try: from Python J(0) = {J:.6e} at 2 m\")'" || fail "the Python module does not work"
dpkg --verify signorini | grep . && fail "using the package has changed its files"
status=0
user signorini figures /nowhere 2>/tmp/error || status=$?
[ $status = 2 ] && grep -q "^signorini figures: /nowhere" /tmp/error || fail "status $status and $(cat /tmp/error) for a folder that is not there"
[ -s /usr/share/man/man1/signorini.1.gz ] || fail "no manual"

say "installing libsignorini-dev, with a compiler"
apt install --no-install-recommends /given/libsignorini-dev_*.deb cmake g++ make
cp -R /given/own /home/newcomer/own
chown -R 1000:1000 /home/newcomer/own
user "cmake -S own -B own/build -DCMAKE_BUILD_TYPE=Release >own/log 2>&1 && cmake --build own/build >>own/log 2>&1" || { tail -n 30 /home/newcomer/own/log; fail "a program of one's own is not built"; }
user "own/build/own $scene mesh.size=2" | tee /tmp/own
grep -q '^J = [0-9.e-]*, |gradient| = [0-9.e-]*$' /tmp/own || fail "a program of one's own does not run"
apt purge libsignorini-dev signorini
[ ! -e /usr/share/signorini ] || fail "left behind: $(find /usr/share/signorini | head)"
say "all of it holds"
