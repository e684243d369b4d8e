"""A simulation as a function that PyTorch differentiates: parameters in, positions of all nodes out.

    python3 torch_rollout.py SCENE.json
"""

import sys
from typing import Any, List, Tuple

import clothid
import torch  # type: ignore[import]


class RolloutPositions(torch.autograd.Function):  # type: ignore[misc]
    """positions (T + 1, N, 3) m of `scene` with the parameters `names` at `values` (P,), a tensor of doubles."""

    @staticmethod
    def forward(ctx: Any, values: Any, scene: clothid.Scene, names: List[str]) -> Any:
        ctx.rollout, ctx.names = clothid.Rollout(scene, dict(zip(names, values.tolist()))), names
        return torch.from_numpy(ctx.rollout.positions.copy())

    @staticmethod
    def backward(ctx: Any, gradient: Any) -> Tuple[Any, None, None]:
        return torch.from_numpy(ctx.rollout.pull_back(gradient.numpy(), ctx.names)), None, None


def fit(scene: clothid.Scene, names: List[str], start: List[float], measured: Any) -> Any:
    """The logarithms of parameters by L-BFGS."""
    logarithms = torch.log(torch.tensor(start, dtype=torch.float64)).requires_grad_()
    optimiser = torch.optim.LBFGS([logarithms], max_iter=30, line_search_fn="strong_wolfe", tolerance_change=1e-15)

    def cost() -> Any:
        optimiser.zero_grad()
        value = ((RolloutPositions.apply(torch.exp(logarithms), scene, names) - measured) ** 2).sum() * 1e4
        value.backward()
        return value

    optimiser.step(cost)
    return torch.exp(logarithms).detach()


if __name__ == "__main__":
    cloth = clothid.Scene(sys.argv[1])
    target = torch.from_numpy(clothid.simulate(cloth, {"mu": 0.25, "k_stretch": 80.0}).positions.copy())
    print(fit(cloth, ["mu", "k_stretch"], [0.4, 110.0], target))
