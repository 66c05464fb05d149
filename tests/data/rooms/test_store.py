"""Rooms on disk come back as they were, and say what they are."""

import json
import math
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.data.panoramas import load_panorama
from mixlight.data.rooms.plan import Camera
from mixlight.data.rooms.store import (
    SKY,
    SUN,
    direction_from,
    document_of,
    group_names,
    is_room,
    read_document,
    read_room,
    room_document,
    write_camera,
    write_document,
)
from mixlight.image import exr
from mixlight.image.errors import ImageFileError
from mixlight.sphere import equirect
from tests.data.rooms.lit import lit_plan, pictures, write_room

LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])


def test_groups_and_depth_come_back(tmp_path: Path) -> None:
    plan = lit_plan()
    files = write_room(tmp_path, plan)
    room = read_room(files[1])
    assert list(room.groups) == ["ceiling", "floor_lamp_1", "table_lamp_1", SKY, SUN] == group_names(plan)
    for name, pixels in pictures(plan, seed=1).items():
        # Half floats: 11 bits.
        torch.testing.assert_close(room.groups[name], torch.from_numpy(pixels), rtol=2**-11, atol=1e-6)
    assert room.camera == 1
    assert room.plan == plan
    assert bool((room.depth[0] == math.inf).all())
    assert bool((room.depth[1:] == 2.5).all())


def test_the_first_part_is_the_plan_s_light_at_a_mean_luminance_of_one(tmp_path: Path) -> None:
    plan = lit_plan()
    path = write_room(tmp_path, plan)[0]
    panorama = load_panorama(path)
    mean = float(equirect.integrate(panorama) @ LUMINANCE) / (4 * math.pi)
    assert mean == pytest.approx(1.0, abs=1e-3)
    light = pictures(plan)
    total = torch.from_numpy(sum(light[name] for name in light if name != "table_lamp_1"))
    scale = float(equirect.integrate(total) @ LUMINANCE) / (4 * math.pi)
    torch.testing.assert_close(panorama * scale, total, rtol=1e-3, atol=1e-5)
    _, header = exr.read(path)
    assert header["whiteLuminance"] == pytest.approx(683 * scale, rel=1e-5)
    assert header["envmap"] == "latlong"


def test_another_program_reads_the_parts(tmp_path: Path) -> None:
    path = write_room(tmp_path, lit_plan())[0]
    names = []
    index = 0
    picture = oiio.ImageInput.open(str(path))
    while picture.seek_subimage(index, 0):
        names.append(picture.spec().getattribute("oiio:subimagename"))
        index += 1
    assert names == ["panorama", "ceiling", "floor_lamp_1", "table_lamp_1", "sky", "sun", "depth"]
    picture.seek_subimage(1, 0)
    ours = read_room(path).groups["ceiling"].numpy()
    unit = picture.spec().getattribute("whiteLuminance") / 683
    np.testing.assert_allclose(np.asarray(picture.read_image(1, 0, 0, 3, "float")) * unit, ours, rtol=1e-6)
    picture.close()


def test_lossy_storage_stays_near(tmp_path: Path) -> None:
    plan = lit_plan()
    lossy = read_room(write_room(tmp_path / "a", plan, codec="dwab", height=64)[0])
    exact = read_room(write_room(tmp_path / "b", plan, codec="zip", height=64)[0])
    for name, pixels in exact.groups.items():
        assert bool((lossy.groups[name] >= 0).all())
        before, after = equirect.integrate(pixels), equirect.integrate(lossy.groups[name])
        torch.testing.assert_close(after, before, rtol=0.02, atol=0)
        assert not torch.equal(lossy.groups[name], pixels)


def test_a_room_without_light_is_stored(tmp_path: Path) -> None:
    dark = {"sky": np.zeros((4, 8, 3), np.float32)}
    write_camera(tmp_path / "a.exr", dark, np.ones((4, 8), np.float32), document="room.json", camera=0)
    write_document(tmp_path / "room.json", room_document(lit_plan(cameras=()), []))
    assert float(read_room(tmp_path / "a.exr").groups["sky"].abs().max()) == 0.0


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({}, "expected groups"),
        ({"depth": np.ones((4, 8, 3))}, "other names than"),
        ({"a": np.ones((4, 6, 3))}, "2:1"),
        ({"a": np.ones((8, 16, 3))}, "shape"),
        ({"a": np.full((4, 8, 3), np.nan)}, "finite radiance"),
        ({"a": np.full((4, 8, 3), -1.0)}, "from 0 on"),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_what_is_no_light_is_refused(tmp_path: Path, groups: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        write_camera(tmp_path / "a.exr", groups, np.ones((4, 8), np.float32), document="a", camera=0)
    assert not list(tmp_path.iterdir())


def test_another_codec_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="dwab, zip"):
        write_camera(
            tmp_path / "a.exr",
            {"a": np.ones((4, 8, 3))},
            np.ones((4, 8)),
            document="a",
            camera=0,
            codec="b44",
        )


def test_a_plain_panorama_is_no_room(tmp_path: Path) -> None:
    exr.write(tmp_path / "plain.exr", np.ones((4, 8, 3), np.float32))
    assert not is_room(tmp_path / "plain.exr")
    for read in (read_room, document_of):
        with pytest.raises(ImageFileError, match="light groups"):
            read(tmp_path / "plain.exr")


def test_a_truncated_room_is_refused(tmp_path: Path) -> None:
    path = write_room(tmp_path, lit_plan())[0]
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ImageFileError):
        read_room(path)


def test_light_that_half_floats_could_not_hold_is_refused(tmp_path: Path) -> None:
    path = write_room(tmp_path, lit_plan())[0]
    file = OpenEXR.File(str(path))
    file.parts[2].channels["RGB"].pixels[3, 4, 0] = np.inf
    file.write(str(tmp_path / "camera-9.exr"))
    with pytest.raises(ImageFileError, match="finite light in floor_lamp_1"):
        read_room(tmp_path / "camera-9.exr")


def test_the_document_belongs_to_the_file(tmp_path: Path) -> None:
    path = write_room(tmp_path, lit_plan())[0]
    assert document_of(path) == tmp_path / "room.json"
    (tmp_path / "room.json").unlink()
    with pytest.raises(FileNotFoundError):
        read_room(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [("{", "JSON"), ("[]", "mixlight-room"), ('{"format": "mixlight-room", "version": 99}', "version 1")],
)
def test_a_document_of_another_kind_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "room.json").write_text(text)
    with pytest.raises(ImageFileError, match=message):
        read_document(tmp_path / "room.json")


def test_the_document_tells_of_every_light() -> None:
    plan = lit_plan()
    document = room_document(plan, ["a.exr", "b.exr"], render={"samples": 16}, seconds={"render": 3.0})
    json.dumps(document, allow_nan=False)
    lights = {light["group"]: light for light in document["lights"]}
    assert list(lights) == group_names(plan)
    assert [lights[name]["on"] for name in lights] == [True, True, False, True, True]
    lamp = lights["floor_lamp_1"]["fixtures"][0]
    assert (lamp["power_lm"], lamp["temperature_k"], lamp["position"]) == (800.0, 2700.0, [3.5, 4.5, 1.4])
    assert lamp["from_cameras"][0]["distance_m"] == pytest.approx(math.dist((3.5, 4.5, 1.4), (2, 2, 1.5)))
    assert lights[SUN]["illuminance_lx"] == 60000.0
    # The first camera is not turned: the sun stands before it, at sin h = .6.
    assert lights[SUN]["from_cameras"][0]["direction"] == pytest.approx([0.0, 0.6, -0.8])
    assert document["render"] == {"samples": 16}
    assert document["seconds"] == {"render": 3.0}
    with pytest.raises(ValueError, match="2 files"):
        room_document(plan, ["a.exr"])


@given(
    turn=st.floats(-math.pi, math.pi),
    point=st.tuples(*[st.floats(-5, 5)] * 3).filter(lambda p: math.hypot(*p) > 0.1),
)
def test_directions_from_a_camera(turn: float, point: tuple[float, float, float]) -> None:
    """Blender's own rotation (90 degrees about X, then `turn` about Z) as reference."""
    camera = Camera(0, (0.0, 0.0, 0.0), turn)
    direction, distance = direction_from(camera, point)
    c, s = math.cos(turn), math.sin(turn)
    tilt = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    to_world = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ tilt
    np.testing.assert_allclose(to_world @ np.array(direction) * distance, point, atol=1e-9)


def test_a_camera_does_not_see_its_own_place() -> None:
    with pytest.raises(ValueError, match="own place"):
        direction_from(Camera(0, (1.0, 1.0, 1.0), 0.0), (1.0, 1.0, 1.0))
