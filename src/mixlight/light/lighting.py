"""What light is: ambient harmonics plus sparse spherical Gaussians on a fixed set of anchors."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mixlight.light import gaussians, harmonics
from mixlight.light.separate import luminance
from mixlight.sphere import frames
from mixlight.sphere.points import nearest, vogel

FRAME = "mixlight"
"""The frame that every lighting is held in."""

NEGLIGIBLE = 1e-4
"""A lobe below this share of the sources' luminance counts as switched off."""


@dataclass(frozen=True, eq=False)
class Group:
    """Lobes that are one light under a lasting name, whatever its place in the order of brightness.

    >>> Group("window", (3, 5)).off is None
    True
    """

    name: str
    """What the light is called."""
    anchors: tuple[int, ...]
    """Its lobes, ascending."""
    off: Float[Tensor, "lobes 3"] | None = None
    """Energy of each lobe when the light is switched on again; None while it is on."""


if TYPE_CHECKING:
    Groups = tuple[Group, ...]
else:
    # Checked below, one by one: the type checker of the tests would look at one drawn by chance, which
    # hypothesis refuses wherever a strategy makes a lighting.
    Groups = tuple


@dataclass(frozen=True, eq=False)
class Lighting:
    """The light of a scene: an environment in closed form, small enough for a page of JSON.

    Its radiance in the direction d is the sum of the ambient expansion and of the lobes. Immutable; a leading
    batch is allowed in ``ambient`` and ``energy`` alike (`active`, `mixlight.light.lights` and documents want
    a single one).

    Convention: +X right, +Y up, -Z forward, where -Z is the azimuth of the photo; the horizon is level.
        Radiance 1.0 is the photo's linear white. A lighting of ambient (sqrt(4 pi), 0, ...) has the radiance
        1 everywhere.

    Raises:
        ValueError: shapes that do not fit each other, NaN or infinite values, negative energies, a sharpness
            or exposure gain that is not above 0, another frame.

    >>> ambient = torch.zeros(9, 3)
    >>> ambient[0] = math.sqrt(4 * math.pi)
    >>> Lighting(ambient, torch.zeros(128, 3)).environment(64).mean()
    tensor(1.)
    """

    ambient: Float[Tensor, "*batch k 3"]
    """Radiance coefficients of the ambient light, (degree + 1)^2 of them (`mixlight.light.harmonics`)."""
    energy: Float[Tensor, "*batch anchors 3"]
    """Integrated radiance of the lobe on each anchor, rgb; most are 0."""
    sharpness: float = gaussians.SHARPNESS
    """The lobes' s (`mixlight.light.gaussians`)."""
    exposure_gain: float = 1.0
    """Stored radiance over absolute radiance, where that is known: `absolute` divides by it."""
    frame: str = "mixlight"
    """Name of the frame (`mixlight.sphere.frames`); always ours in memory, other frames are made on
    export."""
    turn: float = 0.0
    """Angle in radians by which the anchors stand turned to the right about +Y (`turned`); the ambient light
    is held as it is seen."""
    groups: Groups = ()
    """Lights with lasting names (`mixlight.light.edit`), for a single lighting; those not in here are named
    by their brightness (`mixlight.light.lights.merge`)."""

    def __post_init__(self) -> None:
        harmonics.degree_of(self.ambient)
        if (
            self.ambient.shape[-1] != 3
            or self.energy.shape[-1:] != (3,)
            or self.energy.ndim != self.ambient.ndim
        ):
            raise ValueError(
                "ambient and energy: expected [..., k, 3] and [..., anchors, 3], received "
                f"{tuple(self.ambient.shape)} and {tuple(self.energy.shape)}"
            )
        if self.ambient.shape[:-2] != self.energy.shape[:-2]:
            raise ValueError(
                "ambient and energy: expected one leading batch, received "
                f"{tuple(self.ambient.shape)} and {tuple(self.energy.shape)}"
            )
        if not bool(torch.isfinite(self.ambient).all()):
            raise ValueError("ambient: expected finite coefficients, received NaN or infinity")
        if not bool((torch.isfinite(self.energy) & (self.energy >= 0)).all()):
            raise ValueError(
                "energy: expected finite values of at least 0, received NaN, infinity or negative ones"
            )
        if not math.isfinite(self.turn):
            raise ValueError(f"turn: expected a finite angle, received {self.turn!r}")
        self._check_groups()
        for name, value in (("sharpness", self.sharpness), ("exposure_gain", self.exposure_gain)):
            if not (value > 0 and math.isfinite(value)):
                raise ValueError(f"{name}: expected a number above 0, received {value!r}")
        if self.frame != FRAME:
            raise ValueError(
                f"frame: expected {FRAME!r} (others are made on export), received {self.frame!r}"
            )

    @property
    def degree(self) -> int:
        """Degree of the ambient harmonics."""
        return harmonics.degree_of(self.ambient)

    @property
    def axes(self) -> Float[Tensor, "anchors 3"]:
        """Unit directions of the anchors."""
        count, to = self.energy.shape[-2], self.energy
        if not self.turn:
            return vogel(count, dtype=to.dtype, device=to.device)
        axes = vogel(count, dtype=torch.float64) @ frames.rotation(self.turn, dtype=torch.float64).T
        return axes.to(dtype=to.dtype, device=to.device)

    @property
    def active(self) -> Int[Tensor, " active"]:
        """Indices of the anchors that carry more than 1e-4 of the sources' luminance, ascending.

        Raises:
            ValueError: a batch of lightings.

        >>> Lighting(torch.zeros(9, 3), torch.tensor([[1.0, 1, 1], [0, 0, 0], [5e-5, 0, 0]])).active
        tensor([0])
        """
        self._single("active")
        return self._strong(NEGLIGIBLE).nonzero()[:, 0]

    def environment(self, height: int = 128) -> Float[Tensor, "*batch height width 3"]:
        """Panorama [*batch, height, 2 height, 3]: the ambient light, clamped at 0, plus the lobes.

        Raises:
            ValueError: height is below 1.

        >>> Lighting(torch.zeros(9, 3), torch.eye(128)[:, :3]).environment(32).shape
        torch.Size([32, 64, 3])
        """
        return self.ambient_map(height) + self.sources_map(height)

    def ambient_map(self, height: int = 128, clamp: bool = True) -> Float[Tensor, "*batch height width 3"]:
        """Panorama of the ambient light alone; without ``clamp`` the expansion's negative lobes stay in."""
        panorama = harmonics.evaluate_map(self.ambient, height)
        return panorama.clamp_min(0) if clamp else panorama

    def sources_map(self, height: int = 128) -> Float[Tensor, "*batch height width 3"]:
        """Panorama of the lobes alone; its energy is theirs on any height
        (`mixlight.light.gaussians.evaluate_map`).
        """
        return gaussians.evaluate_map(self.axes, self.energy, self.sharpness, height)

    def pruned(self, share: float = NEGLIGIBLE) -> "Lighting":
        """The lighting without lobes of at most ``share`` of the sources' luminance.

        They are not lost: each goes into the ambient light as its own harmonics, so that the total energy
        stays and so does the irradiance on any surface, up to the ambient light's degree.

        >>> lighting = Lighting(torch.zeros(9, 3), torch.tensor([[1.0, 1, 1], [0, 0, 0], [5e-5, 0, 0]]))
        >>> lighting.pruned().energy.count_nonzero(), lighting.pruned().total_energy()
        (tensor(3), tensor([1.0001, 1.0000, 1.0000]))
        """
        strong = self._strong(share)[..., None]
        weak = torch.where(strong, 0, self.energy)
        handed = gaussians.to_harmonics(self.axes, weak, self.sharpness, self.degree)
        return replace(self, ambient=self.ambient + handed, energy=torch.where(strong, self.energy, 0))

    def without(self, anchors: Int[Tensor, " some"] | list[int] | tuple[int, ...]) -> "Lighting":
        """The lighting with some lobes switched off, for a map to go beside the lights made of them.

        >>> Lighting(torch.zeros(9, 3), torch.ones(4, 3)).without([0, 2]).energy[:, 0]
        tensor([0., 1., 0., 1.])
        """
        energy = self.energy.clone()
        energy[..., torch.as_tensor(anchors, dtype=torch.long), :] = 0
        return replace(self, energy=energy)

    def scaled(self, gain: float | Float[Tensor, "3"] | tuple[float, float, float]) -> "Lighting":
        """The lighting made brighter by a factor, or tinted by one a channel; the exposure gain is left as it
        is.

        Raises:
            ValueError: the gain is negative.

        >>> Lighting(torch.ones(9, 3), torch.ones(4, 3)).scaled((1.0, 2.0, 3.0)).energy[0]
        tensor([1., 2., 3.])
        """
        factor = torch.as_tensor(gain, dtype=self.energy.dtype, device=self.energy.device)
        if factor.shape not in ((), (3,)):
            raise ValueError(
                f"gain: expected a number or one for each of 3 channels, received {tuple(factor.shape)}"
            )
        groups = tuple(
            group if group.off is None else replace(group, off=group.off * factor) for group in self.groups
        )
        return replace(self, ambient=self.ambient * factor, energy=self.energy * factor, groups=groups)

    def exposed(self, gain: float) -> "Lighting":
        """The same light photographed with ``gain`` times the exposure: radiance and the exposure gain are
        multiplied.

        >>> Lighting(torch.ones(9, 3), torch.ones(4, 3)).exposed(0.5).exposure_gain
        0.5
        """
        if not (gain > 0 and math.isfinite(gain)):
            raise ValueError(f"gain: expected a number above 0, received {gain!r}")
        return replace(self.scaled(gain), exposure_gain=self.exposure_gain * gain)

    def absolute(self) -> "Lighting":
        """The light on its absolute scale: the exposure gain taken out again.

        >>> Lighting(torch.ones(9, 3), torch.ones(4, 3)).exposed(0.5).absolute().energy[0]
        tensor([1., 1., 1.])
        """
        return replace(self.scaled(1 / self.exposure_gain), exposure_gain=1.0)

    def turned(self, yaw: float) -> "Lighting":
        """The light turned to the right about the vertical, exactly: ambient light, lobes and their names.

        The lobes keep their anchors, which turn as a whole (`turn`), so turning back gives the light that
        was.

        Args:
            yaw: angle in radians; what came from ahead (-Z) comes from the right (+X) after pi / 2.

        Raises:
            ValueError: the angle is not finite.

        >>> lighting = Lighting(torch.zeros(9, 3), torch.eye(4)[:, :3])
        >>> lighting.axes[0], lighting.turned(math.pi / 6).axes[0]
        (tensor([ 0.0000,  0.7500, -0.6614]), tensor([ 0.3307,  0.7500, -0.5728]))
        """
        if not math.isfinite(yaw):
            raise ValueError(f"yaw: expected a finite angle, received {yaw!r}")
        matrix = frames.rotation(yaw, dtype=torch.float64, device=self.ambient.device)
        ambient = harmonics.rotate(self.ambient, matrix)
        return replace(self, ambient=ambient, turn=math.remainder(self.turn + yaw, 2 * math.pi))

    def rotated(self, rotation: Float[Tensor, "3 3"]) -> "Lighting":
        """The light turned: what came from d comes from R d. About the vertical, use `turned`.

        The ambient light is turned exactly. A lobe moves to the anchor nearest to its turned axis (at most
        about 10 degrees away for 128 anchors), where its energy is kept; two lobes may meet there, so lasting
        names end (`groups`), and a light that is off is gone.

        Raises:
            ValueError: the rotation is not orthogonal.

        >>> lighting = Lighting(torch.zeros(9, 3), torch.eye(128)[:, :3])
        >>> turned = lighting.rotated(torch.diag(torch.tensor([1.0, -1.0, -1.0])))
        >>> turned.active.tolist(), turned.total_energy()
        ([125, 126, 127], tensor([1., 1., 1.]))
        """
        ambient = harmonics.rotate(self.ambient, rotation.to(self.ambient.device))
        energy = self._moved(self.axes @ rotation.to(self.axes).T)
        return replace(self, ambient=ambient, energy=energy, groups=())

    def mirrored(self) -> "Lighting":
        """The light with left and right exchanged; lobes move to the nearest anchors as in `rotated`.

        >>> Lighting(torch.ones(9, 3), torch.ones(4, 3)).mirrored().ambient[3]
        tensor([-1., -1., -1.])
        """
        flip = torch.tensor([-1.0, 1.0, 1.0]).to(self.axes)
        ambient = harmonics.mirror(self.ambient)
        return replace(self, ambient=ambient, energy=self._moved(self.axes * flip), groups=())

    def irradiance(self, normals: Float[Tensor, "*points 3"]) -> Float[Tensor, "... 3"]:
        """Irradiance on unshadowed surfaces with the given unit normals, [*batch, *points, 3].

        The ambient part is exact for its degree and not clamped, the lobes' part includes their extent
        (`mixlight.light.gaussians.irradiance`). A Lambertian surface shows albedo times it over pi.

        >>> ambient = torch.zeros(9, 3)
        >>> ambient[0] = math.sqrt(4 * math.pi)
        >>> Lighting(ambient, torch.zeros(128, 3)).irradiance(torch.tensor([0.0, 1.0, 0.0]))
        tensor([3.1416, 3.1416, 3.1416])
        """
        lit = (self.energy != 0).any(-1).reshape(-1, self.energy.shape[-2]).any(0)
        sources = gaussians.irradiance(self.axes[lit], self.energy[..., lit, :], self.sharpness, normals)
        return harmonics.irradiance(self.ambient, normals) + sources

    def total_energy(self) -> Float[Tensor, "*batch 3"]:
        """Integral of the radiance over the sphere, before any clamping.

        >>> Lighting(torch.zeros(9, 3), torch.ones(4, 3)).total_energy()
        tensor([4., 4., 4.])
        """
        return self.ambient[..., 0, :] * math.sqrt(4 * math.pi) + self.energy.sum(-2)

    def to(self, target: torch.device | str | torch.dtype) -> "Lighting":
        """The lighting on another device or in another dtype.

        >>> Lighting(torch.zeros(9, 3), torch.ones(4, 3)).to(torch.float64).energy.dtype
        torch.float64
        """
        groups = tuple(
            group if group.off is None else replace(group, off=group.off.to(target)) for group in self.groups
        )
        return replace(self, ambient=self.ambient.to(target), energy=self.energy.to(target), groups=groups)

    def _check_groups(self) -> None:
        """Refuse groups of a batch, without a name or lobes, or that share one."""
        if not self.groups:
            return
        self._single("groups")
        names = [group.name for group in self.groups]
        if not all(names) or len(set(names)) < len(names):
            raise ValueError(f"groups: expected a name of its own for each, received {names}")
        anchors = [anchor for group in self.groups for anchor in group.anchors]
        if len(set(anchors)) < len(anchors) or not set(anchors) <= set(range(len(self.energy))):
            raise ValueError(
                f"groups: expected anchors from 0 to {len(self.energy) - 1}, each in one group, received "
                f"{sorted(anchors)}"
            )
        for group in self.groups:
            if not group.anchors or list(group.anchors) != sorted(group.anchors):
                raise ValueError(
                    f"groups: expected ascending anchors, one at least, for {group.name!r}, received "
                    f"{group.anchors}"
                )
            if group.off is None:
                continue
            if group.off.shape != (len(group.anchors), 3) or not bool(
                (torch.isfinite(group.off) & (group.off >= 0)).all()
            ):
                raise ValueError(
                    f"groups: expected finite energies of at least 0 for the {len(group.anchors)} lobes of "
                    f"{group.name!r}, received {group.off.tolist()}"
                )
            if bool((self.energy[list(group.anchors)] != 0).any()):
                raise ValueError(f"groups: expected no energy on the lobes of {group.name!r}, which is off")

    def _strong(self, share: float) -> Tensor:
        """[*batch, anchors]: which lobes carry more than the share of the sources' luminance."""
        power = luminance(self.energy)
        return power > share * power.sum(-1, keepdim=True)

    def _moved(self, axes: Tensor) -> Tensor:
        target = nearest(self.axes, axes)
        return torch.zeros_like(self.energy).index_add(-2, target, self.energy)

    def _single(self, what: str) -> None:
        if self.ambient.ndim != 2:
            raise ValueError(
                f"{what}: expected a single lighting, received a batch of {list(self.ambient.shape[:-2])}"
            )
