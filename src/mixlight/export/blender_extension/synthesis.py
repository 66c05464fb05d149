"""The environment map of a `lighting.json`, in NumPy alone: what Blender's own Python can compute.

The same light as `mixlight.Lighting.environment` (tests hold the two together); here in float64 and in the
plainest form, since it runs once for a file.
"""

import math

import numpy as np


def residual_map(document, height):
    """Radiance of all that the document's `lights` do not hold: ambient light, and lobes too weak to count.

    Args:
        document: a checked `lighting.json`.
        height: rows of the map.

    Returns:
        [height, 2 height, 3], the layout of MixLight: row 0 on top, the photo's azimuth in the centre.
    """
    strong = _strong(document["sources"])
    weak = [row for row, counts in zip(document["sources"]["energy"], strong, strict=True) if not counts]
    return ambient_map(document, height) + lobes_map(document, weak, height)


def full_map(document, height):
    """Radiance of all light of the document, [height, 2 height, 3]."""
    return ambient_map(document, height) + lobes_map(document, document["sources"]["energy"], height)


def ambient_map(document, height):
    """Radiance of the ambient light, without the expansion's negative parts, [height, 2 height, 3]."""
    coefficients = np.asarray(document["ambient"]["coefficients"], dtype=np.float64)
    return np.maximum(harmonics(_directions(height), document["ambient"]["degree"]) @ coefficients, 0)


def lobes_map(document, energy, height):
    """Radiance of some lobes ([index, r, g, b] each), whose sums over the texels are their energies."""
    directions = _directions(height)
    solid_angle = _solid_angle(height)
    total = np.zeros((height, 2 * height, 3))
    for index, *rgb in energy:
        axis = anchor(index, document["sources"]["count"], document["sources"].get("turn_deg", 0))
        # The chord keeps its digits where the cosine has lost them.
        exponent = -0.5 * ((directions - axis) ** 2).sum(-1) / document["sources"]["sharpness"]
        lobe = np.exp(exponent - exponent.max())
        total += lobe[..., None] * (np.asarray(rgb) / (lobe * solid_angle).sum())
    return total


def anchor(index, count, turn_deg=0.0):
    """Axis of an anchor: the golden-angle spiral from +Y down, azimuth from -Z to the right, plus a turn."""
    azimuth = index * math.pi * (3 - math.sqrt(5)) + math.radians(turn_deg)
    up = 1 - (2 * index + 1) / count
    across = math.sqrt(1 - up * up)
    return np.array([across * math.sin(azimuth), up, -across * math.cos(azimuth)])


def harmonics(directions, degree):
    """Real orthonormal harmonics [..., (degree + 1)^2], index l^2 + l + m, all signs plus; z is the polar
    axis.
    """
    x, y, z = np.moveaxis(directions, -1, 0)
    values = np.empty((*directions.shape[:-1], (degree + 1) ** 2))
    even, odd = np.ones_like(x), np.zeros_like(x)  # (x + iy)^m
    diagonal = 1.0  # (2m - 1)!!
    for m in range(degree + 1):
        before, now = np.zeros_like(z), np.full_like(z, diagonal)
        for band in range(m, degree + 1):
            ratio = math.factorial(band - m) / math.factorial(band + m)
            factor = math.sqrt((2 * band + 1) / (4 * math.pi) * ratio * (2 if m else 1))
            values[..., band * band + band + m] = factor * now * even
            if m:
                values[..., band * band + band - m] = factor * now * odd
            before, now = now, ((2 * band + 1) * z * now - (band + m) * before) / (band + 1 - m)
        even, odd = x * even - y * odd, x * odd + y * even
        diagonal *= 2 * m + 1
    return values


def _directions(height):
    polar = (np.arange(height) + 0.5) * (math.pi / height)
    azimuth = (np.arange(2 * height) + 0.5) * (math.pi / height) - math.pi
    sine = np.sin(polar)[:, None]
    up = np.broadcast_to(np.cos(polar)[:, None], (height, 2 * height))
    return np.stack((sine * np.sin(azimuth), up, -sine * np.cos(azimuth)), -1)


def _solid_angle(height):
    edges = np.cos(np.arange(height + 1) * (math.pi / height))
    return ((edges[:-1] - edges[1:]) * (math.pi / height))[:, None]


def _strong(sources):
    """Which lobes the document's lights are made of: those of lights with lasting names, and of the others
    those of more than 1e-4 of the sources' luminance.
    """
    named = {anchor for group in sources.get("groups", ()) for anchor in group["anchors"]}
    power = [0.2126 * red + 0.7152 * green + 0.0722 * blue for _, red, green, blue in sources["energy"]]
    return [
        row[0] in named or value > 1e-4 * sum(power)
        for row, value in zip(sources["energy"], power, strict=True)
    ]
