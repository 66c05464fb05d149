"""Rooms in Blender itself: frames, units, light groups, remixes and materials."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.blender import program
from mixlight.blender.session import Session
from mixlight.data.panoramas import read_table
from mixlight.data.rooms import shapes
from mixlight.data.rooms.job import Settings, read_raw, write_job
from mixlight.data.rooms.mesh import Emission, Part
from mixlight.data.rooms.plan import SURFACES, Camera, Surface
from mixlight.data.rooms.remix import mix
from mixlight.data.rooms.render import SCRIPT, Rooms, render_rooms
from mixlight.data.rooms.scene import Placement, RoomScene, Sun
from mixlight.data.rooms.store import direction_from, read_room
from mixlight.sphere import calibration, equirect
from tests.data.rooms.boxes import LAMP, box_scene, open_scene, patch
from tests.interop.blenders import VERSIONS, blender_python

pytestmark = pytest.mark.interop

Groups = dict[str, np.ndarray]


class Studio:
    """A Blender that renders small scenes."""

    def __init__(self, version: str, folder: Path) -> None:
        self.python = blender_python(version)
        self.session = Session(SCRIPT, ["2"], blender=self.python)
        self.folder = folder
        self.count = 0

    def ask(self, scene: RoomScene, **settings: Any) -> tuple[Path, dict[str, Any]]:
        self.count += 1
        job = self.folder / f"job {self.count}"
        job.mkdir()
        write_job(scene, Settings(**{"width": 64, "samples": 16, "denoise": False} | settings), job)
        return job, self.session.ask(job, 600)

    def views(self, scene: RoomScene, **settings: Any) -> list[tuple[Groups, np.ndarray]]:
        job, answer = self.ask(scene, **settings)
        assert answer["ok"], answer
        names = scene.groups or ("whole",)
        return [read_raw(job / f"camera-{k}.exr", names) for k in range(len(scene.cameras))]

    def view(self, scene: RoomScene, **settings: Any) -> tuple[Groups, np.ndarray]:
        return self.views(scene, **settings)[0]


@pytest.fixture(scope="module", params=VERSIONS)
def studio(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    made = Studio(request.param, tmp_path_factory.mktemp("studio"))
    with made.session:
        yield made


def below() -> tuple[Camera, ...]:
    return (Camera(0, (0.0, 0.0, 1.0), 0.0),)


def irradiance(panorama: np.ndarray) -> np.ndarray:
    """On 50 planes that face all around; a diffuse sphere shows it."""
    height = panorama.shape[0]
    directions = equirect.pixel_directions(height).numpy().reshape(-1, 3)
    light = (panorama * equirect.solid_angle(height).numpy()[..., None]).reshape(-1, 3)
    normals = torch.nn.functional.normalize(
        torch.randn(50, 3, generator=torch.Generator().manual_seed(1)), dim=1
    )
    return np.asarray((normals.numpy() @ directions.T).clip(0) @ light)


def test_the_sky_stands_where_it_should(studio: Studio) -> None:
    card = calibration.calibration_card(64)
    turns = {0.0: "-Z", math.pi / 2: "-X", math.pi: "+Z", -math.pi / 2: "+X"}
    scene = open_scene(sky=card, cameras=tuple(Camera(0, (0.0, 0.0, 0.0), turn) for turn in turns))
    views = studio.views(scene, width=128)
    for (groups, depth), axis in zip(views, turns.values(), strict=True):
        colour = calibration.CARD_RADIANCE * np.array(calibration.CARD_COLOURS[axis])
        # The filter of a pixel reaches half a pixel into its neighbours, and a letter is near.
        np.testing.assert_allclose(groups["sky"][31:33, 63:65].mean((0, 1)), colour, atol=0.2)
        assert np.isinf(depth).all()
    # All of it, unmirrored and the right way up, but for the filter of pixels at the edges of letters.
    wrong, right = (np.abs(views[0][0]["sky"] - other.numpy()).mean() for other in (card.flip(1), card))
    assert right < 0.1 < 0.2 < wrong


def test_what_a_grey_floor_reflects(studio: Studio) -> None:
    grey = Surface("translucent", (0.5, 0.5, 0.5))  # nothing passes: diffuse and nothing else
    sun = Sun((0.0, 0.8, 0.6), (60.0, 30.0, 15.0), 0.01)
    scene = open_scene(
        parts=(Part(patch(0.0, 50.0), grey),), sun=sun, groups=("sky", "sun"), cameras=below(),
        sky=torch.full((16, 32, 3), 3.0),
    )  # fmt: skip
    groups, depth = studio.view(scene, samples=64)
    np.testing.assert_allclose(groups["sky"][26:].mean((0, 1)), 1.5, rtol=0.01)  # L albedo
    expected = 0.5 * 0.6 * np.array(sun.irradiance) / math.pi
    np.testing.assert_allclose(groups["sun"][26:].mean((0, 1)), expected, rtol=0.01)
    assert depth[-1].mean() == pytest.approx(1.0, rel=0.01)


def test_the_sun_itself_is_seen(studio: Studio) -> None:
    direction = (0.48, 0.64, 0.6)
    scene = open_scene(sun=Sun(direction, (10.0, 5.0, 2.0), 0.2), groups=("sky", "sun"), cameras=below())
    sun = studio.view(scene, samples=64)[0]["sun"]
    light = sun * equirect.solid_angle(32).numpy()[..., None]
    np.testing.assert_allclose(light.sum((0, 1)), (10.0, 5.0, 2.0), rtol=0.04)
    seen = (light[..., :1] * equirect.pixel_directions(32).numpy()).sum((0, 1))
    assert seen / np.linalg.norm(seen) == pytest.approx((0.48, 0.6, -0.64), abs=0.02)


def test_a_lamp_where_the_json_says(studio: Studio) -> None:
    place, camera = (1.0, -2.0, 1.4), Camera(0, (0.3, 0.2, 1.0), 0.7)
    low, high = np.array(place) - 0.15, np.array(place) + 0.15
    lamp = Part(shapes.box(tuple(low), tuple(high)), Emission("lamp", LAMP, True))
    groups, depth = studio.view(
        open_scene(parts=(lamp,), groups=("lamp", "sky"), cameras=(camera,)), width=128
    )
    picture = groups["lamp"]
    assert picture.max((0, 1)) == pytest.approx(LAMP, rel=1e-3)
    light = picture[..., :1] * equirect.solid_angle(64).numpy()[..., None]
    seen = (light * equirect.pixel_directions(64).numpy()).sum((0, 1))
    direction, distance = direction_from(camera, place)
    assert seen / np.linalg.norm(seen) == pytest.approx(direction, abs=0.02)
    assert depth[picture[..., 0] > 0.9 * LAMP[0]].mean() == pytest.approx(distance, abs=0.16)


def test_a_lamp_shines_at_its_front_and_reflects_when_off(studio: Studio) -> None:
    def floor(up: bool, radiance: float, reflectance: float) -> Groups:
        material = Emission("lamp", (radiance,) * 3, False, (reflectance,) * 3)
        scene = open_scene(parts=(Part(patch(0.0, 50.0, up=up), material),), groups=("lamp", "sky"))
        return studio.view(replace(scene, cameras=below(), sky=torch.full((16, 32, 3), 2.0)), samples=64)[0]

    on = floor(True, 5.0, 0.25)
    assert on["lamp"][-6:].mean() == pytest.approx(5.0, rel=0.01)
    assert on["sky"][-6:].mean() == pytest.approx(0.5, rel=0.02)
    assert floor(False, 5.0, 0.0)["lamp"].max() == 0.0
    assert floor(True, 0.0, 0.5)["lamp"].max() == 0.0


def test_the_groups_add_up_to_a_direct_render(studio: Studio) -> None:
    scene = box_scene(cameras=2)
    apart, whole = studio.views(scene), studio.views(replace(scene, groups=()))
    for (groups, depth), (direct, same) in zip(apart, whole, strict=True):
        assert all(groups[name].mean() > 0.01 for name in scene.groups)
        np.testing.assert_allclose(sum(groups.values()), direct["whole"], rtol=1e-4, atol=1e-5)
        np.testing.assert_array_equal(depth, same)


def test_a_remix_is_a_direct_render_with_the_lamps_changed(studio: Studio) -> None:
    """Also with light of 2,000 times white, which any clamp would cut."""
    scene = box_scene()
    groups = {name: torch.from_numpy(p) for name, p in studio.view(scene, width=64, samples=256)[0].items()}
    gains = {"lamp": (100.0, 60.0, 30.0), "sky": (0.1, 0.2, 0.4)}
    remixed = mix(groups, gains).numpy()
    changed = []
    for part in scene.parts:
        if isinstance(part.material, Emission):
            radiance = tuple(c * g for c, g in zip(LAMP, gains["lamp"], strict=True))
            part = replace(part, material=replace(part.material, radiance=radiance))
        changed.append(part)
    sky = scene.sky * torch.tensor(gains["sky"])
    direct = replace(scene, parts=tuple(changed), sky=sky, sun=None, groups=())
    picture = studio.view(direct, width=64, samples=256)[0]["whole"]
    expected = irradiance(picture)
    error = np.sqrt(((irradiance(remixed) - expected) ** 2).mean(0)) / expected.mean(0)
    assert error.max() < 0.01


def test_the_same_job_gives_the_same_picture_in_another_process(studio: Studio, tmp_path: Path) -> None:
    scene = box_scene()
    first = studio.view(scene, samples=4, denoise=True)
    with Session(SCRIPT, ["1"], blender=studio.python) as session:
        write_job(scene, Settings(width=64, samples=4), tmp_path)
        assert session.ask(tmp_path, 600)["ok"]
    second = read_raw(tmp_path / "camera-0.exr", scene.groups)
    np.testing.assert_array_equal(first[1], second[1])
    for name in scene.groups:
        np.testing.assert_allclose(first[0][name], second[0][name], rtol=1e-3, atol=1e-4)


def test_denoising_keeps_the_light_of_every_group(studio: Studio) -> None:
    scene = box_scene()
    noisy, clean = (studio.view(scene, width=128, denoise=d)[0] for d in (False, True))
    for name in scene.groups:
        before, after = irradiance(noisy[name]), irradiance(clean[name])
        assert np.sqrt(((after - before) ** 2).mean()) < 0.02 * before.mean(), name
        wall = (slice(28, 36), slice(100, 112))  # of one plain wall
        before, after = (np.diff(picture[name][wall], axis=1).std() for picture in (noisy, clean))
        assert after < 0.4 * before, name


def test_every_kind_of_surface(studio: Studio) -> None:
    """Each in a panel of its own below an even sky: none is black, brighter than the sky, or pink."""
    parts, columns = [], 8
    for index, kind in enumerate(SURFACES):
        x, y = 1.0 * (index % columns), 1.0 * (index // columns)
        surface = Surface(kind, (0.3, 0.5, 0.3), bump=1.0, transmission=0.4, seed=index, roughness=0.4)
        parts.append(Part(shapes.box((x, y, 0.0), (x + 0.9, y + 0.9, 0.1)), surface, kind))
    cameras = tuple(
        Camera(0, (i % columns + 0.45, i // columns + 0.45, 0.4), 0.0) for i in range(len(SURFACES))
    )
    scene = open_scene(parts=tuple(parts), cameras=cameras, sky=torch.full((16, 32, 3), 1.0))
    for kind, (groups, _) in zip(SURFACES, studio.views(scene, width=32, samples=4), strict=True):
        red, green, blue = groups["sky"][-3:].mean((0, 1))
        assert 0.02 < green < 1.05, kind
        assert not (red > 1.5 * green and blue > 1.5 * green), kind
        if kind not in ("picture", "glass"):
            assert green > red, kind


def test_a_surface_of_no_kind(studio: Studio) -> None:
    _, answer = studio.ask(open_scene(parts=(Part(patch(0.0), Surface("cheese")),)))
    assert not answer["ok"]
    assert "received 'cheese'" in answer["error"]


def test_how_much_a_curtain_lets_through(studio: Studio) -> None:
    """A sheet below a camera that looks down on it, lit from below only."""
    sky = torch.zeros(32, 64, 3)
    sky[16:] = 1.0

    def through(**surface: float) -> float:
        sheet = Surface("translucent", (1.0, 1.0, 1.0), **surface)
        scene = open_scene(parts=(Part(patch(0.0, 50.0), sheet),), cameras=below(), sky=sky)
        return float(studio.view(scene, samples=64)[0]["sky"][-6:].mean())

    assert through(transmission=0.0) == pytest.approx(0.0, abs=1e-3)
    assert through(transmission=0.4, roughness=1.0) == pytest.approx(0.4, abs=0.02)
    assert through(transmission=0.8, roughness=0.2) == pytest.approx(0.8, abs=0.02)


def test_objects_of_the_library(studio: Studio, tmp_path: Path) -> None:
    blend = tmp_path / "library.blend"
    program.run(
        Path(__file__).with_name("blender_library_stage.py"), [blend], timeout=300, blender=studio.python
    )  # fmt: skip
    matrices = [shapes.placement((x, 2.0, 1.0), 0.0) for x in (-1.0, 1.0)]
    scene = open_scene(
        library=blend,
        placements=(
            Placement("stool", matrices[0], (Surface("paint", (0.6, 0.05, 0.05)),)),
            Placement("stool", matrices[1]),
        ),
        cameras=(Camera(0, (0.0, 0.0, 1.25), 0.0),),
        sky=torch.full((16, 32, 3), 1.0),
    )
    groups, depth = studio.view(scene, width=128)
    left, right = (int(64 + s * math.atan2(1.0, 2.0) / (2 * math.pi) * 128) for s in (-1, 1))
    assert depth[32, left] == pytest.approx(math.hypot(1.0, 1.8), abs=0.15)
    red, grey = groups["sky"][30:34, left].mean(0), groups["sky"][30:34, right].mean(0)
    assert red[0] > 3 * red[1]
    assert grey[0] == pytest.approx(grey[2], rel=0.05)
    missing = replace(scene, placements=(Placement("throne", matrices[0]),))
    _, answer = studio.ask(missing)
    assert "expected the objects throne" in answer["error"]


def test_a_set_of_rooms(studio: Studio, tmp_path: Path) -> None:
    """The same seed gives the same room, whatever else is in the set."""
    rooms = Rooms(Settings(width=32, samples=1), cameras=1)
    for name, seeds in (("a", [3]), ("b", [4, 3])):
        outcomes = render_rooms(seeds, tmp_path / name, rooms, blender=studio.python)
        assert [o.error for o in outcomes] == [None] * len(seeds)
    assert len(read_table(tmp_path / "b" / "rooms.csv")) == 2
    first, second = (read_room(tmp_path / name / "room-00003" / "camera-0.exr") for name in "ab")
    assert first.document["plan"] == second.document["plan"]
    assert first.groups.keys() == second.groups.keys()
    for group, pixels in first.groups.items():
        torch.testing.assert_close(pixels, second.groups[group], rtol=2e-2, atol=1e-3)
    assert {light["group"] for light in first.document["lights"]} == set(first.groups)
