"""The test spheres in Blender itself, against exact light transport."""

import json
import math
from pathlib import Path

import pytest
import torch

from mixlight.app.cli import main
from mixlight.blender.program import VARIABLE
from mixlight.data import display
from mixlight.evaluation.renderers import scene_of
from mixlight.image import radiance
from mixlight.light.sphere_camera import SphereCamera
from mixlight.render.cycles_spheres import CyclesSpheres, Job
from mixlight.render.spheres import SphereRenderer
from tests.interop.blenders import VERSIONS, blender_python
from tests.synthetic import room

pytestmark = [pytest.mark.interop, pytest.mark.slow]

CAMERAS = {
    "M": SphereCamera.orthographic(24),
    "S": SphereCamera.perspective((16, 2, 0), 85, 36, 80, 45).cropped(),
}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("scene", ["M", "S"])
def test_pictures(version: str, scene: str, tmp_path: Path) -> None:
    """Within .3, 1 and 1 percent. Two seeds are independent, so (x - A)(x - B) is x's error without noise."""
    found, camera = scene_of(scene), CAMERAS[scene]
    environment = display.encode(room(128, 4))
    ours = SphereRenderer(camera=camera, materials=found.materials, interpolation=found.interpolation)
    x = ours.render(environment)[:, ours.mask].clamp(max=1)
    a, b = (
        CyclesSpheres(
            Job(camera, found.materials, 256, seed), cache=tmp_path, blender=blender_python(version)
        )
        .render(environment)[:, ours.mask]
        .clamp(max=1)
        for seed in (1, 2)
    )
    mean = ((a + b) / 2).mean((1, 2))
    assert x.mean((1, 2)).tolist() == pytest.approx(mean.tolist(), rel=2e-3)
    error = ((x - a) * (x - b)).mean((1, 2)).clamp(min=0).sqrt() / mean
    assert (error < torch.tensor([0.003, 0.01, 0.01])).all(), error.tolist()
    # A world that is turned or mirrored would be far off.
    wrong = ours.render(environment.flip(1))[:, ours.mask].clamp(max=1)
    assert (((wrong - a) * (wrong - b)).mean((1, 2)).sqrt() / mean > 0.02).all()


def test_an_evaluation_by_either_renderer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`mixlight evaluate`, protocol S as it stands, with `--renderer blender`: the same table."""
    monkeypatch.setenv(VARIABLE, str(blender_python(VERSIONS[-1])))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "panoramas"
    folder.mkdir()
    radiance.write(folder / "room.hdr", room(128, 1).numpy())
    cells = {}
    for renderer in ("matrix", "blender"):
        out = tmp_path / renderer
        arguments = [
            "evaluate",
            "--panoramas",
            folder,
            "--protocol",
            "S",
            "--method",
            "photo-mean",
            "--out",
            out,
        ]
        arguments += ["--without-floors", "--renderer", renderer, "--samples", 24, "--json"]
        assert main([str(argument) for argument in arguments]) == 0, capsys.readouterr().err
        results = json.loads((out / "results.json").read_text())
        assert results["renderer"]["kind"] == renderer
        (table,) = results["tables"].values()
        cells[renderer] = {name: cell["mean"] for name, cell in table["photo-mean"].items()}
    assert len(list((tmp_path / "cache" / "mixlight" / "cycles").iterdir())) == 2
    for name in ("rmse", "si_rmse", "angle_deg", "normalised_rmse"):
        exact, rendered = (cells[renderer][f"mirror_{name}"] for renderer in ("matrix", "blender"))
        assert rendered == pytest.approx(exact, rel=0.02), name
    # The other two are noisy at so few paths, and noise adds up in squares: about .04 of it.
    for name in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse"):
        exact, rendered = (cells[renderer][name] for renderer in ("matrix", "blender"))
        assert 0.99 * exact < rendered < math.hypot(exact, 0.07), name
