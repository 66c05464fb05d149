"""How a test sphere is looked at: from afar (orthographic), or by a camera at a finite distance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor


@dataclass(frozen=True)
class SphereCamera:
    """A camera that aims at the centre of a sphere of radius 1 and sees it whole.

    Aimed at the centre, the sphere's outline is a circle about the picture's centre, and everything else
    about the view depends on the distance from that centre alone: with `distance` D, the ray that makes the
    angle b with the normal where it arrives leaves the axis by the angle p and meets the normal that leans by
    t away from the axis,

        sin p = sin b / D,   t = b - p,   r = tan p / tan p_max

    where r is the place in the picture in units of the outline's radius. From afar p = 0 and r = sin b.

    Convention: our frame. The picture's up is +Y (as far as the camera sees it), row 0 on top. Seen from
    (0, 0, D) the picture's right is +X and its centre has the normal +Z.

    >>> camera = SphereCamera.orthographic(64)
    >>> camera.radius, camera.towards
    (32.0, (0.0, 0.0, 1.0))
    """

    width: int
    """Columns of the picture."""
    height: int
    """Rows of the picture."""
    towards: tuple[float, float, float]
    """Unit direction from the sphere to the camera."""
    distance: float
    """From the sphere's centre to the camera, in radii of the sphere; infinite if orthographic."""
    radius: float
    """Of the sphere's outline in the picture, in pixels."""

    def __post_init__(self) -> None:
        """Check it.

        Raises:
            ValueError: A size below 1, a camera inside the sphere, straight above it, or `towards` no unit
                vector.
        """
        if self.width < 1 or self.height < 1 or not 0 < self.radius < math.inf:
            raise ValueError(
                "expected a picture of at least one pixel and an outline, "
                f"got {self.width} x {self.height} and a radius of {self.radius}"
            )
        if not self.distance > 1:
            raise ValueError(f"expected a camera outside the sphere of radius 1, got {self.distance}")
        x, y, z = self.towards
        if not math.isclose(math.hypot(x, y, z), 1, abs_tol=1e-6) or math.hypot(x, z) < 1e-6:
            raise ValueError(f"expected a unit vector that is not vertical, got {self.towards}")

    @classmethod
    def orthographic(cls, resolution: int) -> SphereCamera:
        """The view from afar that faces the photographer's side, the disc touching all edges.

        Raises:
            ValueError: If `resolution` is below 1.
        """
        return cls(resolution, resolution, (0.0, 0.0, 1.0), math.inf, resolution / 2)

    @classmethod
    def perspective(
        cls,
        position: tuple[float, float, float],
        focal_length: float,
        sensor_width: float,
        width: int,
        height: int,
    ) -> SphereCamera:
        """A pinhole camera at a place, aimed at the sphere.

        Args:
            position: In our frame, in radii of the sphere.
            focal_length: In the unit of `sensor_width`.
            sensor_width: Of the part of the sensor that the picture's columns cover.
            width: Columns of the picture.
            height: Rows of the picture; pixels are square.

        Raises:
            ValueError: A camera inside the sphere or straight above it, or a size that is not positive.

        >>> camera = SphereCamera.perspective((16, 2, 0), 85, 36, 960, 540)
        >>> round(camera.distance, 3), round(camera.radius, 2)
        (16.125, 140.84)
        """
        if not (focal_length > 0 and sensor_width > 0):
            raise ValueError(
                f"expected a focal length and a sensor above 0, got {focal_length} and {sensor_width}"
            )
        distance = math.hypot(*position)
        if not distance > 1:
            raise ValueError(f"expected a camera outside the sphere of radius 1, got {position}")
        x, y, z = (p / distance for p in position)
        pixels = focal_length / sensor_width * width
        return cls(width, height, (x, y, z), distance, pixels / math.sqrt(distance**2 - 1))

    def scaled(self, factor: float) -> SphereCamera:
        """The same view in more or fewer pixels.

        Raises:
            ValueError: If the picture's width and height do not become whole numbers.

        >>> SphereCamera.orthographic(64).scaled(0.25).radius
        8.0
        """
        width, height = self.width * factor, self.height * factor
        if width != int(width) or height != int(height):
            raise ValueError(
                f"expected a factor that keeps {self.width} x {self.height} pixels whole, got {factor}"
            )
        return replace(self, width=int(width), height=int(height), radius=self.radius * factor)

    def cropped(self) -> SphereCamera:
        """The same view in the smallest picture about the same centre, of the same pixels, that holds the
        outline.

        >>> cropped = SphereCamera.perspective((16, 2, 0), 85, 36, 960, 540).cropped()
        >>> cropped.width, cropped.height
        (282, 282)
        """
        # An even size stays even, and an odd one odd, so that the pixels stay where they are.
        width, height = (
            min(size, size % 2 + 2 * math.ceil(self.radius - size % 2 / 2))
            for size in (self.width, self.height)
        )
        return replace(self, width=width, height=height)

    @property
    def fov_x(self) -> float | None:
        """Horizontal angle of view in radians; none if orthographic."""
        if math.isinf(self.distance):
            return None
        return 2 * math.atan(self.width / (2 * self.radius * math.sqrt(self.distance**2 - 1)))

    @property
    def axes(self) -> Float[Tensor, "3 3"]:
        """Rows: the picture's right, its up, and the direction from the sphere to the camera (float64)."""
        towards = torch.tensor(self.towards, dtype=torch.float64)
        right = torch.linalg.cross(torch.tensor([0.0, 1.0, 0.0], dtype=torch.float64), towards)
        right = right / right.norm()
        return torch.stack((right, torch.linalg.cross(towards, right), towards))

    def sight(self, incidence: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Angle p between the axis and the ray that arrives at this angle of incidence b."""
        return (incidence.sin() / self.distance).asin()

    def lean(self, incidence: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Angle t between the axis and the normal where the ray of this incidence b arrives."""
        return incidence - self.sight(incidence)

    def incidence(self, lean: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Angle of incidence b where the normal leans by t: the inverse of `lean`."""
        return lean + torch.atan2(lean.sin(), self.distance - lean.cos())

    def place(self, incidence: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Distance r from the picture's centre, in radii of the outline, of rays of an incidence b."""
        if math.isinf(self.distance):
            return incidence.sin()
        return self.sight(incidence).tan() * math.sqrt(self.distance**2 - 1)

    def incidence_at(self, place: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Angle of incidence b at a distance r from the picture's centre: the inverse of `place`."""
        if math.isinf(self.distance):
            return place.asin()
        sine = (place / math.sqrt(self.distance**2 - 1)).atan().sin()
        return (sine * self.distance).clamp(max=1).asin()

    def area(self, incidence: Float[Tensor, "*n"]) -> Float[Tensor, "*n"]:
        """Area of the picture, in squared radii, per unit of incidence b and of azimuth: r dr/db."""
        area = self.place(incidence) * incidence.cos()
        if math.isinf(self.distance):
            return area
        return area * (math.sqrt(self.distance**2 - 1) / self.distance) / self.sight(incidence).cos() ** 3

    def views(self, normals: Float[Tensor, "*n 3"]) -> Float[Tensor, "*n 3"]:
        """Unit directions to the camera from the points of the sphere that have these normals.

        >>> SphereCamera.orthographic(8).views(torch.tensor([0.6, 0.0, 0.8])).tolist()
        [0.0, 0.0, 1.0]
        """
        towards = normals.new_tensor(self.towards)
        if math.isinf(self.distance):
            return towards.expand_as(normals)
        return torch.nn.functional.normalize(self.distance * towards - normals, dim=-1)
