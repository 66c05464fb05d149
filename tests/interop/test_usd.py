"""USD itself: usd-core opens the stage and finds the light in it."""

import math
from pathlib import Path
from typing import Any

import pytest
import torch

from mixlight.export import usd
from mixlight.export.rig import Rig, make_rig
from mixlight.image import exr
from tests.interop.rigs import card_rig, random_lighting

pytestmark = pytest.mark.interop


def opened(rig: Rig, folder: Path, name: str = usd.FILE_NAME) -> Any:
    from pxr import Usd

    usd.write(rig, folder)
    return Usd.Stage.Open(str(folder / name))


def distant_lights(stage: Any) -> list[Any]:
    from pxr import UsdLux

    return [UsdLux.DistantLight(prim) for prim in stage.Traverse() if prim.IsA(UsdLux.DistantLight)]


def test_the_stage_is_y_up_in_metres_with_a_default_prim(tmp_path: Path) -> None:
    from pxr import UsdGeom

    stage = opened(make_rig(random_lighting(4), height=16), tmp_path)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetDefaultPrim().GetPath() == "/mixlight"


def test_the_dome_light_finds_its_map(tmp_path: Path) -> None:
    from pxr import UsdLux

    stage = opened(card_rig(128), tmp_path)
    dome = UsdLux.DomeLight(stage.GetPrimAtPath("/card/environment"))
    assert dome.GetIntensityAttr().Get() == 1
    assert tuple(dome.GetColorAttr().Get()) == (1, 1, 1)
    assert dome.GetTextureFormatAttr().Get() == "latlong"
    resolved = Path(dome.GetTextureFileAttr().Get().resolvedPath)
    assert resolved == tmp_path / "environment.exr"
    pixels, header = exr.read(resolved)
    # USD and OpenEXR alike look a latlong map up from +Z at its centre, +X at the left quarter.
    assert header["envmap"] == "latlong"
    assert pixels[63, 128].tolist() == pytest.approx([0, 0, 4], abs=0.01)  # +Z is blue
    assert pixels[63, 64].tolist() == pytest.approx([4, 0, 0], abs=0.01)  # +X is red


@pytest.mark.parametrize("residual", [True, False])
def test_distant_lights_are_the_rigs(tmp_path: Path, residual: bool) -> None:
    from pxr import Gf, Usd, UsdGeom, UsdLux

    rig = make_rig(random_lighting(4), height=16, residual=residual)
    stage = opened(rig, tmp_path)
    found = distant_lights(stage)
    assert [light.GetPrim().GetName() for light in found] == [light.name for light in rig.lights]
    for prim, light in zip(found, rig.lights, strict=True):
        world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        travel = world.TransformDir(Gf.Vec3d(0, 0, -1))
        assert [-part for part in travel] == pytest.approx(light.direction.tolist(), abs=1e-6)
        assert UsdLux.LightAPI(prim).GetNormalizeAttr().Get() is True
        irradiance = [prim.GetIntensityAttr().Get() * part for part in prim.GetColorAttr().Get()]
        assert irradiance == pytest.approx(light.irradiance.tolist(), rel=1e-6)
        assert prim.GetExposureAttr().Get() == 0
        assert prim.GetAngleAttr().Get() == pytest.approx(math.degrees(light.angular_diameter), abs=1e-3)
        visible = UsdGeom.Imageable(prim).ComputeVisibility() != "invisible"
        assert visible is rig.lights_on


def test_the_stage_says_what_its_map_holds(tmp_path: Path) -> None:
    stage = opened(make_rig(random_lighting(4), height=16), tmp_path)
    about = stage.GetRootLayer().customLayerData["mixlight"]
    assert (about["map"], about["frame"], about["exposure_gain"]) == ("residual", "usd", 1.0)
    assert len(about["harmonics"]["ambient"]) == 9
    assert about["harmonics"]["basis"] == "real-sh"


def test_the_layer_for_blender_composes(tmp_path: Path) -> None:
    rig = make_rig(random_lighting(4), height=16)
    stage, over = opened(rig, tmp_path), opened(rig, tmp_path, usd.BLENDER_FILE_NAME)
    plain, composed = distant_lights(stage), distant_lights(over)
    assert len(composed) == len(plain) == len(rig.lights) > 0
    for ours, theirs in zip(plain, composed, strict=True):
        assert theirs.GetIntensityAttr().Get() == pytest.approx(ours.GetIntensityAttr().Get() / 4)
        assert theirs.GetAngleAttr().Get() == pytest.approx(ours.GetAngleAttr().Get() / 2)
        assert theirs.GetColorAttr().Get() == ours.GetColorAttr().Get()


def test_usd_reads_the_text_as_our_own_reader_does(tmp_path: Path) -> None:
    """What usd-core writes anew from our layer, our reader still reads: both mean the same by it."""
    rig = make_rig(random_lighting(4), height=16)
    stage = opened(rig, tmp_path)
    text = stage.GetRootLayer().ExportToString()
    (tmp_path / usd.FILE_NAME).write_text(text, encoding="utf-8")
    again = usd.read(tmp_path)
    for ours, theirs in zip(rig.lights, again.lights, strict=True):
        torch.testing.assert_close(theirs.direction, ours.direction)
        torch.testing.assert_close(theirs.irradiance, ours.irradiance)
    assert torch.equal(again.sh, rig.sh)
