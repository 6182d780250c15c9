"""Ways to the same solution agree: condensed and full VI; one, two and three ranks."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, relative, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402


def displacements(out: Path) -> list[np.ndarray]:
    """One array per stored time."""
    with h5py.File(out / "state.h5") as file:
        states = file["Function/displacement"]
        return [states[name][:] for name in sorted(states)]


def same_sets(a: Path, b: Path) -> bool:
    """Whether the same candidates carry a force at all steps."""
    ta, tb = table(a / "contact.csv"), table(b / "contact.csv")
    assert (ta["force"] > 0).any(), "no contact: the comparison says nothing"
    return np.array_equal(ta["force"] > 0, tb["force"] > 0) and np.allclose(ta["x"], tb["x"], rtol=0, atol=1e-9)


def compare_vi(folder: Path) -> bool:
    holds = True
    cases = [("half-disc", HALF_DISC, {"control__initial": ["0", "-1"]}),
             ("half-disc, degree 2", HALF_DISC, {"control__initial": ["0", "-1"], "mesh__size": 1.5, "mesh__degree": 2}),
             ("block on a tilted plane", SOURCE / "tests/data/block.toml", {"mesh__size": 0.1})]  # fmt: skip
    for name, scene, overrides in cases:
        condensed, full = folder / "condensed", folder / "full"
        signorini("simulate", scene, condensed, **overrides)
        signorini("simulate", scene, full, solver__vi="full", **overrides)
        pairs = list(zip(displacements(condensed), displacements(full), strict=True))
        size = max(abs(a).max() for a, _ in pairs)
        difference = max(abs(a - b).max() for a, b in pairs) / size
        sets = same_sets(condensed, full)
        print(f"{name}: condensed and full VI differ by {difference:.1e} of the largest displacement, "
              f"active sets {'equal' if sets else 'differ'} at all {len(pairs) - 1} steps")  # fmt: skip
        holds &= difference <= 1e-10 and sets
    return holds


def compare_ranks(folder: Path) -> bool:
    """J and |g| at a fixed control; after three iterations too, where the step lengths, which come from small
    differences of J, have amplified the rounding."""
    histories = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks-{ranks}"
        signorini("optimize", HALF_DISC, out, ranks, optimizer__max_iterations=3, control__initial=["0", "-0.9"])
        histories.append(table(out / "history.csv"))
        print("{} ranks: J = {:.15e}, |g| = {:.15e}; after 3 iterations {:.15e}, {:.15e}".format(
            ranks, *(histories[-1][key][row] for row in (0, 3) for key in ("objective", "gradient_norm"))))  # fmt: skip
        assert same_sets(folder / "ranks-1", out)

    def worst(row: int) -> float:
        return max(relative(other[key][row], histories[0][key][row])
                   for other in histories[1:] for key in ("objective", "gradient_norm"))  # fmt: skip

    print(f"largest relative difference over the ranks: {worst(0):.1e}, after 3 iterations {worst(3):.1e}")
    return worst(0) <= 1e-9 and worst(3) <= 1e-6


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        vi, ranks = compare_vi(Path(folder)), compare_ranks(Path(folder))
    return 0 if vi and ranks else 1


if __name__ == "__main__":
    raise SystemExit(main())
