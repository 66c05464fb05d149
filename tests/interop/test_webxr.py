"""WebXR's estimate of light, taken in by three.js's own XREstimatedLight as it takes in that of a device."""

import math
from pathlib import Path
from typing import Any

import pytest
import torch

from mixlight.export import webxr
from mixlight.export.probe import Probe, make_probe
from mixlight.export.rig import make_rig
from mixlight.light import harmonics
from tests.interop.rigs import random_lighting, sphere_normals
from tests.interop.web import Web

pytestmark = pytest.mark.interop

RIGS = {
    "residual": make_rig(random_lighting(7), height=32),
    "full": make_rig(random_lighting(7), residual=False, height=32),
    "no lights": make_rig(random_lighting(8), lights=0, height=32),
}


@pytest.fixture(scope="module", params=RIGS)
def seen(
    request: pytest.FixtureRequest, web: Web, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Probe, dict[str, Any]]:
    """A session that hands out our estimate, and what three made of it."""
    folder = tmp_path_factory.mktemp("webxr")
    rig = RIGS[request.param]
    webxr.write(rig, folder)
    script = """
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
          };
        };
    """
    return make_probe(rig), web.run(script, files=folder)


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
