"""WebXR's estimate of light, taken in by three.js's own XREstimatedLight as it takes in that of a device."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.export import webxr
from mixlight.export.probe import Probe, make_probe
from mixlight.export.rig import Rig, make_rig
from mixlight.image.color import linear_to_srgb
from mixlight.light import harmonics
from tests.interop import images
from tests.interop.rigs import picture_lighting, random_lighting, sphere_normals
from tests.interop.web import Web

pytestmark = pytest.mark.interop

RIGS = {
    "residual": make_rig(random_lighting(7), height=32),
    "full": make_rig(random_lighting(7), residual=False, height=32),
    "no lights": make_rig(random_lighting(8), lights=0, height=32),
}

SCRIPT = """
    import * as THREE from 'three';
    import { XREstimatedLight } from 'three/addons/webxr/XREstimatedLight.js';
    import { Stage, matte } from '/lib/three_stage.js';
    export default async ({ files }) => {
      const { lightEstimate } = await import(`${files}light_estimate.js`);
      const estimate = await lightEstimate();
      const stage = new Stage();
      const { xr } = stage.renderer;
      const frames = [];
      const session = {
        requestLightProbe: async () => new EventTarget(),
        requestAnimationFrame: (callback) => frames.push(callback),
      };
      xr.getSession = () => session;
      const light = new XREstimatedLight(stage.renderer, false);
      const started = new Promise((resolve) => light.addEventListener('estimationstart', resolve));
      xr.dispatchEvent({ type: 'sessionstart' });
      while (!frames.length) await new Promise((resolve) => setTimeout(resolve));
      frames.shift()(0, { session, getLightEstimate: () => estimate });
      await started;
      stage.scene.add(light);
      const { directionalLight, lightProbe } = light;
      return {
        sh: lightProbe.sh.toArray(),
        towards: directionalLight.position.toArray(),
        irradiance: directionalLight.color.clone().multiplyScalar(directionalLight.intensity).toArray(),
        front: stage.sphere(matte(1), 48),
        back: stage.sphere(matte(1), 48, { behind: true }),
        picture: [matte(0.8), new THREE.MeshPhongMaterial({ color: 0x777777, shininess: 60 })]
          .map((material) => stage.sphere(material, 240)),
      };
    };
"""


def take_in(web: Web, rig: Rig, folder: Path) -> tuple[Probe, dict[str, Any]]:
    """Hand our estimate to three's XREstimatedLight through a session of our making."""
    webxr.write(rig, folder)
    return make_probe(rig), web.run(SCRIPT, files=folder)


@pytest.fixture(scope="module", params=RIGS)
def seen(
    request: pytest.FixtureRequest, web: Web, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Probe, dict[str, Any]]:
    """A session that hands out our estimate, and what three made of it."""
    folder = tmp_path_factory.mktemp("webxr")
    return take_in(web, RIGS[request.param], folder)


def test_three_takes_the_numbers_in(seen: tuple[Probe, dict[str, Any]]) -> None:
    probe, found = seen
    assert found["sh"] == pytest.approx(probe.harmonics.flatten().tolist(), rel=1e-6)
    assert found["towards"] == pytest.approx(probe.direction.tolist(), abs=1e-6)
    assert found["irradiance"] == pytest.approx(probe.intensity.tolist(), abs=1e-6)


@pytest.mark.parametrize("side", ["front", "back"])
def test_the_estimate_lights_a_matte_sphere_as_we_say(seen: tuple[Probe, dict[str, Any]], side: str) -> None:
    probe, found = seen
    normals, inside = sphere_normals(48, behind=side == "back")
    cosine = (normals @ probe.direction.double()).clamp_min(0)
    expected = harmonics.irradiance(probe.harmonics.double(), normals)
    expected = (expected + cosine[..., None] * probe.intensity.double()) / math.pi
    difference = (torch.from_numpy(found[side]).double() - expected).abs()[inside] / expected.mean()
    assert float(difference.mean()) < 0.003
    assert float(difference.max()) < 0.05  # a facet at the edge of the light's half


def test_the_docs_show_two_spheres_under_the_estimate(web: Web, tmp_path: Path) -> None:
    _, found = take_in(web, make_rig(picture_lighting(), height=32), tmp_path)
    picture = np.concatenate(found["picture"], axis=1)
    images.hold("webxr", (linear_to_srgb(np.clip(picture, 0, 1)) * 255).round().astype(np.uint8))


def test_the_module_refuses_what_is_no_estimate(web: Web, tmp_path: Path) -> None:
    webxr.write(RIGS["residual"], tmp_path)
    path = tmp_path / webxr.FILE
    path.write_text(path.read_text().replace("mixlight/webxr", "mixlight/arcore"))
    script = """
        export default async ({ files }) => {
          const { lightEstimate } = await import(`${files}light_estimate.js`);
          return lightEstimate().catch((error) => error.message);
        };
    """
    assert (
        web.run(script, files=tmp_path) == "expected mixlight/webxr of version 1, received mixlight/arcore 1"
    )
