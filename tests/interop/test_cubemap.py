"""Cube maps in Chromium: sampled by WebGL itself, and by three.js as background and reflection."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.export import cubemap
from mixlight.export.rig import make_rig
from mixlight.image import exr, radiance
from mixlight.sphere import equirect
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE
from tests.interop import images
from tests.interop.rigs import card_rig, picture_lighting, random_lighting
from tests.interop.test_three import VIEWS
from tests.interop.web import Web, pack

pytestmark = pytest.mark.interop


def sampled(web: Web, folder: Path, suffix: str, directions: Tensor) -> Tensor:
    """What WebGL's texture(cube, direction) returns for the files of a folder."""
    read = exr.read if suffix == ".exr" else radiance.read
    faces = [read(folder / f"{name}{suffix}")[0] for name in cubemap.NAMES]
    found = web.run(
        "cube_samples.js",
        faces=[pack(face) for face in faces],
        size=faces[0].shape[0],
        directions=pack(directions.numpy()),
        count=len(directions),
    )
    return torch.from_numpy(found[:, :3])


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_webgl_finds_each_axis_of_the_card(web: Web, tmp_path: Path, suffix: str) -> None:
    cubemap.write(card_rig(), tmp_path)
    axes = torch.tensor(list(CARD_AXES.values()))
    colours = CARD_RADIANCE * torch.tensor([CARD_COLOURS[name] for name in CARD_AXES])
    for layout, described in cubemap.LAYOUTS.items():
        found = sampled(web, tmp_path / layout, suffix, axes * torch.tensor(described.signs))
        torch.testing.assert_close(found, colours, rtol=0.01, atol=0.01)


def test_webgl_finds_the_radiance_of_every_direction(web: Web, tmp_path: Path) -> None:
    rig = make_rig(random_lighting(5), height=128)
    cubemap.write(rig, tmp_path)
    directions = equirect.pixel_directions(12).flatten(0, 1)
    expected = equirect.sample(rig.environment, directions)
    found = sampled(web, tmp_path / "opengl", ".exr", directions)
    torch.testing.assert_close(found, expected, rtol=0, atol=0.03 * float(expected.max()))


def test_three_shows_its_faces_unmirrored_all_around(web: Web, tmp_path: Path) -> None:
    cubemap.write(card_rig(), tmp_path)
    script = """
        import { HDRCubeTextureLoader } from 'three/addons/loaders/HDRCubeTextureLoader.js';
        import { Stage, metal } from '/lib/three_stage.js';
        export default async ({ files, views, names }) => {
          const stage = new Stage();
          const cube = await new HDRCubeTextureLoader().setPath(files + 'three/')
            .loadAsync(names.map((name) => name + '.hdr'));
          stage.scene.background = stage.scene.environment = cube;
          const pictures = {};
          for (const [name, angles] of Object.entries(views)) pictures[name] = stage.view(...angles, 64);
          pictures.mirror = stage.sphere(metal(1, 0), 64);
          return pictures;
        };
    """
    pictures = web.run(script, files=tmp_path, views=VIEWS, names=list(cubemap.NAMES))
    for axis in VIEWS:
        colour = [CARD_RADIANCE * part for part in CARD_COLOURS[axis]]
        assert pictures[axis][24:32, 30:34].mean((0, 1)) == pytest.approx(colour, abs=0.1), axis
    # The patch's name stands below its middle, its sign on the left: neither mirrored nor upside down.
    ahead = pictures["-Z"]
    dark = (ahead.max(-1) < 2)[33:42]
    assert dark.sum() > 5
    # A mirror shows behind the viewer in its middle, and at its right what is at the right.
    middle, right = pictures["mirror"][32, 32], pictures["mirror"][32, 54]
    assert middle.argmax() == 2
    assert right.argmax() == 0
    assert right[2] < 0.5 * right[0]


def test_a_picture_for_the_docs(web: Web, tmp_path: Path) -> None:
    """The room of the other pages through its six faces, left to right: as three.js shows them."""
    rig = make_rig(picture_lighting(), residual=False)
    cubemap.write(rig, tmp_path)
    script = """
        import { HDRCubeTextureLoader } from 'three/addons/loaders/HDRCubeTextureLoader.js';
        import { Stage, matteStandard, metal } from '/lib/three_stage.js';
        export default async ({ files, names }) => {
          const stage = new Stage();
          const cube = await new HDRCubeTextureLoader().setPath(files + 'three/')
            .loadAsync(names.map((name) => name + '.hdr'));
          stage.scene.background = stage.scene.environment = cube;
          const spheres = [matteStandard(0.8), metal(0.8, 0.33), metal(0.8, 0)];
          return spheres.map((material) => stage.sphere(material, 160));
        };
    """
    from mixlight.image.color import linear_to_srgb

    spheres = web.run(script, files=tmp_path, names=list(cubemap.NAMES))
    picture = np.concatenate(spheres, axis=1)
    images.hold("cubemap", (linear_to_srgb(np.clip(picture, 0, 1)) * 255).round().astype(np.uint8))
