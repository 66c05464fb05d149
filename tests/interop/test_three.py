"""three.js in Chromium: the exported files, loaded by its own loaders and by the code that we ship."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from mixlight.export import three
from mixlight.export.rig import Rig, make_rig
from mixlight.image import exr, radiance
from mixlight.light import harmonics
from mixlight.sphere import camera, equirect
from mixlight.sphere.calibration import CARD_COLOURS, CARD_RADIANCE
from mixlight.sphere.points import vogel
from tests.interop import images
from tests.interop.rigs import card_rig, picture_lighting, random_lighting, sphere_normals, uniform_rig
from tests.interop.web import Web

pytestmark = pytest.mark.interop

Pictures = dict[str, NDArray[np.float32]]

VIEWS = {
    "-Z": (0.0, 0.0),
    "+X": (math.pi / 2, 0.0),
    "+Z": (math.pi, 0.0),
    "-X": (-math.pi / 2, 0.0),
    "+Y": (0.0, math.pi / 2),
    "-Y": (0.0, -math.pi / 2),
}
"""Yaw and pitch of the camera that looks at each axis."""

ALBEDO = 0.8
CARD = card_rig(128)
RIGS = {
    "residual": make_rig(random_lighting(1), height=64),
    "full": make_rig(random_lighting(1), height=64, residual=False),
    "two lights": make_rig(random_lighting(2), height=64, lights=2),
    "no lights": make_rig(random_lighting(3), height=64, lights=0),
}


# ------------------------------------------------------------------------------------------------ orientation


@pytest.fixture(scope="module")
def card(web: Web, tmp_path_factory: pytest.TempPathFactory) -> Pictures:
    """The calibration card as background, in a mirror and on a rough metal, and turned by 90°."""
    folder = tmp_path_factory.mktemp("card")
    three.write(CARD, folder)
    script = """
        import { Stage, metal } from '/lib/three_stage.js';
        export default async ({ files, views }) => {
          const stage = new Stage();
          const { setRotation } = await stage.load(files);
          const pictures = {};
          for (const [name, angles] of Object.entries(views)) pictures[name] = stage.view(...angles, 64);
          pictures.mirror = stage.sphere(metal(1, 0), 128);
          pictures.rough = stage.sphere(metal(1, 0.6), 64);
          setRotation(Math.PI / 2);
          pictures.turned = stage.view(0, 0, 64);
          pictures['turned mirror'] = stage.sphere(metal(1, 0), 128);
          const other = new Stage(stage.renderer);
          await other.load(files, { map: false, background: true });
          pictures['background alone'] = other.view(0, 0, 64);
          pictures['unlit mirror'] = other.sphere(metal(1, 0), 16);
          return pictures;
        };
    """
    pictures: Pictures = web.run(script, files=folder, views=VIEWS)
    return pictures


@pytest.mark.parametrize("axis", VIEWS)
def test_the_background_shows_each_axis_where_it_is(card: Pictures, axis: str) -> None:
    yaw, pitch = VIEWS[axis]
    expected = camera.view(CARD.environment, 64, 64, math.pi / 2, yaw=yaw, pitch=pitch).numpy()
    patch = [CARD_RADIANCE * part for part in CARD_COLOURS[axis]]
    assert card[axis][31:33, 31:33].mean((0, 1)) == pytest.approx(patch, abs=0.02)
    # The same picture with its letters and lines, up to the sampling along their edges.
    assert np.abs(card[axis] - expected).mean() < 0.06
    assert np.corrcoef(card[axis].ravel(), expected.ravel())[0, 1] > 0.98


def reflected(normals: Tensor) -> Tensor:
    """Where a mirror of these normals sends the look of a viewer who looks along -Z."""
    return 2 * normals * normals[..., 2:] - torch.tensor([0.0, 0.0, 1.0], dtype=normals.dtype)


def turned_back(directions: Tensor) -> Tensor:
    """Turned by 90° clockwise seen from above: where what three shows after setRotation(90°) came from."""
    x, y, z = directions.unbind(-1)
    return torch.stack([-z, y, x], -1)


def test_the_turned_background_shows_at_the_centre_what_was_at_the_right(card: Pictures) -> None:
    assert np.abs(card["turned"] - card["+X"]).mean() < 0.01


def test_a_background_alone_does_not_light(card: Pictures) -> None:
    """Then the probe does, and a mirror has nothing to reflect."""
    assert np.abs(card["background alone"] - card["-Z"]).max() < 0.01
    assert float(card["unlit mirror"].max()) == 0.0


@pytest.mark.parametrize("turned", [False, True])
def test_a_mirror_reflects_each_axis_where_it_is(card: Pictures, turned: bool) -> None:
    normals, inside = sphere_normals(128)
    directions = reflected(normals)
    directions = turned_back(directions) if turned else directions
    expected = equirect.sample(CARD.environment, directions.float())
    picture = torch.from_numpy(card["turned mirror" if turned else "mirror"])
    assert float((picture - expected).abs()[inside].mean()) < 0.2
    # In the middle the mirror shows what is behind the viewer, at 45 degrees what is at the sides.
    for row, column in ((64, 64), (64, 109), (64, 18), (18, 64), (109, 64)):
        torch.testing.assert_close(picture[row, column], expected[row, column], atol=0.3, rtol=0)


def test_a_rough_metal_is_lit_from_where_the_light_is(card: Pictures) -> None:
    """Half-way between mirror and chalk: the middle is lit from behind the viewer, blue, the right is red."""
    rough = card["rough"]
    middle, right, left = rough[32, 32], rough[32, 54], rough[32, 9]
    top, bottom = rough[9, 32], rough[54, 32]
    assert middle[2] > 1.5 * middle[:2].max()
    assert right[0] > 1.5 * left[0]
    assert top[1] > 1.5 * bottom[1]
    assert left[1] > right[1]
    assert left[2] > right[2]


# ------------------------------------------------------------------------------ numbers of all the light


def expected_matte(rig: Rig, normals: Tensor, *, by_map: bool = False) -> Tensor:
    """Radiance of Lambert's law under what a rig writes switched on: the map or the probe, and the lights."""
    held = harmonics.project(rig.environment, degree=6) if by_map else rig.ambient
    irradiance = harmonics.irradiance(held.double(), normals)
    for light in rig.lights if rig.lights_on else ():
        cosine = (normals @ light.direction.double()).clamp_min(0)
        irradiance = irradiance + cosine[..., None] * light.irradiance.double()
    return ALBEDO * irradiance / math.pi


NORMALS = vogel(64, dtype=torch.float64)


@pytest.fixture(scope="module")
def rendered(web: Web, tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """Matte spheres under probe and lights, and under map and lights; what ObjectLoader made of the JSON."""
    folder = tmp_path_factory.mktemp("rigs")
    for name, rig in RIGS.items():
        (folder / name).mkdir()
        three.write(rig, folder / name)
    script = """
        import * as THREE from 'three';
        import { Stage, matte, matteStandard } from '/lib/three_stage.js';
        import { pack } from 'harness';

        const describe = (child) => ({
          name: child.name, type: child.type, visible: child.visible, about: child.userData,
          sh: child.sh?.toArray(),
          irradiance: child.color?.clone().multiplyScalar(child.intensity).toArray(),
          towards: child.target && child.getWorldPosition(new THREE.Vector3())
            .sub(child.target.getWorldPosition(new THREE.Vector3())).normalize().toArray(),
        });

        export default async ({ files, names, albedo, normals }) => {
          const all = {};
          const { renderer } = new Stage();
          for (const name of names) {
            const found = all[name] = {};
            for (const map of [true, false]) {
              const stage = new Stage(renderer);
              const { lights } = await stage.load(`${files}${name}/`, { map, background: false });
              const material = map ? matteStandard(albedo) : matte(albedo);
              const by = map ? 'map' : 'probe';
              found[by] = stage.sphere(material, 64);
              found[`${by} from behind`] = stage.sphere(material, 64, { behind: true });
              if (map) continue;
              found.group = { name: lights.name, type: lights.type, about: lights.userData };
              found.children = lights.children.map(describe);
              const { sh } = lights.getObjectByName('ambient');
              const at = (n) => sh.getIrradianceAt(new THREE.Vector3(...n), new THREE.Vector3()).toArray();
              found.irradiance = pack(new Float64Array(normals.flatMap(at)), [normals.length, 3]);
            }
          }
          return all;
        };
    """
    arguments = {"names": list(RIGS), "albedo": ALBEDO, "normals": NORMALS.tolist()}
    found: dict[str, dict[str, Any]] = web.run(script, files=folder, **arguments)
    return found


@pytest.fixture(params=RIGS)
def lit(request: pytest.FixtureRequest, rendered: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """One of them, with its rig."""
    return rendered[request.param] | {"rig": RIGS[request.param]}


def test_the_probes_irradiance_is_ours(lit: dict[str, Any]) -> None:
    """Of SphericalHarmonics3.getIrradianceAt, whose constants have six digits."""
    expected = harmonics.irradiance(lit["rig"].ambient.double(), NORMALS)
    torch.testing.assert_close(torch.from_numpy(lit["irradiance"]), expected, rtol=1e-5, atol=1e-5)


def test_object_loader_finds_the_lights(lit: dict[str, Any]) -> None:
    rig, (probe, *lights) = lit["rig"], lit["children"]
    assert lit["group"]["type"] == "Group"
    assert lit["group"]["about"]["map"] == rig.map_kind
    assert (probe["type"], probe["name"], probe["visible"]) == ("LightProbe", "ambient", True)
    assert probe["about"]["order"] == "l*l+l+m"
    assert probe["sh"] == pytest.approx(rig.ambient.flatten().tolist(), rel=1e-6)
    assert [light["name"] for light in lights] == [light.name for light in rig.lights]
    for light, expected in zip(lights, rig.lights, strict=True):
        assert light["type"] == "DirectionalLight"
        assert light["visible"] is rig.lights_on
        assert light["towards"] == pytest.approx(expected.direction.tolist(), abs=1e-6)
        brightest = float(expected.irradiance.max())
        assert light["irradiance"] == pytest.approx(expected.irradiance.tolist(), abs=0.0045 * brightest)
        assert max(light["irradiance"]) == pytest.approx(brightest, rel=1e-6)


@pytest.mark.parametrize("behind", [False, True])
def test_probe_and_lights_light_a_matte_sphere_as_we_say(lit: dict[str, Any], behind: bool) -> None:
    normals, inside = sphere_normals(64, behind=behind)
    expected = expected_matte(lit["rig"], normals)[inside]
    picture = torch.from_numpy(lit["probe from behind" if behind else "probe"]).double()[inside]
    difference = (picture - expected).abs() / expected.mean()
    assert float(difference.mean()) < 0.001  # colours of 8 bits, and the sphere's tessellation
    assert float(difference.max()) < 0.005


@pytest.mark.parametrize("behind", [False, True])
def test_map_and_lights_light_a_matte_sphere_as_we_say(lit: dict[str, Any], behind: bool) -> None:
    """three's blurred maps stand in for the cosine, so this is not exact; twice the light would show."""
    normals, inside = sphere_normals(64, behind=behind)
    expected = expected_matte(lit["rig"], normals, by_map=True)[inside]
    picture = torch.from_numpy(lit["map from behind" if behind else "map"]).double()[inside]
    difference = (picture - expected).abs() / expected.mean()
    assert float(difference.mean()) < 0.01
    assert float(difference.max()) < 0.04
    torch.testing.assert_close(picture.mean(0), expected.mean(0), rtol=0.005, atol=0)


def test_white_in_a_white_room_cannot_be_seen(web: Web, tmp_path: Path) -> None:
    """The environment's intensity: radiance 1 all around gives radiance 1, or the albedo, back."""
    three.write(uniform_rig(), tmp_path)
    script = """
        import { Stage, matteStandard, metal } from '/lib/three_stage.js';
        export default async ({ files }) => {
          const stage = new Stage();
          await stage.load(files);
          return {
            background: stage.view(0.3, 0.2, 16),
            matte: stage.sphere(matteStandard(0.8), 32),
            mirror: stage.sphere(metal(1, 0), 32),
            rough: stage.sphere(metal(1, 0.5), 32),
          };
        };
    """
    pictures: Pictures = web.run(script, files=tmp_path)
    _, inside = sphere_normals(32)
    assert pictures["background"] == pytest.approx(np.ones((16, 16, 3)), abs=1e-3)
    assert pictures["matte"][inside.numpy()] == pytest.approx(0.8, abs=2e-3)
    assert pictures["mirror"][inside.numpy()] == pytest.approx(1.0, abs=0.01)
    assert pictures["rough"][inside.numpy()] == pytest.approx(1.0, abs=0.02)


# ---------------------------------------------------------------------------------------------------- files


def test_its_loaders_read_our_pixels(web: Web, tmp_path: Path) -> None:
    rig = replace(make_rig(random_lighting(4), residual=False, height=64), exposure_gain=0.5)
    bright = rig.environment.clone()
    bright[10, 20] = torch.tensor([60000.0, 1e-4, 3.0])
    three.write(replace(rig, environment=bright), tmp_path)
    script = """
        import * as THREE from 'three';
        import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
        import { HDRLoader } from 'three/addons/loaders/HDRLoader.js';
        import { pack } from 'harness';
        export default async ({ files }) => {
          const found = {};
          for (const [name, Loader] of [['exr', EXRLoader], ['hdr', HDRLoader]]) {
            const loader = new Loader().setDataType(THREE.FloatType);
            const { image, flipY, colorSpace } = await loader.loadAsync(`${files}environment.${name}`);
            found[name] = { pixels: pack(image.data, [image.height, image.width, 4]), flipY, colorSpace };
          }
          return found;
        };
    """
    found = web.run(script, files=tmp_path)
    for name, read in (("exr", exr.read), ("hdr", radiance.read)):
        ours, _ = read(tmp_path / f"environment.{name}")
        pixels = found[name]["pixels"][..., :3]
        theirs = pixels if found[name]["flipY"] else pixels[::-1]  # OpenGL's first row is the lowest
        assert found[name]["colorSpace"] == "srgb-linear"
        # Radiance defines a mantissa as 256ths of its exponent's step; three's HDRLoader divides by 255.
        factor = {"exr": 1.0, "hdr": 256 / 255}[name]
        np.testing.assert_allclose(theirs, ours * factor, rtol=1e-6)


def test_the_page_that_ships_shows_the_room(web: Web, tmp_path: Path) -> None:
    rig = make_rig(picture_lighting())
    assert rig.lights_on
    three.write(rig, tmp_path)
    pixels, requests = web.show(tmp_path, ready="document.body.dataset.ready", width=720, height=405)
    assert all(url.startswith(web.origin) for url in requests)
    assert {Path(url).name for url in requests} >= {"environment.exr", "lights.json", "light.js"}
    images.hold("three", pixels)
