# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks an OCI image by its digests, unpacks it and runs its entry point on a scene as a container would: try_image.py IMAGE.tar"""

import gzip
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

SCENE = "/usr/share/signorini/scenes/block.toml"


def main() -> int:
    with tempfile.TemporaryDirectory(dir=Path(sys.argv[1]).parent) as scratch:
        layout, root = Path(scratch) / "layout", Path(scratch) / "root"
        with tarfile.open(sys.argv[1]) as archive:
            archive.extractall(layout, filter="data")

        def blob(descriptor: dict) -> Path:
            path = layout / "blobs" / "sha256" / descriptor["digest"].removeprefix("sha256:")
            with open(path, "rb") as content:
                assert hashlib.file_digest(content, "sha256").hexdigest() == path.name, "a digest is wrong"
            assert path.stat().st_size == descriptor["size"]
            return path

        (entry,) = json.loads((layout / "index.json").read_text())["manifests"]
        manifest = json.loads(blob(entry).read_text())
        config = json.loads(blob(manifest["config"]).read_text())
        (layer,) = manifest["layers"]
        with gzip.open(blob(layer)) as files:
            assert "sha256:" + hashlib.file_digest(files, "sha256").hexdigest() == config["rootfs"]["diff_ids"][0]
        root.mkdir()
        subprocess.run(["tar", "--extract", "--gzip", "--exclude=./dev/*", "--file", blob(layer), "--directory", root], check=True)
        shutil.rmtree(layout)
        environment = dict(one.split("=", 1) for one in config["config"]["Env"])

        def run(*words: str) -> str:
            command = ["unshare", "--mount", "--pid", "--fork", "sh", "-euc",
                       'mount -t proc proc "$0/proc"; mount --rbind /dev "$0/dev"; root=$0; exec chroot "$root" "$@"', root]  # fmt: skip
            shell = ["/bin/sh", "-euc", f'cd {config["config"]["WorkingDir"]}; exec "$@"', "sh"]
            done = subprocess.run([*command, *shell, *config["config"]["Entrypoint"], *words], env=os.environ | environment | {"PATH": f"{environment['PATH']}:{os.environ['PATH']}"}, capture_output=True, text=True)
            assert done.returncode == 0, done.stdout + done.stderr
            return done.stdout

        print("try:", run("--version").splitlines()[0])
        run("simulate", SCENE)
        run("report", "results/block")
        found = json.loads((root / "work" / "results" / "block" / "run.json").read_text())
        assert found["steps"]["done"] > 0 and (root / "work" / "results" / "block" / "report.html").stat().st_size > 1e5
        size = sum(file.stat().st_size for file in root.rglob("*") if file.is_file() and not file.is_symlink())
        print(f"try: {found['steps']['done']} steps of {SCENE} in the image, and a page; {size / 1e6:.0f} MB unpacked")
    return 0


if __name__ == "__main__":
    sys.exit(main())
