"""Maps of other systems: found by name, turned into our frame, refused where they are not what is said."""

import math
from pathlib import Path

import pytest
import torch

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.evaluation.predictions import Predictions
from mixlight.image import exr, radiance
from mixlight.sphere import equirect
from mixlight.sphere.frames import FRAMES, convert_panorama
from tests.synthetic import room

PITCH = math.radians(-20)


def sample(name: str = "kitchen") -> EvaluationSample:
    return EvaluationSample(name, 45.0, PITCH, 1.0, torch.zeros(3, 24, 32), torch.zeros(128, 256, 3))


@pytest.mark.parametrize("frame", FRAMES)
def test_a_map_comes_back_from_any_frame(tmp_path: Path, frame: str) -> None:
    ours = room(32)
    exr.write(tmp_path / "kitchen_az045.exr", convert_panorama(ours, "mixlight", frame).numpy(), {})
    found = Predictions(tmp_path, frame).environment(sample())
    torch.testing.assert_close(found, ours, rtol=1e-3, atol=1e-3)  # half floats in the file


def test_radiance_files_and_folders_of_scenes(tmp_path: Path) -> None:
    (tmp_path / "house").mkdir()
    radiance.write(tmp_path / "house/kitchen_az045.hdr", room(32).numpy())
    found = Predictions(tmp_path).environment(sample("house/kitchen"))
    assert found.shape == (32, 64, 3)


def test_a_map_with_the_cameras_horizon_is_turned_upright(tmp_path: Path) -> None:
    """A lamp on the optical axis of a camera that looks down by 20 degrees lies that far below level."""
    lamp = torch.zeros(128, 256, 3)
    lamp[62:66, 126:130] = 10.0
    exr.write(tmp_path / "kitchen_az045.exr", lamp.numpy(), {})
    for horizon, elevation in (("level", 0.0), ("camera", -20.0)):
        found = Predictions(tmp_path, horizon=horizon).environment(sample())
        rays, weight = equirect.pixel_directions(128), equirect.solid_angle(128)
        centre = (rays * (found[..., :1] * weight[..., None])).sum((0, 1))
        centre = centre / torch.linalg.vector_norm(centre)
        assert math.degrees(math.asin(float(centre[1]))) == pytest.approx(elevation, abs=0.3)
        assert abs(float(centre[0])) < 0.01


def test_what_cannot_be_used_is_refused_with_the_files_name(tmp_path: Path) -> None:
    files = Predictions(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"kitchen_az045\.exr or kitchen_az045\.hdr, found none"):
        files.environment(sample())
    path = tmp_path / "kitchen_az045.exr"
    path.write_bytes(b"no picture")
    with pytest.raises(ValueError, match="kitchen_az045"):
        files.environment(sample())
    exr.write(path, torch.ones(32, 32, 3).numpy(), {})
    with pytest.raises(ValueError, match=r"kitchen_az045\.exr.*32"):
        files.environment(sample())
    exr.write(path, torch.ones(32, 64, 3).numpy(), {})
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(ValueError, match=r"kitchen_az045\.exr"):
        files.environment(sample())
    radiance.write(tmp_path / "kitchen_az045.hdr", torch.ones(32, 64, 3).numpy())
    with pytest.raises(ValueError, match="expected one map, found"):
        files.environment(sample())


def test_a_map_that_says_it_is_laid_out_for_another_program_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "kitchen_az045.exr"
    exr.write(path, room(32).numpy(), {"software": "mixlight 0.1", "frame": "blender"})
    with pytest.raises(ValueError, match="frame 'mixlight', got one whose header says 'blender'"):
        Predictions(tmp_path).environment(sample())
    assert Predictions(tmp_path, "blender").environment(sample()).shape == (32, 64, 3)


def test_versions_follow_the_file_and_how_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a_az000.exr"
    exr.write(path, room(32).numpy(), {})
    first = Predictions(tmp_path).version("a_az000")
    assert Predictions(tmp_path, "three").version("a_az000") != first
    assert Predictions(tmp_path, horizon="camera").version("a_az000") != first
    exr.write(path, room(32, 1).numpy(), {})
    assert Predictions(tmp_path).version("a_az000") != first


@pytest.mark.usefixtures("unchecked")
def test_bad_settings(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="expected a folder of predicted maps"):
        Predictions(tmp_path / "none")
    with pytest.raises(ValueError, match="expected a frame out of mixlight"):
        Predictions(tmp_path, "maya")
    with pytest.raises(ValueError, match="expected a horizon out of level, camera"):
        Predictions(tmp_path, horizon="tilted")  # type: ignore[arg-type]
