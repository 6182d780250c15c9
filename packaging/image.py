# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes an OCI image with the program as its entry point from an archive of a file system: image.py FILES.tar OUT.tar VERSION

Equal files give an equal image. Source: https://github.com/opencontainers/image-spec
"""

import gzip
import hashlib
import io
import json
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import BinaryIO

BLOCK = 1 << 20
# Open MPI in a container runs as root, and finds no other host.
ENVIRONMENT = {"PATH": "/usr/local/bin:/usr/bin:/bin", "LC_ALL": "C.UTF-8", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "MPLBACKEND": "Agg"}  # fmt: skip


class Layout:
    """Archive of an image whose files are named by their digests."""

    def __init__(self, out: Path) -> None:
        self.tar = tarfile.open(out, "w")

    def add(self, name: str, content: BinaryIO, size: int) -> None:
        entry = tarfile.TarInfo(name)
        entry.size, entry.mode = size, 0o644
        self.tar.addfile(entry, content)

    def add_json(self, kind: str, content: dict) -> dict:
        """Adds a document and returns its descriptor."""
        text = json.dumps(content, sort_keys=True, separators=(",", ":")).encode()
        digest = hashlib.sha256(text).hexdigest()
        self.add(f"blobs/sha256/{digest}", io.BytesIO(text), len(text))
        return {"mediaType": f"application/vnd.oci.image.{kind}.v1+json", "digest": f"sha256:{digest}", "size": len(text)}

    def add_layer(self, files: Path) -> tuple[dict, str]:
        """Adds the compressed file system; returns its descriptor and the digest of the archive."""
        plain, packed = hashlib.sha256(), hashlib.sha256()
        with tempfile.TemporaryFile(dir=files.parent) as scratch:
            with open(files, "rb") as source, gzip.GzipFile(fileobj=scratch, mode="wb", compresslevel=6, mtime=0) as compressed:
                while block := source.read(BLOCK):
                    plain.update(block)
                    compressed.write(block)
            size = scratch.tell()
            scratch.seek(0)
            while block := scratch.read(BLOCK):
                packed.update(block)
            scratch.seek(0)
            self.add(f"blobs/sha256/{packed.hexdigest()}", scratch, size)
        descriptor = {"mediaType": "application/vnd.oci.image.layer.v1.tar+gzip", "digest": f"sha256:{packed.hexdigest()}", "size": size}
        return descriptor, f"sha256:{plain.hexdigest()}"


def main() -> None:
    files, out, version = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    layout = Layout(out)
    layer, archive = layout.add_layer(files)
    config = layout.add_json("config", {
        "architecture": "amd64", "os": "linux",
        "config": {
            "Entrypoint": ["/usr/bin/signorini"], "Cmd": ["--help"], "WorkingDir": "/work",
            "Env": [f"{name}={value}" for name, value in ENVIRONMENT.items()],
            "Labels": {"org.opencontainers.image.title": "signorini", "org.opencontainers.image.version": version,
                       "org.opencontainers.image.licenses": "GPL-3.0-or-later"},
        },
        "rootfs": {"type": "layers", "diff_ids": [archive]},
    })  # fmt: skip
    manifest = layout.add_json("manifest", {"schemaVersion": 2, "mediaType": "application/vnd.oci.image.manifest.v1+json",
                                            "config": config, "layers": [layer]})  # fmt: skip
    manifest["annotations"] = {"org.opencontainers.image.ref.name": version, "io.containerd.image.name": f"localhost/signorini:{version}"}
    for name, content in (("index.json", {"schemaVersion": 2, "manifests": [manifest]}), ("oci-layout", {"imageLayoutVersion": "1.0.0"})):
        text = json.dumps(content).encode()
        layout.add(name, io.BytesIO(text), len(text))
    layout.tar.close()


if __name__ == "__main__":
    main()
