"""What single corrections of the paper change, where no map has to be rendered to see it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from scipy.optimize import linear_sum_assignment
from torch import Tensor

from experiments.numbers import distribution_of
from mixlight.light import gaussians, harmonics
from mixlight.light.fit import ANCHORS
from mixlight.light.gaussians import SHARPNESS
from mixlight.loss.transport import SphericalSinkhorn
from mixlight.network.sparsemax import MODES, slsparsemax
from mixlight.sphere import equirect, points

HEIGHT = 128
"""Rows of the maps."""
NOISE = (0.005, 0.01, 0.02)


def gram() -> dict[str, Any]:
    """Gram matrix of the nine functions under both sums; the identity is what a projection needs.

    The plain sum is worst where the harmonics' own pole (z) is the panorama's, as textbooks and the paper
    have it; in our frame the panorama's pole is y.
    """
    directions = equirect.pixel_directions(HEIGHT, dtype=torch.float64).flatten(0, 1)
    exact = equirect.solid_angle(HEIGHT, dtype=torch.float64).flatten()
    plain = torch.full_like(exact, 4 * math.pi / len(exact))
    x, y, z = directions.unbind(-1)
    turned = torch.stack((z, x, y), -1)  # y, the panorama's pole, becomes the harmonics' z
    sides = {
        "with solid angle": (directions, exact),
        "4 pi / (w h), our frame": (directions, plain),
        "4 pi / (w h), one pole for both": (turned, plain),
    }
    result = {}
    for name, (where, weight) in sides.items():
        basis = harmonics.basis(where)
        matrix = basis.T @ (weight[:, None] * basis)
        diagonal = matrix.diagonal()
        result[f"Gram matrix, {name}"] = {
            "smallest on the diagonal": float(diagonal.min()),
            "largest on the diagonal": float(diagonal.max()),
            "largest off the diagonal": float((matrix - torch.diag(diagonal)).abs().max()),
        }
    return result


def normaliser() -> dict[str, float]:
    """A lobe's normaliser with the paper's exponent -2s, over the right one with -2/s."""
    paper = 1 / (2 * math.pi * SHARPNESS * (1 - math.exp(-2 * SHARPNESS)))
    axis = points.vogel(ANCHORS)[64:65]
    lobe = gaussians.evaluate_map(axis, torch.ones(1, 1), SHARPNESS, HEIGHT, conserve=False)
    return {
        "q": gaussians.normaliser(SHARPNESS),
        "q of the paper": paper,
        "factor": paper / gaussians.normaliser(SHARPNESS),
        "integral of a lobe on 128x256 with q": float(equirect.integrate(lobe)[0]),
    }


def intensity(facts: dict[str, list[float]]) -> dict[str, Any]:
    """What the network has to regress when E is the squared norm and R = T / E."""
    values = np.array(facts["E"])
    decades = np.log10(np.quantile(values, 0.95) / np.quantile(values, 0.05))
    return {
        "E": distribution_of(values),
        "decades of E from p5 to p95": float(decades),
        "decades of E squared from p5 to p95": float(2 * decades),
        "length of R = T / E squared": distribution_of(1 / values),
    }


def transport() -> dict[str, Any]:
    """A unit light on a wrong anchor: what it costs, near and far."""
    axes = points.vogel(ANCHORS)
    loss = SphericalSinkhorn(axes)
    light = torch.eye(ANCHORS)
    near = points.neighbours(axes, 1)[:, 0]
    far = (axes @ axes.T).argmin(1)
    generator = torch.Generator().manual_seed(0)
    dense = torch.softmax(2 * torch.randn(2, 64, ANCHORS, generator=generator), -1).double()
    moved, stayed = torch.cat([light[near], light[far]]).double(), torch.cat([light, light]).double()
    released = torch.cat([_emlight_loss(axes, moved, stayed), _emlight_loss(axes, dense[0], dense[1])])
    error = torch.cat([moved - stayed, dense[0] - dense[1]]).square().mean(-1)
    return {
        "Sinkhorn divergence (radians)": {
            "next": distribution_of(loss(light[near], light).tolist()),
            "antipode": distribution_of(loss(light[far], light).tolist()),
            "anchor 64 to 77": float(loss(light[64], light[77])),
            "anchor 64 to 60": float(loss(light[64], light[60])),
        },
        "EMLight as released": {
            "next": distribution_of(released[:ANCHORS].tolist()),
            "antipode": distribution_of(released[ANCHORS : 2 * ANCHORS].tolist()),
            "over the mean squared error, all moves and 64 dense pairs": distribution_of(
                (released / error).tolist()
            ),
        },
    }


def _emlight_loss(axes: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """EMLight's released transport loss without its entropic blur.

    The points are evenly weighted, and the masses x and y stand in the cost:
    (.1 (x_i - y_j)^2 + |u_i - u_j|) / 2. Even weights make optimal transport an assignment.
    """
    chord = torch.cdist(axes.double(), axes.double()).fill_diagonal_(0)
    values = []
    for a, b in zip(x, y, strict=True):
        cost = ((0.1 * (a[:, None] - b) ** 2 + chord) / 2).numpy()
        values.append(cost[linear_sum_assignment(cost)].sum() / len(axes))
    return torch.tensor(values, dtype=torch.float64)


def sparse(true: Tensor) -> dict[str, Any]:
    """The sparse layer's modes on noisy distributions."""
    axes = points.vogel(ANCHORS)
    neighbours = points.neighbours(axes, 6)
    loss = SphericalSinkhorn(axes)
    generator = torch.Generator().manual_seed(0)
    result: dict[str, Any] = {
        "input": "true P of top_fraction 0.05, as it is or averaged with its six neighbours, plus normal "
        "noise of standard deviation sigma, seed 0",
        "active anchors of the true P": distribution_of((true > 1e-4).sum(-1).tolist()),
    }
    # A regression blurs as well: each share is also averaged with those of the six neighbours.
    blurred = (true + true[:, neighbours].sum(-1)) / (1 + neighbours.shape[1])
    for name, mean in (("", true), (", blurred", blurred / blurred.sum(-1, keepdim=True))):
        for sigma in NOISE:
            noisy = mean + sigma * torch.randn(true.shape, generator=generator)
            rows = {}
            for mode in MODES:
                out = slsparsemax(noisy, neighbours, mode)
                total = out.clamp(min=0).sum(-1)
                rows[mode] = {
                    "sum": distribution_of(total.tolist()),
                    "active anchors": distribution_of((out > 1e-4 * total[:, None]).sum(-1).tolist()),
                    "squared error": distribution_of((out - true).square().sum(-1).tolist()),
                    "transport": distribution_of(loss(out, true).tolist()),
                }
            result[f"sigma {sigma:g}{name}"] = rows
    logits = torch.randn(1000, ANCHORS, generator=generator)
    result["sum of the literal mode on standard normal scores"] = distribution_of(
        slsparsemax(logits, neighbours, "literal").sum(-1).tolist()
    )
    soft = torch.softmax(logits, -1)
    result["largest change after a softmax"] = float((slsparsemax(soft, neighbours) - soft).abs().max())
    return result


def exposure(gains: Sequence[float], groups: Sequence[str]) -> dict[str, Any]:
    """A gain that is worked out after the response curve x^(1/2.4) and multiplied onto linear light."""
    wrong = np.array(gains) ** (1 / 2.4 - 1)  # applied gain over the right one
    names = sorted(set(groups))
    within = [np.ptp(np.log(wrong[[g == name for g in groups]])) for name in names]
    return {
        "target over truth": distribution_of(wrong),
        "largest over smallest among the views of one panorama": distribution_of(np.exp(within)),
    }
