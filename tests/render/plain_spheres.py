"""Protocol S's spheres the plain way: a ray for each pixel, a loop over pixels, a sum over all texels.

Written for itself from the formulas, in NumPy alone; slow, and the reference of `SphereRenderer`.
"""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POSITION, FOCAL = np.array([16.0, 2.0, 0.0]), 85 / 36
"""Of the camera; the focal length is in widths of the picture."""


def points(width: int, height: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Normals and directions to the camera where rays of pixels' centres meet the sphere, and which do."""
    back = POSITION / np.linalg.norm(POSITION)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    x = np.arange(width) + 0.5 - width / 2
    y = height / 2 - np.arange(height) - 0.5
    rays = x[None, :, None] * right + y[:, None, None] * up - FOCAL * width * back
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    # |position + t ray| = 1, the nearer of two solutions.
    b = rays @ POSITION
    root = b * b - (POSITION @ POSITION - 1)
    hit = root > 0
    t = -b - np.sqrt(np.where(hit, root, 0))
    normals = POSITION + t[..., None] * rays
    return normals[hit], -rays[hit], hit


def texels(height: int) -> tuple[Array, Array]:
    """Directions and solid angles of a panorama's texels, row by row."""
    v = (np.arange(height) + 0.5) / height * math.pi
    u = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2 * math.pi
    directions = np.stack(
        np.broadcast_arrays(
            np.sin(v)[:, None] * np.sin(u), np.cos(v)[:, None], -np.sin(v)[:, None] * np.cos(u)
        ),
        -1,
    )
    edges = np.cos(np.arange(height + 1) / height * math.pi)
    angles = np.broadcast_to((edges[:-1] - edges[1:])[:, None] * math.pi / height, (height, 2 * height))
    return directions.reshape(-1, 3), angles.ravel()


def ggx(light: Array, view: Array, normal: Array, alpha: float) -> Array:
    """D G / (4 n.v) for many lights: the kernel with its n.l, before any Fresnel term."""
    half = light + view
    half /= np.maximum(np.linalg.norm(half, axis=-1, keepdims=True), 1e-12)
    n_l, n_v, n_h = light @ normal, float(view @ normal), half @ normal
    spread = alpha**2 / (math.pi * (1 + (alpha**2 - 1) * n_h**2) ** 2)

    def hidden(cosine: Array) -> Array:
        return (np.sqrt(1 + alpha**2 * (1 / np.maximum(cosine, 1e-9) ** 2 - 1)) - 1) / 2

    masked = 1 / (1 + hidden(n_l) + hidden(np.array(n_v)))
    return np.where(n_l > 0, spread * masked / (4 * n_v), 0.0)


def schlick(cosine: Array, facing: float) -> Array:
    return facing + (1 - facing) * (1 - cosine) ** 5


def dielectric(cosine: Array, ior: float) -> Array:
    """The mean of both polarisations by Snell's law."""
    inside = np.sqrt(1 - (1 - cosine**2) / ior**2)
    across = (cosine - ior * inside) / (cosine + ior * inside)
    along = (ior * cosine - inside) / (ior * cosine + inside)
    return (across**2 + along**2) / 2


class Surface:
    """Principled metal, or paint under a coat, with what both need to know of all views in tables."""

    def __init__(self, metal: bool, roughness: float, colour: float = 0.8, ior: float = 1.5) -> None:
        self.metal, self.alpha, self.colour, self.ior = metal, roughness**2, colour, ior
        lights, angles = texels(192)
        normal = np.array([0.0, 1.0, 0.0])
        self.cosines = np.linspace(0.02, 1, 50)
        single, shown = [], []
        for cosine in self.cosines:
            view = np.array([math.sqrt(1 - cosine**2), cosine, 0.0])
            kernel = ggx(lights, view, normal, self.alpha) * angles
            single.append(kernel.sum())
            shown.append((kernel * self.fresnel(lights, view)).sum())
        self.single, self.shown = np.array(single), np.array(shown)
        fine = (np.arange(1000) + 0.5) / 1000
        mean = 2 * (np.interp(fine, self.cosines, self.single) * fine).mean()
        f = 2 * ((schlick(fine, colour) if metal else dielectric(fine, ior)) * fine).mean()
        self.more = f * mean / (1 - f * (1 - mean))

    def fresnel(self, light: Array, view: Array) -> Array:
        half = np.sqrt(np.clip((1 + light @ view) / 2, 0, 1))
        return schlick(half, self.colour) if self.metal else dielectric(half, self.ior)

    def kernel(self, light: Array, view: Array, normal: Array) -> Array:
        single = np.interp(view @ normal, self.cosines, self.single)
        scale = 1 + self.more * (1 - single) / single
        bounced: Array = ggx(light, view, normal, self.alpha) * self.fresnel(light, view) * scale
        if self.metal:
            return bounced
        left: Array = 1 - scale * np.interp(view @ normal, self.cosines, self.shown)
        return bounced + left * self.colour / math.pi * np.maximum(light @ normal, 0)


def rough(environment: Array, normals: Array, views: Array, surface: Surface) -> Array:
    """Radiance of points: the loop."""
    lights, angles = texels(environment.shape[0])
    flat = environment.reshape(-1, 3) * angles[:, None]
    return np.stack(
        [surface.kernel(lights, view, normal) @ flat for normal, view in zip(normals, views, strict=True)]
    )


def mirror(environment: Array, normals: Array, views: Array, colour: float = 0.8) -> Array:
    """Radiance of points of a mirror: one bilinear look-up each."""
    height = environment.shape[0]
    shown = []
    for normal, view in zip(normals, views, strict=True):
        x, y, z = 2 * (normal @ view) * normal - view
        column = (0.5 + math.atan2(x, -z) / (2 * math.pi)) * 2 * height - 0.5
        row = min(max(math.acos(min(max(y, -1), 1)) / math.pi * height - 0.5, 0), height - 1)
        left, upper = math.floor(column), min(math.floor(row), height - 2)
        a, b = column - left, row - upper
        pick = environment[upper : upper + 2][:, [left % (2 * height), (left + 1) % (2 * height)]]
        seen = np.einsum("r,c,rck->k", [1 - b, b], [1 - a, a], pick)
        shown.append(schlick(np.array(normal @ view), colour) * seen)
    return np.stack(shown)
