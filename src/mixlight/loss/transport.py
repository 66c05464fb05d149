"""How far light has to move: the debiased Sinkhorn divergence of two distributions on the sphere."""

from __future__ import annotations

from typing import Literal, cast

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.autograd.function import FunctionCtx, once_differentiable

_OVER_RELAXATION = 1.7
"""Step length of the Sinkhorn updates. Plain Sinkhorn (1) contracts slowly on sharp distributions:
at epsilon .1, 30 updates leave a median error of 1e-9 but a worst one of .2 in the potentials; with 1.7
the worst is 1e-4 (Thibault et al., Overrelaxed Sinkhorn-Knopp, 2021)."""

_TRUST = 2.0
"""Updates larger than this many epsilon are taken plainly: over-relaxation is sure to converge only near
the solution, and can run off from farther away."""

_KERNEL_LIMIT = 300.0
"""Up to this ratio of the largest cost to epsilon, exp(-cost/epsilon) and its inverse, with room for
overshoot, fit into float64, and a soft minimum is one matrix product."""


class SphericalSinkhorn(nn.Module):
    """Sinkhorn divergence S(a, b) = OT(a, b) - OT(a, a)/2 - OT(b, b)/2 of masses on fixed directions.

    OT is entropy-regularised optimal transport, relative to the product of the two distributions:

        OT(a, b) = min over plans with marginals a, b of  sum of plan * cost + epsilon KL(plan | a b^T)

    A squared error sees light on a wrong anchor as equally wrong wherever it is; this loss asks how far away.
    It is 0 for equal distributions, and for two single lights exactly the cost between them. With
    the geodesic cost it is never negative (exp(-angle/epsilon) is a positive definite kernel
    on the sphere); with its square it can be, slightly.

    Potentials are iterated in the log domain in float64, batched, over a falling epsilon. The gradient
    is the potentials themselves (envelope theorem), so backward costs nothing; there is no second derivative.
    At an anchor that holds no mass at all it is the slope of the very first mass put there.

    Convention: masses may sum to anything: negative entries count as 0 (and get no gradient), the rest
    is divided by its sum, and no mass at all counts as an even distribution. Cost in radians (or
    radians squared): on 128 Vogel points a light moved from anchor 64 to the nearest other, 77,
    costs .297, and to the farthest, 60, 2.960.

    Source: Feydy et al., Interpolating between Optimal Transport and MMD using Sinkhorn Divergences, 2019.
    """

    cost: Tensor
    """[points, points] cost in float64."""

    def __init__(
        self,
        points: Float[Tensor, "points 3"],
        cost: Literal["geodesic", "geodesic2"] = "geodesic",
        epsilon: float = 0.1,
        iterations: int = 32,
    ) -> None:
        """Set up the cost matrix of fixed unit directions.

        Args:
            points: Unit directions of the masses.
            cost: The angle between two directions, or its square.
            epsilon: Blur, in units of the cost. Well below the cost between neighbours (.28 rad for
                128 points) the divergence is close to unregularised transport; smaller needs more iterations.
            iterations: Updates of both potentials at the final epsilon. The default, at the default epsilon,
                leaves errors below 1e-5 in 90 of 100 gradients and 1e-10 in 98 of 100 values; pairs of a few
                isolated lights of very unequal strength can keep 1e-3 in the value. Epsilon .05 wants 60.

        Raises:
            ValueError: If points are no unit vectors, the cost is unknown, or a number is not positive.
        """
        super().__init__()
        if (
            points.ndim != 2
            or points.shape[-1] != 3
            or not torch.allclose(points.norm(dim=-1), points.new_ones(()), atol=1e-4)
        ):
            raise ValueError(
                f"expected unit directions of shape [points, 3], got shape {tuple(points.shape)}"
            )
        if cost not in ("geodesic", "geodesic2"):
            raise ValueError(f"expected cost 'geodesic' or 'geodesic2', got {cost!r}")
        if not epsilon > 0 or iterations < 1:
            raise ValueError(f"expected epsilon > 0 and iterations >= 1, got {epsilon} and {iterations}")
        angle = pairwise_angle(points.double())
        self.register_buffer("cost", angle if cost == "geodesic" else angle.square(), persistent=False)
        self._largest = float(self.cost.max())
        self.epsilon = float(epsilon)
        self.iterations = int(iterations)

    def forward(
        self, predicted: Float[Tensor, "*batch points"], true: Float[Tensor, "*batch points"]
    ) -> Float[Tensor, "*batch"]:
        """Divergence of each pair of distributions, in units of the cost; differentiable in both.

        Raises:
            ValueError: If the shapes differ or do not fit the number of points.

        >>> from mixlight.sphere.points import vogel
        >>> loss = SphericalSinkhorn(vogel(128))
        >>> light = torch.eye(128)
        >>> round(loss(light[64], light[77]).item(), 2), round(loss(light[64], light[64]).item(), 2)
        (0.3, 0.0)
        """
        count = self.cost.shape[0]
        if predicted.shape != true.shape or predicted.ndim < 1 or predicted.shape[-1] != count:
            raise ValueError(
                f"expected two distributions of shape [..., {count}],"
                f" got {tuple(predicted.shape)} and {tuple(true.shape)}"
            )
        batch = predicted.shape[:-1]
        a = _distribution(predicted).reshape(-1, count)
        b = _distribution(true).reshape(-1, count)
        value = _Divergence.apply(  # type: ignore[no-untyped-call]
            a, b, self.cost, self._largest, self.epsilon, self.iterations
        )
        return cast(Tensor, value).reshape(batch).to(predicted.dtype)


def pairwise_angle(points: Float[Tensor, "points 3"]) -> Float[Tensor, "points points"]:
    """Angle between each two unit vectors in radians, accurate for near and for opposite ones.

    2 atan2(|x - y|, |x + y|)

    >>> pairwise_angle(torch.tensor([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))[0].tolist()
    [0.0, 1.5707963705062866]
    """
    x, y = points[:, None], points[None]
    return 2 * torch.atan2((x - y).norm(dim=-1), (x + y).norm(dim=-1))


def _distribution(mass: Tensor) -> Tensor:
    """Non-negative float64 that sums to exactly 1; a trace of even mass makes "none" well defined."""
    positive = mass.double().clamp(min=0)
    trace = 1e-12
    return (positive + trace / mass.shape[-1]) / (positive.sum(-1, keepdim=True) + trace)


class _Divergence(torch.autograd.Function):
    """S(a, b) of [batch, points] distributions; the gradient is the difference of the potentials."""

    @staticmethod
    def forward(
        ctx: FunctionCtx,
        a: Tensor,
        b: Tensor,
        cost: Tensor,
        largest_cost: float,
        epsilon: float,
        iterations: int,
    ) -> Tensor:
        cost = cost.double()
        with torch.autocast(a.device.type, enabled=False):
            f, g, self_a, self_b = _potentials(a, b, cost, largest_cost, epsilon, iterations)
        # The constant that potentials are free up to cancels in the value, for a and b have equal mass.
        slope_a, slope_b = f - self_a, g - self_b
        ctx.save_for_backward(slope_a, slope_b)
        return (a * slope_a).sum(-1) + (b * slope_b).sum(-1)

    @staticmethod
    @once_differentiable
    def backward(ctx: FunctionCtx, gradient: Tensor) -> tuple[Tensor, Tensor, None, None, None, None]:
        slope_a, slope_b = ctx.saved_tensors  # type: ignore[attr-defined]
        return gradient[:, None] * slope_a, gradient[:, None] * slope_b, None, None, None, None


def _potentials(
    a: Tensor, b: Tensor, cost: Tensor, largest_cost: float, epsilon: float, iterations: int
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Dual potentials f, g of OT(a, b), and those of OT(a, a) and OT(b, b), each [batch, points]."""
    both = torch.cat((a, b))
    f, g = torch.zeros_like(a), torch.zeros_like(b)
    own = torch.zeros_like(both)
    level = largest_cost
    while level > epsilon:  # coarse to fine: each level starts from the potentials of the one before
        soft_min = _SoftMin(cost, largest_cost, level)
        f = soft_min(g, b)
        g = soft_min(f, a)
        own = (own + soft_min(own, both)) / 2
        level /= 2
    soft_min = _SoftMin(cost, largest_cost, epsilon)
    for _ in range(iterations):
        f = _relaxed(f, soft_min(g, b), epsilon)
        g = _relaxed(g, soft_min(f, a), epsilon)
    # A plain update of both removes what over-relaxation leaves, and reaches the points without mass.
    f = soft_min(g, b)
    g = soft_min(f, a)
    for _ in range(max(4, iterations // 2)):  # a fixed point of its own, far quicker than the pair
        own = (own + soft_min(own, both)) / 2
    own = soft_min(own, both)
    return f, g, own[: len(a)], own[len(a) :]


def _relaxed(old: Tensor, new: Tensor, epsilon: float) -> Tensor:
    """The update, lengthened wherever it is small enough to be trusted; decided for each distribution."""
    change = new - old
    near = change.abs().amax(-1, keepdim=True) <= _TRUST * epsilon
    return old + torch.where(near, _OVER_RELAXATION, 1.0) * change


class _SoftMin:
    """-epsilon log of sum over j of mass_j exp((potential_j - cost_ij) / epsilon)."""

    def __init__(self, cost: Tensor, largest_cost: float, epsilon: float) -> None:
        self.epsilon = epsilon
        self.cost = cost
        self.kernel = torch.exp(-cost / epsilon) if largest_cost <= _KERNEL_LIMIT * epsilon else None

    def __call__(self, potential: Tensor, mass: Tensor) -> Tensor:
        if self.kernel is not None:
            return ((mass * (potential / self.epsilon).exp()) @ self.kernel).log() * -self.epsilon
        exponent = mass.log() + potential / self.epsilon
        return torch.logsumexp(exponent[:, None, :] - self.cost / self.epsilon, -1) * -self.epsilon
