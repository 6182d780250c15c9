# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders of batches with known numbers, as the program writes them."""

import csv
import json
from pathlib import Path

import numpy as np

QUANTITIES = {"impulse": ("impulse of contact", "N s/m"), "peak_force": ("peak force (two-step mean)", "N/m")}
ODD = 'soft, "wet" <b>&amp;'  # the name of a case
REASON = 'no solution at 0.012 s: "active set", <script>alert(1)</script>'


def write_batch(folder: Path, keys: list[str], cases: list[tuple], /, **changes: object) -> Path:
    """Writes a folder. `cases`: name, texts of the keys, and numbers of the quantities or why it failed. `changes`: of batch.json."""
    folder.mkdir(parents=True, exist_ok=True)
    failed = sum(isinstance(found, str) for _, _, found in cases)
    with open(folder / "cases.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", *keys, "outcome", "reason", "warnings", "steps", *QUANTITIES])
        for name, texts, found in cases:
            if isinstance(found, str):
                table.writerow([name, *texts, "failed", found, "", "", *[""] * len(QUANTITIES)])
            else:
                table.writerow([name, *texts, "done", "", "", 200, *("" if np.isnan(value) else f"{value:.17g}" for value in found)])
    manifest = {"verb": "batch", "scene": "block", "cases": len(cases), "done": len(cases) - failed, "failed": failed, "keys": keys,
                "quantities": {name: {"title": title, "unit": unit} for name, (title, unit) in QUANTITIES.items()}, "warnings": [], "seconds": 12.5,
                "blocks": [], "shard": None, "versions": {"signorini": "1.0", "dolfinx": "0.9.0"},
                "files": ["cases.csv", "batch.json", "scene.toml"]}  # fmt: skip
    (folder / "batch.json").write_text(json.dumps(manifest | changes, indent=1) + "\n")
    return folder


KEYS = ["material.young", "contact.friction", "contact.obstacle.point", "time.scheme", "mesh.size"]


def samples(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers a, b, c of each case, evenly spread and hardly correlated."""
    i = np.arange(1, count + 1)
    return tuple(i * root % 1 for root in (0.6180339887, 0.7548776662, 0.5698402910))


def write_linear(folder: Path, count: int = 60) -> tuple[Path, np.ndarray, np.ndarray]:
    """Writes a batch of y = 2 a - 3 b + a small perturbation, with a failed case, a text key, a fixed key, and a vector with one component
    that varies. Returns the folder, a, b, c of the cases that are done, and their quantities."""
    a, b, c = samples(count)
    y = 2 * a - 3 * b + 0.05 * np.sin(7.0 * np.arange(count))
    z = 1e3 * np.exp(5 * a) * (1 + 0.1 * b)
    cases = []
    for i in range(count):
        texts = [f"{a[i]:.17g}", f"{b[i]:.17g}", f"[0, {c[i]:.17g}]", "contact-stabilized" if i % 3 else "contact-implicit", "0.1"]
        cases.append((ODD if i == 0 else f"case {i + 1}", texts, REASON if i == 7 else [y[i], z[i]]))
    done = np.arange(count) != 7
    return write_batch(folder, KEYS, cases), np.stack([a, b, c], axis=1)[done], np.stack([y, z], axis=1)[done]
