"""Mitsuba 3 as the renderer of insertions (`pip install "mixlight[insert]"`).

The variant is scalar_rgb: it is in every wheel and needs no compiler at run time, while the LLVM variants
depend on a library of the system, whose unsuitable versions end the whole process and not merely the call.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from jaxtyping import Float

from mixlight.render.insertion import InsertionScene, Region, Renders
from mixlight.render.model import Material, Part
from mixlight.sphere import frames

__all__ = ["VARIANT", "MitsubaMissing", "check", "render"]

VARIANT = "scalar_rgb"
MAX_DEPTH = 6
"""Segments of a path; object and ground exchange light up to this often."""

MATTE = 0.95
"""A surface that is rougher than this and no metal is Lambert's: the principled material would make it up to
twice as bright at its rim, where Blender and glTF do not."""


class MitsubaMissing(ValueError):
    """Mitsuba is not installed; the message says how to get it."""


@contextmanager
def _mitsuba() -> Iterator[Any]:
    """The module with our variant set; the caller's variant is set again afterwards."""
    try:
        import mitsuba
    except ImportError as error:
        raise MitsubaMissing(
            f'expected Mitsuba 3 (pip install "mixlight[insert]"), received: {error}'
        ) from None
    before = mitsuba.variant()
    mitsuba.set_variant(VARIANT)
    try:
        yield mitsuba
    finally:
        if before is not None:
            mitsuba.set_variant(before)


def check() -> None:
    """See that Mitsuba is there, before any work is done.

    Raises:
        MitsubaMissing: (a ValueError) it is not.
    """
    with _mitsuba():
        pass


def render(scene: InsertionScene, region: Region, *, samples: int, runs: int = 1, seed: int = 0) -> Renders:
    """Render a region of the photo: the scene, the ground alone, and the object's coverage.

    With and without the object every pixel uses the same random numbers, so that their difference is free of
    noise wherever the object changes nothing.

    Args:
        scene: what to render.
        region: pixels of the photo.
        samples: for each pixel and run.
        runs: independent renderings, from which the noise can be told.
        seed: of the random numbers.

    Raises:
        MitsubaMissing: (a ValueError) Mitsuba is not installed.
    """
    samples = _stratified(samples)
    with _mitsuba() as mi:
        light = _light(mi, scene)
        ground = _ground(mi, scene)
        parts = {f"part_{i}": _mesh(mi, part) for i, part in enumerate(scene.parts)}
        sensor = _sensor(mi, scene, region, samples)
        path = {"type": "path", "max_depth": MAX_DEPTH, "hide_emitters": True}
        base = {"type": "scene", "light": light, "sensor": sensor, "integrator": path}
        with_object = mi.load_dict(base | {"ground": ground} | parts)
        without = mi.load_dict(base | {"ground": ground})
        # Two segments end at the first surface: the cheapest picture with an alpha channel.
        alone = mi.load_dict(base | {"integrator": path | {"max_depth": 2}} | parts)
        pictures = [
            [np.array(mi.render(each, spp=samples, seed=seed + run)) for run in range(runs)]
            for each in (with_object, without, alone)
        ]
    return Renders(
        np.stack([p[..., :3] for p in pictures[0]]),
        np.stack([p[..., :3] for p in pictures[1]]),
        np.mean([p[..., 3] for p in pictures[2]], axis=0).clip(0, 1),
    )


def _stratified(samples: int) -> int:
    """The least number of at least so many that fills a grid, as the sampler wants it.

    >>> [_stratified(n) for n in (1, 4, 5, 16, 32)]
    [1, 4, 6, 16, 35]
    """
    rows = math.isqrt(samples)
    return rows * math.ceil(samples / rows)


def _light(mi: Any, scene: InsertionScene) -> Any:
    rolled = frames.convert_panorama(scene.environment.detach().float().cpu(), "mixlight", "mitsuba")
    return mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(rolled.numpy()))})


def _sensor(mi: Any, scene: InsertionScene, region: Region, samples: int) -> dict[str, Any]:
    camera = scene.camera
    axes = camera.axes
    transform = mi.ScalarTransform4f().look_at(
        origin=[0, 0, 0], target=(-axes[:, 2]).tolist(), up=axes[:, 1].tolist()
    )
    return {
        "type": "perspective",
        "fov_axis": "x",
        "fov": math.degrees(camera.fov_x),
        "near_clip": 1e-3,
        "far_clip": 1e5,
        "to_world": transform,
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "crop_offset_x": region.left,
            "crop_offset_y": region.top,
            "crop_width": region.width,
            "crop_height": region.height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgba",
            "component_format": "float32",
        },
        "sampler": {"type": "multijitter", "sample_count": samples},
    }


def _ground(mi: Any, scene: InsertionScene) -> dict[str, Any]:
    ground = scene.ground
    transform = mi.ScalarTransform4f
    # The rectangle of Mitsuba spans [-1, 1] in x and y, faces +z, and shows v = 0 at y = -1.
    return {
        "type": "rectangle",
        "to_world": transform()
        .translate(ground.centre.tolist())
        .rotate([1, 0, 0], -90)
        .scale([ground.half_side, ground.half_side, 1]),
        "bsdf": {"type": "diffuse", "reflectance": _texture(mi, ground.albedo)},
    }


def _texture(mi: Any, linear: Float[np.ndarray, "rows columns channels"]) -> dict[str, Any]:
    # Mitsuba counts v downwards from the first row, and the rectangle's v upwards from y = -1.
    pixels = np.ascontiguousarray(linear[::-1], dtype=np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(pixels), "raw": True, "filter_type": "bilinear"}


def _mesh(mi: Any, part: Part) -> Any:
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": _material(mi, part.material)})
    mesh = mi.Mesh(
        "part",
        len(part.positions),
        len(part.triangles),
        has_vertex_normals=True,
        has_vertex_texcoords=part.uv is not None,
        props=properties,
    )
    values = mi.traverse(mesh)
    values["vertex_positions"] = part.positions.astype(np.float32).ravel()
    values["vertex_normals"] = part.normals.astype(np.float32).ravel()
    values["faces"] = part.triangles.astype(np.uint32).ravel()
    if part.uv is not None:
        upright = np.stack([part.uv[:, 0], 1 - part.uv[:, 1]], -1)
        values["vertex_texcoords"] = upright.astype(np.float32).ravel()
    values.update()
    return mesh


def _material(mi: Any, material: Material) -> dict[str, Any]:
    """Mitsuba's principled material, or Lambert's for what is neither metal nor at all glossy."""
    color = np.array(material.base_color)
    base: Any = {"type": "rgb", "value": color.tolist()}
    if material.base_texture is not None:
        base = _texture(mi, material.base_texture * color)
    metallic: Any = material.metallic
    roughness: Any = material.roughness
    if material.surface_texture is not None:
        metallic = _texture(mi, material.surface_texture[..., :1] * metallic)
        roughness = _texture(mi, material.surface_texture[..., 1:] * roughness)
    elif metallic == 0 and roughness >= MATTE:
        return {"type": "diffuse", "reflectance": base}
    return {"type": "principled", "base_color": base, "metallic": metallic, "roughness": roughness}
