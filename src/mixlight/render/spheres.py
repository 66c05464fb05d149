"""Pictures of the three test spheres, one at a time, under an environment map."""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import safetensors
import safetensors.torch
import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn
from torch.nn import functional

from mixlight.image.atomic import atomic_path
from mixlight.light import principled, reflection, sphere_camera, sphere_samples, surfaces, transport
from mixlight.light.reflection import MATERIALS, Material, reflect
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.sphere_samples import picture_samples
from mixlight.light.surfaces import mirror_reflectance
from mixlight.light.transport import mirror_taps
from mixlight.render import rings
from mixlight.render.rings import Interpolation, RingTransport, bag_offsets
from mixlight.sphere import equirect, grid

_SAMPLES_ACROSS = 256
"""Samples across the disc for diffuse and GGX spheres, whose pictures are smooth."""

_MIRROR_SAMPLES_ACROSS = 512
"""Samples across the disc for mirrors: two for each texel of a map of 128x256."""


class SphereRenderer(nn.Module):
    """Renders spheres under environment maps: exact light transport as a linear, differentiable operator.

    One sphere in space, lit by the map alone; no ground, no exposure, no tone curve. A renderer is built once
    (in a second or two, or read from a cache) and used for any number of maps.

    Convention: the sphere stands where the photo was taken, and unless told otherwise the camera looks from
    afar along -Z like the photo's: the picture's right is +X, its top +Y, and its centre faces +Z, so the
    mirror's centre shows what is behind the photographer, just as an object put into the photo would. Under
    radiance 1 from everywhere the diffuse sphere and the mirror show .8.

    >>> renderer = SphereRenderer(resolution=32)
    >>> pictures = renderer.render(torch.ones(64, 128, 3))
    >>> pictures.shape, [round(x.item(), 3) for x in pictures[:, 16, 16, 0]]
    (torch.Size([3, 32, 32, 3]), [0.8, 0.789, 0.8])
    """

    rings: RingTransport | None
    """Transport of the diffuse and rough materials."""
    mask: Tensor
    """[height, width] bool: True where the pixel's centre lies on the sphere."""
    mirror_index: Tensor
    mirror_offsets: Tensor
    """Bags of texels that each pixel of a mirror shows. Their weights are in `mirror_weight` (colour not
    included) and, for metals, whose reflectance depends on the angle, in one `metal_weight_<i>` each."""
    mirror_weight: Tensor

    def __init__(
        self,
        resolution: int = 128,
        height: int = 128,
        materials: Sequence[Material] = MATERIALS,
        *,
        camera: SphereCamera | None = None,
        interpolation: Interpolation = "constant",
        rim_step: float | None = None,
        cache: Path | None = None,
    ) -> None:
        """Build the tables, or take those that were built before.

        Args:
            resolution: Width and height of the pictures in pixels; not used where a camera is given.
            height: Rows of the map that is rendered; maps of another size are resized with their energy kept.
                Protocols M and S render at 128x256.
            materials: What the spheres are made of; the three of protocol M if not given.
            camera: Who looks, and the size of the picture; from afar if not given.
            interpolation: What a map is between its texels' centres for diffuse and rough materials. Mirrors
                always read it bilinearly.
            rim_step: Largest step between a mirror's samples in its rim pixels, in radians of the angle of
                incidence (`picture_samples`); half a texel of the map as the mirror sees it if not given.
            cache: Folder where tables are kept between runs (`mixlight.image.cache.cache_folder`); nothing is
                kept if not given.

        Raises:
            ValueError: If a size is below 1, or a GGX alpha is too small for the method (use a mirror).
        """
        super().__init__()
        if height < 1:
            raise ValueError(f"expected a map of at least one row, got {height}")
        self.camera = SphereCamera.orthographic(resolution) if camera is None else camera
        self.height = height
        self.materials = tuple(materials)
        self.rim_step = rim_step = math.pi / (4 * height) if rim_step is None else rim_step
        key = self._key(interpolation, rim_step)
        path = None if cache is None else cache / f"{key}.safetensors"
        if path is None or not self._load(path):
            self._build(interpolation, rim_step)
            if path is not None:
                self._save(path)

    def _build(self, interpolation: Interpolation, rim_step: float) -> None:
        """Make the tables."""
        camera = self.camera
        across = round(2 * camera.radius)
        samples = picture_samples(camera, _per_pixel(_SAMPLES_ACROSS, across))
        self.register_buffer("mask", samples.mask, persistent=False)
        glossy = [material for material in self.materials if not material.is_mirror]
        self.rings = RingTransport(glossy, samples, self.height, interpolation) if glossy else None
        mirrors = {i: material for i, material in enumerate(self.materials) if material.is_mirror}
        if mirrors:
            per_pixel = _per_pixel(_MIRROR_SAMPLES_ACROSS, across)
            samples = picture_samples(camera, per_pixel, rim_step=rim_step)
            views = camera.views(samples.normals)
            index, weight = mirror_taps(reflect(samples.normals, views), self.height)
            weight = weight * samples.weight[:, None]
            self.register_buffer("mirror_index", index.flatten(), persistent=False)
            self.register_buffer("mirror_offsets", bag_offsets(samples), persistent=False)
            cos_view = (samples.normals * views).sum(-1)
            for i, material in mirrors.items():
                if material.kind == "metal":
                    shown = weight * mirror_reflectance(material, cos_view)[:, None]
                    self.register_buffer(f"metal_weight_{i}", shown.flatten().float(), persistent=False)
            if any(material.kind == "mirror" for material in mirrors.values()):
                self.register_buffer("mirror_weight", weight.flatten().float(), persistent=False)

    def _key(self, interpolation: Interpolation, rim_step: float) -> str:
        """Name of the tables in a cache: everything that they depend on, the code included."""
        said = repr((self.camera, self.height, self.materials, interpolation, rim_step))
        return hashlib.sha256(said.encode() + _code_digest()).hexdigest()[:40]

    def _save(self, path: Path) -> None:
        """Keep the tables; a folder that cannot be written costs the time of building, nothing else."""
        tables = {name: table.contiguous() for name, table in self.named_buffers()}
        with contextlib.suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_path(path) as temporary:
                safetensors.torch.save_file(tables, temporary)

    def _load(self, path: Path) -> bool:
        """Take kept tables; False if there are none that can be read."""
        try:
            tables = safetensors.torch.load_file(path)
        except (OSError, safetensors.SafetensorError):
            return False
        of_rings = {
            name.removeprefix("rings."): table for name, table in tables.items() if name.startswith("rings.")
        }
        glossy = sum(not material.is_mirror for material in self.materials)
        self.rings = RingTransport.of_tables(of_rings, glossy) if glossy else None
        for name, table in tables.items():
            if not name.startswith("rings."):
                self.register_buffer(name, table, persistent=False)
        return True

    def render(
        self, environment: Float[Tensor, "*batch height width channels"]
    ) -> Float[Tensor, "*batch spheres rows columns channels"]:
        """Pictures of all spheres in linear radiance, in the map's units; 0 outside `mask`.

        Raises:
            ValueError: If the map is not 2:1.
        """
        if environment.ndim < 3 or environment.shape[-2] != 2 * environment.shape[-3]:
            raise ValueError(
                f"expected an environment of shape [..., H, 2 H, channels], got {tuple(environment.shape)}"
            )
        batch, channels = environment.shape[:-3], environment.shape[-1]
        precise = environment.to(torch.promote_types(environment.dtype, torch.float32))
        if environment.shape[-3] != self.height:
            precise = equirect.resize(precise, self.height)
        # Batch and channels side by side: every table is walked once for all of them.
        texels = precise.reshape(-1, 2 * self.height**2, channels).transpose(0, 1).flatten(1)
        with torch.autocast(environment.device.type, enabled=False):
            pixels = self._pixels(texels)
        pictures = texels.new_zeros(len(self.materials), *self.mask.shape, texels.shape[1])
        pictures[:, self.mask] = pixels
        pictures = pictures.reshape(*pictures.shape[:3], -1, channels).movedim(3, 0)
        return pictures.reshape(*batch, *pictures.shape[1:]).to(environment.dtype)

    def forward(
        self, environment: Float[Tensor, "*batch height width channels"]
    ) -> Float[Tensor, "*batch spheres rows columns channels"]:
        """Same as `render`."""
        return self.render(environment)

    def _pixels(self, texels: Tensor) -> Tensor:
        """[texels, columns] -> [spheres, pixels, columns]."""
        glossy = iter(self.rings(texels)) if self.rings is not None else iter(())
        mirror: Tensor | None = None
        pixels = []
        for i, material in enumerate(self.materials):
            if not material.is_mirror:
                pixels.append(next(glossy))
            elif material.kind == "metal":
                pixels.append(self._reflection(texels, self.get_buffer(f"metal_weight_{i}")))
            else:
                mirror = self._reflection(texels, self.mirror_weight) if mirror is None else mirror
                pixels.append(mirror * material.reflectance)
        return torch.stack(pixels)

    def _reflection(self, texels: Tensor, weight: Tensor) -> Tensor:
        """[texels, columns] -> [pixels, columns]."""
        return functional.embedding_bag(
            self.mirror_index,
            texels,
            self.mirror_offsets,
            mode="sum",
            per_sample_weights=weight.to(texels.dtype),
        )


def render_spheres(
    environment: Float[Tensor, "*batch height width channels"], resolution: int = 128
) -> tuple[Float[Tensor, "*batch 3 resolution resolution channels"], Bool[Tensor, "resolution resolution"]]:
    """Render the diffuse, matte and mirror sphere of protocol M under an environment map.

    For many maps build a `SphereRenderer` once.

    Args:
        environment: Linear radiance, our frame, any 2:1 size.
        resolution: Width and height of the pictures in pixels.

    Returns:
        Linear pictures in the map's units, and the mask of the sphere's pixels.

    Convention: as `SphereRenderer`.

    Raises:
        ValueError: If the map is not 2:1.

    >>> pictures, mask = render_spheres(torch.ones(64, 128, 3), resolution=16)
    >>> round(pictures[0][mask].mean().item(), 3), round(pictures[2][mask].mean().item(), 3)
    (0.8, 0.8)
    """
    renderer = SphereRenderer(resolution).to(environment.device)
    return renderer.render(environment), renderer.mask


@lru_cache(maxsize=1)
def _code_digest() -> bytes:
    """Of the modules that the tables come from, so that those of another version are not taken for ours."""
    modules = (
        grid, sphere_camera, sphere_samples, reflection, principled, surfaces, transport, rings,
    )  # fmt: skip
    files = [Path(__file__), *(Path(str(module.__file__)) for module in modules)]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).digest()


def _per_pixel(across: int, resolution: int) -> int:
    """Samples a pixel and axis: at least two, for the rim."""
    return max(2, math.ceil(across / max(resolution, 1)))
