# SPDX-License-Identifier: GPL-3.0-or-later
"""A network that throws: for a wanted height it gives the force over time under which a soft block throws a ball that high. It learns by the
exact gradient through lift-off and impacts, from four heights, and is asked for two that it has not seen.

    ./dev exec python3 python/examples/torch_throw.py
"""

from pathlib import Path

import torch

import signorini
import signorini.torch

SCENE = Path(__file__).parents[2] / "scenes" / "throw.toml"
SEEN, UNSEEN = (0.25, 0.35, 0.45, 0.55), (0.3, 0.5)
STEPS, KNOTS = 200, 16


def problem_of(height: float) -> signorini.Problem:
    wanted = {"objective.desired.displacement": ["0", str(height)]}
    return signorini.Scene(SCENE, {"mesh.size": 0.1, "time.step": 2e-3, **wanted}).problem()


torch.manual_seed(0)
torch.set_default_dtype(torch.float64)
problems = {height: problem_of(height) for height in (*SEEN, *UNSEEN)}
J = {height: signorini.torch.function(problem) for height, problem in problems.items()}
one = problems[SEEN[0]]
times = torch.tensor(one.times) / one.step_times[-1]
hats = (1 - (times[:, None] - torch.linspace(0, 1, KNOTS)).abs() * (KNOTS - 1)).clamp(min=0)  # linear between knots in time
network = torch.nn.Sequential(torch.nn.Linear(1, 16), torch.nn.Tanh(), torch.nn.Linear(16, KNOTS))


def control(height: float) -> torch.Tensor:
    """The force that the network gives, within the scene's bounds, the same at all nodes of the lower side."""
    force = hats @ (10 * torch.tanh(network(torch.tensor([height]))))
    return force[:, None].expand(one.shape)


def miss(height: float) -> float:
    """How far the ball is from the wanted height in the end, m."""
    problem = problems[height]
    with torch.no_grad():
        terminal = problem.parts(control(height).numpy().copy()).terminal
    return (2 * terminal) ** 0.5


optimizer = torch.optim.Adam(network.parameters(), lr=0.02)
schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, STEPS)
for step in range(STEPS):
    optimizer.zero_grad()
    loss = sum(J[height](control(height)) for height in SEEN) / len(SEEN)
    loss.backward()
    optimizer.step()
    schedule.step()
    if step % 20 == 0 or step == STEPS - 1:
        print(f"{step:3d}  mean J = {loss.item():.6f}", flush=True)
for height in (*SEEN, *UNSEEN):
    print(f"{height:.2f} m wanted: missed by {1e3 * miss(height):.1f} mm{'' if height in SEEN else ', not seen before'}")
