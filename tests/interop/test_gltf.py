"""glTF: Khronos's validator, and three.js's GLTFLoader, which must find the lights that we wrote."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.export import gltf
from mixlight.export.rig import Rig, make_rig
from mixlight.light import harmonics
from mixlight.light.lights import Light
from tests.interop import images
from tests.interop.rigs import picture_lighting, random_lighting, sphere_normals
from tests.interop.web import Web

pytestmark = pytest.mark.interop

AXES = {
    "+X": (1.0, 0.0, 0.0),
    "-X": (-1.0, 0.0, 0.0),
    "+Y": (0.0, 1.0, 0.0),
    "-Y": (0.0, -1.0, 0.0),
    "+Z": (0.0, 0.0, 1.0),
    "-Z": (0.0, 0.0, -1.0),
}


def axis_rig() -> Rig:
    """A light of its own brightness on each axis."""
    lights = tuple(
        Light(name, torch.tensor(axis), (1.0 + place) * torch.tensor([1.0, 0.5, 0.1]), 0.14)
        for place, (name, axis) in enumerate(AXES.items())
    )
    dark = torch.zeros(9, 3)
    return Rig(torch.zeros(16, 32, 3), lights, True, dark, dark, name="axes")


RIGS = {
    "axes": axis_rig(),
    "residual": make_rig(random_lighting(5), height=32),
    "full": make_rig(random_lighting(5), residual=False, height=32),
    "no lights": make_rig(random_lighting(6), lights=0, height=32),
}


@pytest.fixture(scope="module")
def found(web: Web, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What validator and loader say of each rig, and a matte sphere that the loaded lights light."""
    folder = tmp_path_factory.mktemp("gltf")
    for name, rig in RIGS.items():
        (folder / name).mkdir()
        gltf.write(rig, folder / name)
    script = """
        import * as THREE from 'three';
        import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
        import { validate, version } from 'gltf-validator';
        import { Stage, matte } from '/lib/three_stage.js';
        export default async ({ files, names }) => {
          const found = { version: version() };
          const { renderer } = new Stage();
          for (const name of names) {
            const url = `${files}${name}/lights.gltf`;
            const report = await validate(await (await fetch(url)).text());
            const { scene, scenes } = await new GLTFLoader().loadAsync(url);
            scene.updateMatrixWorld(true);
            const lights = [];
            scene.traverse((light) => {
              if (!light.isLight) return;
              const at = light.getWorldPosition(new THREE.Vector3());
              const towards = at.sub(light.target.getWorldPosition(new THREE.Vector3())).normalize();
              lights.push({
                name: light.name, type: light.type, visible: light.visible, towards: towards.toArray(),
                irradiance: light.color.clone().multiplyScalar(light.intensity).toArray(),
              });
            });
            const stage = new Stage(renderer);
            stage.scene.add(scene);
            const front = stage.sphere(matte(1), 48);
            const back = stage.sphere(matte(1), 48, { behind: true });
            found[name] = { report, scenes: scenes.length, about: scene.userData, lights, front, back };
          }
          return found;
        };
    """
    result: dict[str, Any] = web.run(script, files=folder, names=list(RIGS))
    return result


rigs = pytest.mark.parametrize("name", RIGS)


@rigs
def test_the_validator_has_nothing_to_say(found: dict[str, Any], name: str) -> None:
    issues = found[name]["report"]["issues"]
    assert found["version"].startswith("2.0.0")
    # Lights that are switched off have no node: the validator mentions them as unused, which is the point.
    off = 0 if RIGS[name].lights_on else len(RIGS[name].lights)
    assert (issues["numErrors"], issues["numWarnings"], issues["numHints"]) == (0, 0, 0)
    assert [message["code"] for message in issues["messages"]] == ["UNUSED_OBJECT"] * off


@rigs
def test_three_finds_each_light_that_is_on(found: dict[str, Any], name: str) -> None:
    rig, loaded = RIGS[name], found[name]
    assert loaded["scenes"] == 1
    assert loaded["about"]["mixlight"]["map"] == rig.map_kind
    expected = rig.lights if rig.lights_on else ()
    assert len(loaded["lights"]) == len(expected)
    for light, ours in zip(loaded["lights"], expected, strict=True):
        assert (light["type"], light["visible"]) == ("DirectionalLight", True)
        assert light["towards"] == pytest.approx(ours.direction.tolist(), abs=1e-6)
        assert light["irradiance"] == pytest.approx(ours.irradiance.tolist(), rel=1e-6)


@rigs
@pytest.mark.parametrize("side", ["front", "back"])
def test_the_loaded_lights_light_a_sphere_from_where_they_are(
    found: dict[str, Any], name: str, side: str
) -> None:
    normals, inside = sphere_normals(48, behind=side == "back")
    expected = torch.zeros_like(normals)
    for light in RIGS[name].lights if RIGS[name].lights_on else ():
        cosine = (normals @ light.direction.double()).clamp_min(0)
        expected += cosine[..., None] * light.irradiance.double() / math.pi
    picture = torch.from_numpy(found[name][side]).double()
    difference = (picture - expected).abs()[inside]
    scale = max(1.0, float(expected.mean()))
    assert float(difference.mean()) < 0.003 * scale
    assert float(difference.max()) < 0.05 * scale  # a facet at the edge of a light's half


def test_a_scene_lit_by_the_file_and_its_map(web: Web, tmp_path: Path) -> None:
    """The docs' picture: lights of the glTF, and the map that lies beside it as its extras say."""
    gltf.write(make_rig(picture_lighting()), tmp_path)
    script = """
        import * as THREE from 'three';
        import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
        import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
        import { pack } from 'harness';
        export default async ({ files, width, height }) => {
          const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
          renderer.setSize(width, height);
          const { scene } = await new GLTFLoader().loadAsync(`${files}lights.gltf`);
          const stage = new THREE.Scene();
          stage.add(scene);
          const environment = await new EXRLoader().loadAsync(`${files}environment.exr`);
          environment.mapping = THREE.EquirectangularReflectionMapping;
          stage.environment = stage.background = environment;
          stage.environmentRotation.y = stage.backgroundRotation.y = Math.PI / 2; // its centre is -Z
          [[1, 0], [0.4, 1], [0.1, 1]].forEach(([roughness, metalness], i) => {
            const color = new THREE.Color(0.8, 0.8, 0.8);
            const material = new THREE.MeshStandardMaterial({ color, roughness, metalness });
            const mesh = new THREE.Mesh(new THREE.TorusKnotGeometry(0.62, 0.25, 192, 32), material);
            mesh.position.x = 2.3 * (i - 1);
            stage.add(mesh);
          });
          const camera = new THREE.PerspectiveCamera(35, width / height, 0.1, 100);
          camera.position.z = 6.6;
          renderer.render(stage, camera);
          const canvas = document.createElement('canvas');
          Object.assign(canvas, { width, height });
          const context = canvas.getContext('2d');
          context.drawImage(renderer.domElement, 0, 0);
          return pack(context.getImageData(0, 0, width, height).data, [height, width, 4]);
        };
    """
    pixels = web.run(script, files=tmp_path, width=720, height=405)
    images.hold("gltf", np.ascontiguousarray(pixels[..., :3]))


def test_the_harmonics_in_extras_are_those_of_the_map(tmp_path: Path) -> None:
    rig = RIGS["residual"]
    gltf.write(rig, tmp_path)
    document = json.loads((tmp_path / "lights.gltf").read_text())
    written = document["scenes"][0]["extras"]["mixlight"]["harmonics"]
    projected = harmonics.project(rig.environment)
    torch.testing.assert_close(torch.tensor(written["ambient"]), projected, rtol=1e-5, atol=1e-6)
    assert (written["kind"], written["basis"], written["order"]) == ("radiance", "real-sh", "l*l+l+m")
