"""A scene as files for Blender, and Blender's files as arrays."""

import json
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import torch

from mixlight.data.rooms import shapes
from mixlight.data.rooms.job import Settings, read_raw, write_job
from mixlight.data.rooms.mesh import Emission, Mesh, Part
from mixlight.data.rooms.plan import Surface
from mixlight.data.rooms.scene import build
from mixlight.image import exr
from tests.data.rooms.boxes import LAMP, box_scene, open_scene, plain_plan

SMALL = Settings(width=16, samples=2)


def written(scene: object, folder: Path) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    write_job(scene, SMALL, folder)  # type: ignore[arg-type]
    with np.load(folder / "arrays.npz") as arrays:
        return json.loads((folder / "scene.json").read_text()), dict(arrays)


def test_parts_of_one_material_become_one_mesh(tmp_path: Path) -> None:
    grey, red = Surface("paint"), Surface("paint", (0.5, 0.1, 0.1))
    parts = (
        Part(shapes.box((0, 0, 0), (1, 1, 1)), grey, "first"),
        Part(shapes.box((2, 0, 0), (3, 1, 1)), red, "second"),
        Part(shapes.box((4, 0, 0), (5, 1, 1)), grey, "third"),
    )
    job, arrays = written(open_scene(parts=parts), tmp_path)
    meshes = job["meshes"]
    assert [m["name"] for m in meshes] == ["first", "second"]  # type: ignore[attr-defined, index]
    assert len(arrays["m0.vertices"]) == 48
    assert arrays["m0.starts"].tolist() == list(range(0, 48, 4))
    # The second box's faces point to its own corners.
    assert arrays["m0.vertices"][arrays["m0.corners"][24:]].min(0).tolist() == [4.0, 0.0, 0.0]


def test_triangles_and_quads(tmp_path: Path) -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0]])
    mesh = Mesh(corners, np.array([[0, 1, 2, 3], [3, 2, 4, -1]]))
    _, arrays = written(open_scene(parts=(Part(mesh, Surface("wood")),)), tmp_path)
    assert arrays["m0.corners"].tolist() == [0, 1, 2, 3, 3, 2, 4]
    assert arrays["m0.starts"].tolist() == [0, 4]
    # Without coordinates of its own a level face takes x and y.
    assert arrays["m0.uv"].tolist() == corners[[0, 1, 2, 3, 3, 2, 4], :2].tolist()


def test_a_wall_takes_its_coordinates_along_itself(tmp_path: Path) -> None:
    corners = np.array([[0.0, 3, 0], [2, 3, 0], [2, 3, 1], [0, 3, 1]])
    part = Part(Mesh(corners, np.array([[0, 1, 2, 3]])), Surface("brick"))
    _, arrays = written(open_scene(parts=(part,)), tmp_path)
    assert arrays["m0.uv"].tolist() == corners[:, [0, 2]].tolist()


def test_a_picture_fills_its_frame(tmp_path: Path) -> None:
    uv = np.array([[[2.0, 5.0], [3.0, 5.0], [3.0, 5.5], [2.0, 5.5]]])
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0.5], [0, 0, 0.5]])
    part = Part(Mesh(corners, np.array([[0, 1, 2, 3]]), uv), Surface("picture"))
    _, arrays = written(open_scene(parts=(part,)), tmp_path)
    assert arrays["m0.uv"].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]


def test_everything_but_arrays_is_in_the_json(tmp_path: Path) -> None:
    job, _ = written(box_scene(cameras=2), tmp_path)
    assert job["groups"] == ["lamp", "sky", "sun"]
    lamp = job["meshes"][-1]["material"]  # type: ignore[index]
    assert lamp["radiance"] == list(LAMP)
    assert lamp["group"] == "lamp"
    assert job["sun"] == {"direction": [0.0, 0.8, 0.6], "irradiance": [60.0, 55.0, 40.0], "angle": 0.03}
    assert len(job["cameras"]) == 2  # type: ignore[arg-type]
    assert job["render"]["clamp"] == 0.0  # type: ignore[index]


def test_the_sky_is_in_blenders_frame(tmp_path: Path) -> None:
    sky = torch.zeros(8, 16, 3)
    sky[3, 8] = 1.0  # just right of the centre, which is Blender's +Y
    written(open_scene(sky=sky), tmp_path)
    pixels, _ = exr.read(tmp_path / "sky.exr")
    assert np.argwhere(pixels[..., 0] > 0).tolist() == [[3, 4]]  # Blender's centre is +X


def test_empty_parts_are_left_out(tmp_path: Path) -> None:
    nothing = Part(Mesh(np.zeros((0, 3)), np.zeros((0, 4), int)), Emission("lamp", LAMP))
    job, _ = written(open_scene(parts=(nothing,)), tmp_path)
    assert job["meshes"] == []


def raw(path: Path, **planes: np.ndarray) -> Path:
    names = {name.replace("_", "."): plane.astype(np.float32) for name, plane in planes.items()}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, names).write(str(path))
    return path


def test_raw_pictures_are_read(tmp_path: Path) -> None:
    plane = np.full((2, 4), -0.01)
    plane[0] = 2.0
    depth = np.full((2, 4), 3.0)
    depth[1, 1] = 1e10
    path = raw(tmp_path / "a.exr", sky_R=plane, sky_G=plane, sky_B=plane, depth_V=depth)
    groups, metres = read_raw(path, ["sky"])
    assert groups["sky"].min() == 0.0
    assert groups["sky"].max() == 2.0
    assert metres[1, 1] == np.inf
    assert metres[0, 0] == 3.0


def test_denoised_pictures_get_their_light_back(tmp_path: Path) -> None:
    """Rows count by the solid angle that they span, channels by themselves, one stray path a little."""
    rows = np.array([0.5, 1.0, 1.0, 0.5])[:, None].repeat(8, 1)
    noisy = rows * np.array([1.2, 0.9, 1.1, 1.0])[:, None]
    planes = {f"noisy-sky_{c}": noisy for c in "RG"} | {f"sky_{c}": rows for c in "RGB"}
    stray = rows.copy()
    stray[1, 1] = 1e4
    groups, _ = read_raw(
        raw(tmp_path / "a.exr", **planes, **{"noisy-sky_B": stray, "depth_V": rows}), ["sky"]
    )
    weights = np.sin((np.arange(4) + 0.5) * np.pi / 4)[:, None]
    for channel in (0, 1):
        light = (groups["sky"][..., channel] * weights).sum()
        assert light == pytest.approx((noisy * weights).sum(), rel=1e-5)
    np.testing.assert_allclose(groups["sky"][..., 2], 1.25 * rows)


def test_raw_pictures_that_are_none(tmp_path: Path) -> None:
    plane = np.ones((2, 4))
    path = raw(tmp_path / "a.exr", sky_R=plane, sky_G=plane, sky_B=plane)
    with pytest.raises(ValueError, match="none of sun"):
        read_raw(path, ["sky", "sun"])
    with pytest.raises(ValueError, match="none of depth"):
        read_raw(path, ["sky"])
    bad = np.full((2, 4), np.nan)
    path = raw(tmp_path / "b.exr", sky_R=plane, sky_G=bad, sky_B=plane, depth_V=plane)
    with pytest.raises(ValueError, match=r"b\.exr: expected finite light in sky"):
        read_raw(path, ["sky"])
    (tmp_path / "c.exr").write_bytes(b"")
    with pytest.raises(ValueError, match="expected Blender's panorama"):
        read_raw(tmp_path / "c.exr", ["sky"])


@pytest.mark.parametrize(("width", "samples"), [(15, 1), (18, 1), (0, 1), (64, 0)])
def test_settings_that_cannot_be(width: int, samples: int) -> None:
    with pytest.raises(ValueError, match="expected"):
        Settings(width=width, samples=samples)


def test_two_writings_are_alike(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_job(build(plain_plan(), sky_height=16), SMALL, tmp_path / name)
    for file in ("scene.json", "arrays.npz", "sky.exr"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
