"""The pictures for people: photo, map with its lights marked, spheres. NumPy and Pillow only.

All parts of one picture share one exposure, so that their brightness can be compared. Everything up to
`encode` is linear Rec.709; what follows is 8-bit sRGB.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, UInt8
from PIL import Image, ImageDraw, ImageFont

from mixlight.image.color import linear_to_srgb, luminance

__all__ = [
    "Marker",
    "auto_exposure",
    "encode",
    "estimate_preview",
    "fit_preview",
    "shrink",
    "spheres_picture",
]

PAGE = (38, 38, 41)
CAPTION = (176, 176, 182)
MARGIN, GAP, CAPTION_ROWS, CAPTION_SIZE = 28, 28, 30, 17
MAP_COLUMNS, MAP_ROWS = 720, 360
SPHERE = 222
"""Pixels across one sphere of a preview; three and their gaps are as wide as the map."""

MATERIALS = ("diffuse gray", "matte silver", "mirror silver")
KNEE = 0.8
"""Encoded values up to here are shown as they are; what lies above is rolled off, so that lamps show."""


@dataclass(frozen=True)
class Marker:
    """A light to be circled on the map."""

    direction: tuple[float, float, float]
    """Unit vector towards the light."""
    share: float
    """Its part of the strength of all lights, from 0 to 1; the circle's area grows with it."""


def auto_exposure(
    radiance: Float[np.ndarray, "*shape 3"], weights: Float[np.ndarray, "*shape"] | None = None
) -> float:
    """The gain that brings the median luminance to middle grey, 0.18; 1 where nothing is lit.

    Args:
        radiance: linear values, any leading shape.
        weights: how much each counts, for instance its solid angle; none: all the same.

    >>> auto_exposure(np.full((4, 8, 3), 0.36, dtype=np.float32))
    0.5
    """
    values = luminance(radiance).reshape(-1).astype(np.float64)
    order = np.argsort(values)
    mass = (
        np.ones_like(values) if weights is None else np.broadcast_to(weights, radiance.shape[:-1]).reshape(-1)
    )
    below = np.cumsum(mass[order], dtype=np.float64)
    median = float(values[order][np.searchsorted(below, below[-1] / 2.0)])
    # The rounding hides float32 noise from people who read the gain.
    return float(f"{0.18 / median:.6g}") if median > 1e-9 else 1.0


def encode(linear: Float[np.ndarray, "*shape 3"], gain: float = 1.0) -> UInt8[np.ndarray, "*shape 3"]:
    """Linear radiance as 8-bit sRGB: exact up to `KNEE`, then a shoulder 1 - (1-k) exp(-(c-k)/(1-k)) of the
    encoded value.

    The shoulder meets the straight part with its slope, and white is reached only in the limit.

    >>> encode(np.array([[0.18, 1.0, 100.0]])).tolist()
    [[118, 236, 255]]
    """
    encoded = linear_to_srgb(np.maximum(linear * np.float32(gain), 0.0))
    over = np.maximum(encoded - KNEE, 0.0) / (1.0 - KNEE)
    shown = np.minimum(encoded, KNEE) + (1.0 - KNEE) * (1.0 - np.exp(-over))
    return (shown * 255.0 + 0.5).astype(np.uint8)


def encode_photo(
    linear: Float[np.ndarray, "height width 3"], gain: float = 1.0
) -> UInt8[np.ndarray, "height width 3"]:
    """Linear photo as 8-bit sRGB with its own white at 255, that is: as the photo looked."""
    return (linear_to_srgb(np.clip(linear * np.float32(gain), 0.0, 1.0)) * 255.0 + 0.5).astype(np.uint8)


def shrink(picture: Float[np.ndarray, "height width 3"], rows: int) -> Float[np.ndarray, "rows columns 3"]:
    """The picture averaged over whole blocks of pixels, to at least `rows` rows (a cheap first step of a
    resize).

    >>> shrink(np.ones((1000, 600, 3), dtype=np.float32), 300).shape
    (333, 200, 3)
    """
    block = max(min(picture.shape[0] // max(rows, 1), picture.shape[1]), 1)
    if block == 1:
        return picture
    height, width = picture.shape[0] // block, picture.shape[1] // block
    # Rows first: whole rows add up at the speed of memory, and the second sum then has little left to do.
    tall = np.add.reduce(picture[: height * block].reshape(height, block, -1), axis=1)
    tall = tall.reshape(height, -1, 3)[:, : width * block]
    return np.asarray(tall.reshape(height, width, block, 3).sum(axis=2) / np.float32(block * block))


def estimate_preview(
    photo: Float[np.ndarray, "photo_height photo_width 3"],
    environment: Float[np.ndarray, "height width 3"],
    spheres: Float[np.ndarray, "3 size size 3"],
    mask: Bool[np.ndarray, "size size"],
    markers: Sequence[Marker],
    *,
    gain: float = 1.0,
    caption: str = "photo",
) -> UInt8[np.ndarray, "rows columns 3"]:
    """The picture of an estimate: the photo on the left, its light and the three spheres lit by it on the
    right.

    Args:
        photo: linear.
        environment: the estimated map, linear, in the photo's exposure.
        spheres: the three spheres lit by it, linear, in the order of `MATERIALS`.
        mask: the pixels that a sphere covers.
        markers: the lights to be circled on the map.
        gain: multiplies all of them.
        caption: what stands above the photo.
    """
    right = _light_column(
        environment, spheres, mask, markers, gain, "estimated light, in the photo's exposure"
    )
    rows = right.height - CAPTION_ROWS
    scale = min(rows / photo.shape[0], rows * 4 / 3 / photo.shape[1])
    size = (max(round(photo.shape[1] * scale), 1), max(round(photo.shape[0] * scale), 1))
    picture = Image.fromarray(encode_photo(shrink(photo, size[1]), gain)).resize(
        size, Image.Resampling.LANCZOS
    )
    left = Image.new("RGB", (size[0], right.height), PAGE)
    top = (rows - size[1]) // 2
    left.paste(picture, (0, top + CAPTION_ROWS))
    _caption(left, 0, top, _fitting(caption, size[0]))
    return _page([left, right])


def fit_preview(
    original: Float[np.ndarray, "height width 3"],
    fitted: Float[np.ndarray, "fitted_height fitted_width 3"],
    original_spheres: Float[np.ndarray, "3 size size 3"],
    fitted_spheres: Float[np.ndarray, "3 size size 3"],
    mask: Bool[np.ndarray, "size size"],
    markers: Sequence[Marker],
    *,
    gain: float,
    caption: str = "panorama",
) -> UInt8[np.ndarray, "rows columns 3"]:
    """The picture of a fit: panorama and spheres on the left, the fitted light and its own on the right."""
    return _page(
        [
            _light_column(original, original_spheres, mask, (), gain, _fitting(caption, MAP_COLUMNS)),
            _light_column(fitted, fitted_spheres, mask, markers, gain, "fitted light"),
        ]
    )


def spheres_picture(
    spheres: Float[np.ndarray, "3 size size 3"],
    mask: Bool[np.ndarray, "size size"],
    pixels: int,
    *,
    gain: float = 1.0,
) -> UInt8[np.ndarray, "rows columns 3"]:
    """The three spheres side by side on a neutral page, each `pixels` across, with antialiased edges."""
    row = _sphere_row(spheres, mask, pixels, GAP, gain)
    page = Image.new("RGB", (row.width + 2 * MARGIN, row.height + 2 * MARGIN), PAGE)
    page.paste(row, (MARGIN, MARGIN))
    return np.asarray(page)


def _light_column(
    environment: Float[np.ndarray, "height width 3"],
    spheres: Float[np.ndarray, "3 size size 3"],
    mask: Bool[np.ndarray, "size size"],
    markers: Sequence[Marker],
    gain: float,
    caption: str,
) -> Image.Image:
    space = (MAP_COLUMNS - 3 * SPHERE) // 2
    column = Image.new("RGB", (MAP_COLUMNS, MAP_ROWS + GAP + SPHERE + 2 * CAPTION_ROWS), PAGE)
    shown = Image.fromarray(encode(environment, gain)).resize(
        (MAP_COLUMNS, MAP_ROWS), Image.Resampling.BICUBIC
    )
    _mark(shown, markers)
    column.paste(shown, (0, CAPTION_ROWS))
    _caption(column, 0, 0, caption)
    top = CAPTION_ROWS + MAP_ROWS + GAP
    column.paste(_sphere_row(spheres, mask, SPHERE, space, gain), (0, top + CAPTION_ROWS))
    for index, material in enumerate(MATERIALS):
        _caption(column, index * (SPHERE + space), top, material)
    return column


def _sphere_row(
    spheres: Float[np.ndarray, "3 size size 3"],
    mask: Bool[np.ndarray, "size size"],
    pixels: int,
    space: int,
    gain: float,
) -> Image.Image:
    row = Image.new("RGB", (3 * pixels + 2 * space, pixels), PAGE)
    coverage = _disc(pixels)
    for index, sphere in enumerate(spheres):
        # Pixels beyond the rim take the colour of the pixel inside it that lies on the same radius, so that
        # the resize mixes no background into the edge; the coverage then cuts the exact circle.
        filled = Image.fromarray(encode(_extended(sphere, mask), gain))
        row.paste(
            filled.resize((pixels, pixels), Image.Resampling.LANCZOS), (index * (pixels + space), 0), coverage
        )
    return row


def _extended(
    sphere: Float[np.ndarray, "size size 3"], mask: Bool[np.ndarray, "size size"]
) -> Float[np.ndarray, "size size 3"]:
    size = sphere.shape[0]
    centre = (np.arange(size) + 0.5) * (2.0 / size) - 1.0
    radius = np.hypot(centre[:, None], centre)
    reach = 1.0 - 3.0 / size
    pull = np.where(mask, 1.0, reach / np.maximum(radius, 1e-6))
    row, column = (
        (np.clip(c * pull, -1, 1) + 1.0) * (size / 2.0) for c in (centre[:, None], centre[None, :])
    )
    limit = size - 1
    return np.asarray(sphere[np.minimum(row.astype(int), limit), np.minimum(column.astype(int), limit)])


def _disc(pixels: int) -> Image.Image:
    """Coverage of each pixel by the inscribed circle, from its distance to the rim."""
    centre = np.arange(pixels) + 0.5 - pixels / 2.0
    inside = pixels / 2.0 - np.hypot(centre[:, None], centre)
    return Image.fromarray((np.clip(inside + 0.5, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))


def _mark(shown: Image.Image, markers: Sequence[Marker]) -> None:
    """Circle the lights, drawn four times too large and reduced, because Pillow's circles have hard edges."""
    if not markers:
        return
    fine = 4
    layer = Image.new("L", (shown.width * fine, shown.height * fine), 0)
    shade = Image.new("L", layer.size, 0)
    for marker in markers:
        x, y, z = marker.direction
        u = 0.5 + np.arctan2(x, -z) / (2.0 * np.pi)
        v = np.arccos(np.clip(y, -1.0, 1.0)) / np.pi
        radius = (6.0 + 20.0 * np.sqrt(np.clip(marker.share, 0.0, 1.0))) * fine
        for turn in (-1, 0, 1):  # a circle over the map's edge goes on at the other side
            centre = ((u + turn) * layer.width, v * layer.height)
            for canvas, line, extra in ((shade, 5 * fine, 1.5 * fine), (layer, 2 * fine, 0.0)):
                reach = radius + extra
                box = (centre[0] - reach, centre[1] - reach, centre[0] + reach, centre[1] + reach)
                ImageDraw.Draw(canvas).ellipse(box, outline=255, width=line)
    for canvas, colour in ((shade, (0, 0, 0)), (layer, (255, 255, 255))):
        reduced = canvas.resize(shown.size, Image.Resampling.BOX)
        shown.paste(
            colour, mask=reduced if colour[0] else reduced.point([level * 0.55 for level in range(256)])
        )


def _caption(image: Image.Image, left: int, top: int, text: str) -> None:
    ImageDraw.Draw(image).text(
        (left, top + 2), text, fill=CAPTION, font=ImageFont.load_default(size=CAPTION_SIZE)
    )


def _fitting(text: str, width: int) -> str:
    """`text`, with its middle left out where it is wider than `width` pixels."""
    font = ImageFont.load_default(size=CAPTION_SIZE)
    shown, keep = text, len(text)
    while keep > 4 and font.getlength(shown) > width:
        keep -= 1
        shown = f"{text[: keep // 2]}…{text[len(text) - keep // 2 :]}"
    return shown


def _page(columns: Sequence[Image.Image]) -> UInt8[np.ndarray, "rows columns 3"]:
    width = sum(column.width for column in columns) + GAP * (len(columns) - 1) + 2 * MARGIN
    page = Image.new("RGB", (width, max(column.height for column in columns) + 2 * MARGIN - 6), PAGE)
    left = MARGIN
    for column in columns:
        page.paste(column, (left, MARGIN - 8))
        left += column.width + GAP
    return np.asarray(page)
