"""Ways to the same solution agree: condensed, full VI, conjugate gradients; one, two and three ranks."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, HALF_DISC, SOURCE, relative, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402


# The half ball at its reference control, coarse enough to be quick.
PUSHED = {"control__initial": ["0", "0", "-1"], "mesh__size": 3, "time__step": 2.5e-4}
# 9 degrees off the horizontal, 0.56 m below the ball: it touches beside its lowest point, and is pushed along the plane.
TILTED = {"contact__obstacle__point": [0, 0, -15.75], "contact__obstacle__normal": [0.1, -0.12, 1]}


def displacements(out: Path) -> list[np.ndarray]:
    """One array per stored time."""
    with h5py.File(out / "state.h5") as file:
        states = file["Function/displacement"]
        return [states[name][:] for name in sorted(states)]


def same_sets(a: Path, b: Path) -> bool:
    """Whether the same candidates carry a force at all steps."""
    ta, tb = table(a / "contact.csv"), table(b / "contact.csv")
    assert (ta["force"] > 0).any(), "no contact: the comparison says nothing"
    places = all(np.allclose(ta[axis], tb[axis], rtol=0, atol=1e-9) for axis in "xyz" if axis in ta)
    return np.array_equal(ta["force"] > 0, tb["force"] > 0) and places


def compare_solvers(folder: Path) -> bool:
    holds = True
    cases = [("half-disc", HALF_DISC, {"control__initial": ["0", "-1"]}),
             ("half-disc, degree 2", HALF_DISC, {"control__initial": ["0", "-1"], "mesh__size": 1.5, "mesh__degree": 2}),
             ("block on a tilted plane", SOURCE / "tests/data/block.toml", {"mesh__size": 0.1}),
             ("half ball", HALF_BALL, PUSHED),
             ("half ball, degree 2", HALF_BALL, PUSHED | {"mesh__size": 4, "mesh__degree": 2}),
             ("half ball on a tilted plane", HALF_BALL, PUSHED | TILTED)]  # fmt: skip
    for name, scene, overrides in cases:
        condensed = folder / "condensed"
        signorini("simulate", scene, condensed, solver__linear="direct", **overrides)
        # Conjugate gradients leave 1e-12 of the solution's size at each of up to 150 steps.
        for title, other, allowed in (("full VI", {"solver__vi": "full"}, 1e-10),
                                      ("conjugate gradients", {"solver__linear": "iterative"}, 1e-9)):  # fmt: skip
            out = folder / "other"
            signorini("simulate", scene, out, **(overrides | other))
            pairs = list(zip(displacements(condensed), displacements(out), strict=True))
            size = max(abs(a).max() for a, _ in pairs)
            difference = max(abs(a - b).max() for a, b in pairs) / size
            sets = same_sets(condensed, out)
            print(f"{name}: condensed and {title} differ by {difference:.1e} of the largest displacement, "
                  f"active sets {'equal' if sets else 'differ'} at all {len(pairs) - 1} steps")  # fmt: skip
            holds &= difference <= allowed and sets
    return holds


def compare_ranks(folder: Path, scene: Path, **overrides: object) -> bool:
    """J and |g| at a fixed control; after three iterations too, where the step lengths, which come from small
    differences of J, have amplified the rounding."""
    histories = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks-{ranks}"
        signorini("optimize", scene, out, ranks, optimizer__max_iterations=3, **overrides)
        histories.append(table(out / "history.csv"))
        print("{} ranks: J = {:.15e}, |g| = {:.15e}; after 3 iterations {:.15e}, {:.15e}".format(
            ranks, *(histories[-1][key][row] for row in (0, 3) for key in ("objective", "gradient_norm"))))  # fmt: skip
        assert same_sets(folder / "ranks-1", out)

    def worst(row: int) -> float:
        return max(relative(other[key][row], histories[0][key][row])
                   for other in histories[1:] for key in ("objective", "gradient_norm"))  # fmt: skip

    print(f"{scene.stem}: largest relative difference over the ranks {worst(0):.1e}, after 3 iterations {worst(3):.1e}")
    return worst(0) <= 1e-9 and worst(3) <= 1e-6


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        holds = [compare_solvers(Path(folder)), compare_ranks(Path(folder), HALF_DISC, control__initial=["0", "-0.9"]),
                 compare_ranks(Path(folder), HALF_BALL, **(PUSHED | {"control__initial": ["0", "0", "-0.9"]}))]  # fmt: skip
    return 0 if all(holds) else 1


if __name__ == "__main__":
    raise SystemExit(main())
