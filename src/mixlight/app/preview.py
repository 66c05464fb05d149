"""The pictures for people: photo, map with its lights marked, spheres. NumPy and Pillow only.

All parts of one picture share one exposure, so that their brightness can be compared. Everything up to
`encode` is linear Rec.709; what follows is 8-bit sRGB.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Shaped, UInt8
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
    outline: Float[np.ndarray, "points 3"] | None = None,
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
        outline: directions along the photo's edge, to show which part of the map the photo sees.
        gain: multiplies all of them.
        caption: what stands above the photo.
    """
    right = _light_column(environment, spheres, mask, markers, gain, "estimated light", outline)
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
    outline: Float[np.ndarray, "points 3"] | None = None,
) -> Image.Image:
    space = (MAP_COLUMNS - 3 * SPHERE) // 2
    column = Image.new("RGB", (MAP_COLUMNS, MAP_ROWS + GAP + SPHERE + 2 * CAPTION_ROWS), PAGE)
    shown = Image.fromarray(encode(environment, gain)).resize(
        (MAP_COLUMNS, MAP_ROWS), Image.Resampling.BICUBIC
    )
    _mark(shown, markers, outline)
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


def _mark(
    shown: Image.Image, markers: Sequence[Marker], outline: Float[np.ndarray, "points 3"] | None = None
) -> None:
    """Circle the lights and draw the photo's edge, four times too large, then reduced: Pillow is jagged."""
    if not markers and outline is None:
        return
    fine = 4
    size = (shown.width * fine, shown.height * fine)
    line, shade = Image.new("L", size, 0), Image.new("L", size, 0)
    for canvas, stroke, extra in ((shade, 5 * fine, 1.5 * fine), (line, 2 * fine, 0.0)):
        draw = ImageDraw.Draw(canvas)
        if outline is not None:
            _draw_edge(draw, _place(outline, size), size[0], stroke)
        for marker in markers:
            radius = (6.0 + 20.0 * np.sqrt(np.clip(marker.share, 0.0, 1.0))) * fine + extra
            x, y = _place(np.asarray(marker.direction), size)
            for turn in (-size[0], 0, size[0]):  # a circle over the map's edge goes on at the other side
                box = (x + turn - radius, y - radius, x + turn + radius, y + radius)
                draw.ellipse(box, outline=255, width=stroke)
    for canvas, colour, opacity in ((shade, (0, 0, 0), 0.55), (line, (255, 255, 255), 1.0)):
        mask = canvas.resize(shown.size, Image.Resampling.BOX)
        shown.paste(colour, mask=mask.point([round(level * opacity) for level in range(256)]))


def _place(
    direction: Shaped[np.ndarray, "*points 3"], size: tuple[int, int]
) -> Float[np.ndarray, "*points 2"]:
    """Where directions lie on a map of `size` (columns, rows): docs/conventions.md, the frame."""
    x, y, z = np.moveaxis(direction.astype(np.float64), -1, 0)
    u = 0.5 + np.arctan2(x, -z) / (2.0 * np.pi)
    v = np.arccos(np.clip(y, -1.0, 1.0)) / np.pi
    return np.stack([u, v], -1) * np.asarray(size, dtype=np.float64)


def _draw_edge(
    draw: ImageDraw.ImageDraw, points: Float[np.ndarray, "points 2"], width: int, stroke: int
) -> None:
    """A closed line through points of the map, which may run over its left and right edge."""
    for (x, y), (next_x, next_y) in zip(points, np.roll(points, -1, axis=0), strict=True):
        near = next_x - width * round((next_x - x) / width)
        for turn in (-width, 0, width):
            if -width < min(x, near) + turn < 2 * width:
                draw.line(((x + turn, y), (near + turn, next_y)), fill=255, width=stroke // 2)


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
