"""Where an object stands in a photo: the camera that took it, the ground it shows, and the object's size.

The camera is at the origin of our frame, level but for its pitch and roll; the photo's azimuth is -Z. The
ground is the plane y = -1: a photo does not tell how large its world is, so the unit of length is the
camera's height above the ground, and who knows that height in metres multiplies by it.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float

from mixlight.sphere.frames import rotation

__all__ = ["DEFAULT_SHARE", "Placement", "SceneCamera", "default_point", "place"]

DEFAULT_SHARE = 0.35
"""An object whose size is not given spans this share of the photo's height, by the larger of its sides."""

NEAREST_HORIZON = math.radians(1.0)
"""A place on the ground lies at least this far below the horizon; nearer, a pixel is metres of ground."""

_NEAR = 0.02
"""Nothing of the object may come nearer to the camera's plane than this, in camera heights."""


@dataclass(frozen=True)
class SceneCamera:
    """The pinhole camera of a photo, at the origin.

    Convention: picture coordinates are pixels from the photo's upper left corner, x to the right and y down,
        so that the first pixel's centre is (0.5, 0.5). In a level camera the horizon is the middle row.

    Raises:
        ValueError: an empty picture, a field of view outside (0, pi), angles that are not finite.
    """

    width: int
    height: int
    fov_x: float
    """Horizontal field of view in radians, from edge to edge."""
    pitch: float = 0.0
    """Radians; positive looks up."""
    roll: float = 0.0
    """Radians; positive is a camera turned clockwise."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"expected a picture of at least 1 x 1, received {self.width} x {self.height}")
        if not 0 < self.fov_x < math.pi:
            raise ValueError(f"expected a horizontal field of view in (0, pi) radians, received {self.fov_x}")
        if not (abs(self.pitch) < math.pi / 2 and abs(self.roll) <= math.pi):
            raise ValueError(
                "expected a pitch within a quarter and a roll within half a turn, "
                f"received {self.pitch} and {self.roll} radians"
            )

    @property
    def focal(self) -> float:
        """Focal length in pixels.

        >>> round(SceneCamera(200, 100, math.pi / 2).focal, 6)
        100.0
        """
        return self.width / (2 * math.tan(self.fov_x / 2))

    @property
    def axes(self) -> Float[np.ndarray, "3 3"]:
        """Camera to world: columns are the camera's right, its up, and the opposite of its forward."""
        return np.asarray(rotation(0.0, self.pitch, self.roll, dtype=torch.float64).numpy())

    def directions(self, points: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 3"]:
        """Unit directions in the world through points of the picture.

        >>> SceneCamera(200, 100, math.pi / 2).directions(np.array([100.0, 50.0])).round(3) + 0.0
        array([ 0.,  0., -1.])
        """
        x = (points[..., 0] - self.width / 2) / self.focal
        y = -(points[..., 1] - self.height / 2) / self.focal
        rays = np.stack([x, y, -np.ones_like(x)], -1) @ self.axes.T
        return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

    def project(
        self, positions: Float[np.ndarray, "*batch 3"]
    ) -> tuple[Float[np.ndarray, "*batch 2"], Float[np.ndarray, "*batch"]]:
        """Where points of the world appear, and how far ahead they lie along the optical axis.

        A point that is not ahead has a depth of at most 0 and NaN for its place.

        >>> place, depth = SceneCamera(200, 100, math.pi / 2).project(np.array([1.0, 0.0, -2.0]))
        >>> place.round(3), round(float(depth), 3)
        (array([150.,  50.]), 2.0)
        """
        local = positions @ self.axes
        depth = np.asarray(-local[..., 2])
        ahead = np.where(depth > 0, depth, np.nan)
        x = self.width / 2 + self.focal * local[..., 0] / ahead
        y = self.height / 2 - self.focal * local[..., 1] / ahead
        return np.stack([x, y], -1), depth

    def horizon(self, u: float) -> float:
        """The height v of the horizon in the picture at u, as fractions of its height and width.

        Below 0 it lies above the picture, above 1 below it; -inf or inf when the camera is on its side.

        >>> round(SceneCamera(640, 480, math.radians(60), math.radians(-8)).horizon(0.5), 4)
        0.3377
        """
        row = self.axes[1]
        x = (u - 0.5) * self.width / self.focal
        if abs(row[1]) < 1e-9:
            return math.copysign(math.inf, row[0] * x - row[2])
        return float(0.5 + (row[0] * x - row[2]) / row[1] * self.focal / self.height)

    def ground_point(self, u: float, v: float) -> Float[np.ndarray, "3"]:
        """The point of the ground, y = -1, that the photo shows at (u, v).

        Args:
            u: fraction of the width, 0 left, 1 right.
            v: fraction of the height, 0 top, 1 bottom.

        Convention: a level camera sees the ground 45 degrees below its axis one camera height away.

        Raises:
            ValueError: a point outside the photo, above the horizon, or less than a degree below it.

        >>> SceneCamera(100, 200, math.pi / 2).ground_point(0.5, 0.75).round(3) + 0.0
        array([ 0., -1., -1.])
        """
        if not (0 <= u <= 1 and 0 <= v <= 1):
            raise ValueError(f"expected a point inside the photo, 0 to 1, received {u:g},{v:g}")
        ray = self.directions(np.array([u * self.width, v * self.height]))
        elevation = math.asin(max(-1.0, min(1.0, float(ray[1]))))
        if elevation > -NEAREST_HORIZON:
            received = "above it" if elevation > 0 else f"{math.degrees(-elevation):.2f}° below it"
            raise ValueError(
                f"expected a point on the ground, at least 1° below the horizon (which is at "
                f"v = {self.horizon(u):.3f} where u = {u:g}), received {u:g},{v:g}, {received}"
            )
        return np.asarray(ray / -ray[1])


def default_point(camera: SceneCamera) -> tuple[float, float]:
    """Where an object goes whose place is not given: in the middle, two thirds down from horizon to bottom.

    Raises:
        ValueError: the photo shows no ground there.

    >>> default_point(SceneCamera(640, 480, 1.0))
    (0.5, 0.8333333333333333)
    """
    horizon = max(camera.horizon(0.5), 0.0)
    if not horizon < 0.95:
        raise ValueError(
            f"expected a photo that shows ground below its horizon, received one whose horizon is at "
            f"v = {horizon:.3f} (pitch {math.degrees(camera.pitch):.1f}°)"
        )
    return 0.5, horizon + (1 - horizon) * 2 / 3


@dataclass(frozen=True, eq=False)
class Placement:
    """How a model is set into the world: scaled, turned about +Y, its footprint's centre moved to a point."""

    scale: float
    """Camera heights for each unit of the model."""
    turn: float
    """Radians about +Y; positive turns the model counter-clockwise as seen from above."""
    point: Float[np.ndarray, "3"]
    """Of the ground, where the middle of the model's footprint stands."""
    base: Float[np.ndarray, "3"]
    """That middle in the model's own coordinates."""

    @property
    def matrix(self) -> Float[np.ndarray, "3 3"]:
        """The rotation about +Y."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])

    def apply(self, positions: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """Points of the model in the world."""
        return np.asarray((positions - self.base) @ self.matrix.T * self.scale + self.point)


def place(
    camera: SceneCamera,
    lower: Float[np.ndarray, "3"],
    upper: Float[np.ndarray, "3"],
    u: float,
    v: float,
    *,
    scale: float = 1.0,
    turn: float = 0.0,
    camera_height: float | None = None,
) -> Placement:
    """Set a model with the given bounding box on the ground at (u, v).

    Args:
        camera: that of the photo.
        lower: smallest coordinates of the model.
        upper: largest coordinates of the model.
        u: where its footprint's centre goes, as a fraction of the photo's width.
        v: the same of the height.
        scale: factor on the size.
        turn: radians about +Y.
        camera_height: of the camera above this ground, in the model's units (metres, for glTF). None: the
            model gets the size at which the larger side of its box spans `DEFAULT_SHARE` of the photo's
            height, times `scale`.

    Convention: at camera_height 2 a model of height 1 stands half as high as the camera.

    Raises:
        ValueError: a point that is not on the ground (`SceneCamera.ground_point`), a scale or height that is
            not above 0, a model without extent, or one that would reach the camera.

    >>> camera = SceneCamera(200, 200, math.pi / 2)
    >>> place(camera, np.zeros(3), np.ones(3), 0.5, 0.75, camera_height=4.0).scale
    0.25
    """
    for name, value in (("scale", scale), ("camera height", camera_height)):
        if value is not None and not (0 < value < math.inf):
            raise ValueError(f"{name}: expected a number above 0, received {value:g}")
    extent = float((upper - lower).max())
    if not 0 < extent < math.inf:
        raise ValueError(f"expected a model of some extent, received one of {extent:g}")
    point = camera.ground_point(u, v)
    base = np.array([(lower[0] + upper[0]) / 2, lower[1], (lower[2] + upper[2]) / 2])
    corners = np.array(np.meshgrid(*zip(lower, upper, strict=True))).reshape(3, -1).T

    def at(factor: float) -> tuple[float, float]:
        """Span in the picture in photo heights, and the least depth."""
        where, depth = camera.project(Placement(factor, turn, point, base).apply(corners))
        span = np.ptp(where, axis=0).max() if depth.min() > _NEAR else math.inf
        return float(span) / camera.height, float(depth.min())

    if camera_height is not None:
        factor = scale / camera_height
    else:
        low, high = 0.0, 1e3 / extent
        for _ in range(100):
            middle = (low + high) / 2
            low, high = (middle, high) if at(middle)[0] < DEFAULT_SHARE else (low, middle)
        factor = low * scale
    if at(factor)[1] <= _NEAR:
        raise ValueError(
            "expected an object wholly in front of the camera, received one that reaches it or lies "
            "behind it (choose a smaller scale, or a point farther from the lower edge)"
        )
    return Placement(factor, turn, point, base)
