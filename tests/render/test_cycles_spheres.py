"""What Cycles is asked for, and what becomes of its answer; Blender itself is in tests/interop."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.blender import program
from mixlight.light.reflection import MATERIALS
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.surfaces import PRINCIPLED
from mixlight.render import cycles_spheres
from mixlight.render.cycles_spheres import CyclesSpheres, Job

CAMERA = SphereCamera.perspective((16, 2, 0), 85, 36, 32, 18).cropped()
JOB = Job(CAMERA, PRINCIPLED, samples=4)


class Blender:
    """Stands in for the program: paints each sphere with the mean of its map times the sphere's number."""

    def __init__(self) -> None:
        self.jobs: list[dict[str, Any]] = []
        self.maps: list[int] = []
        self.coverage = 1.0

    def run(self, script: Path, arguments: Sequence[Path], **_: object) -> str:
        if script.name == "version.py":
            Path(arguments[0]).write_text("5.0.1")
            return ""
        folder = Path(arguments[0])
        job = json.loads((folder / "job.json").read_text())
        maps = np.load(folder / "maps.npy")
        self.jobs.append(job)
        self.maps.append(len(maps))
        size = (len(maps), len(job["materials"]), job["camera"]["height"], job["camera"]["width"], 4)
        pictures = np.empty(size, np.float32)
        number = np.arange(size[1])[:, None, None, None] + 1
        pictures[..., :3] = maps.mean((1, 2))[:, None, None, None] * number * self.coverage
        pictures[..., 3] = self.coverage
        np.save(folder / "pictures.npy", pictures)
        (folder / "report.json").write_text(json.dumps({"version": "5.0.1", "seconds": [1.0]}))
        return ""


@pytest.fixture
def blender(monkeypatch) -> Blender:
    stand_in = Blender()
    monkeypatch.setattr(program, "run", stand_in.run)
    monkeypatch.setattr(program, "find_blender", lambda: Path("blender"))
    return stand_in


class TestJob:
    def test_camera_in_a_world_with_our_map_as_it_is(self, blender):
        """Protocol S's camera stands at (0, -16, 2) and looks at the origin; its right is +X."""
        cycles_spheres.render(JOB, [np.ones((4, 8, 3))])
        camera = blender.jobs[0]["camera"]
        assert camera["position"] == pytest.approx([0, -16, 2])
        right, up, back = camera["axes"]
        assert right == pytest.approx([1, 0, 0])
        assert back == pytest.approx([0, -16 / math.sqrt(260), 2 / math.sqrt(260)])
        assert np.cross(right, up) == pytest.approx(back)
        assert camera["fov_x"] == pytest.approx(2 * math.atan(CAMERA.width / 2 / (85 / 36 * 32)))

    def test_orthographic(self, blender):
        cycles_spheres.render(Job(SphereCamera.orthographic(6), MATERIALS), [np.ones((4, 8, 3))])
        camera = blender.jobs[0]["camera"]
        assert camera["fov_x"] is None
        assert camera["span"] == pytest.approx(2)
        # Our +Z, behind the photographer, is -X in that world.
        assert camera["axes"][2] == pytest.approx([-1, 0, 0])

    def test_materials(self, blender):
        cycles_spheres.render(Job(CAMERA, (*PRINCIPLED, *MATERIALS)), [np.ones((4, 8, 3))])
        made = blender.jobs[0]["materials"]
        assert [m["shader"].removeprefix("ShaderNodeBsdf") for m in made] == [
            *["Principled"] * 3,
            "Diffuse",
            *["Anisotropic"] * 2,
        ]
        roughness = [m["inputs"]["Roughness"] for m in made]
        assert roughness == pytest.approx([0.364, 0.3271, 0, 0, 0.3271, 0])
        assert [m["inputs"]["Metallic"] for m in made[:3]] == [0, 1, 1]
        assert made[0]["inputs"]["Specular IOR Level"] == 0.5
        assert made[3]["inputs"]["Color"] == [0.8, 0.8, 0.8, 1]

    @pytest.mark.parametrize("wrong", [{"materials": ()}, {"samples": 0}, {"seed": -1}])
    def test_bad_jobs(self, wrong):
        with pytest.raises(ValueError, match="expected a material, at least one sample"):
            Job(**({"camera": CAMERA, "materials": PRINCIPLED} | wrong))


class TestPictures:
    def test_values_and_mask(self, blender, tmp_path):
        """Blender's values are multiplied by the coverage; ours are means over the covered part."""
        blender.coverage = 0.5
        spheres = CyclesSpheres(JOB, cache=tmp_path)
        pictures = spheres.render(torch.full((4, 8, 3), 2.0))
        assert pictures.shape == (3, CAMERA.height, CAMERA.width, 3)
        for number, picture in enumerate(pictures, 1):
            assert (picture[spheres.mask] == 2 * number).all()
            assert (picture[~spheres.mask] == 0).all()

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, blender, tmp_path, shape):
        environment = torch.rand(*shape, 4, 8, 3)
        pictures = CyclesSpheres(JOB, cache=tmp_path).render(environment)
        assert pictures.shape == (*shape, 3, CAMERA.height, CAMERA.width, 3)
        expected = environment.mean((-3, -2))[..., None, None, :]
        centre = CAMERA.height // 2, CAMERA.width // 2
        torch.testing.assert_close(pictures[..., 0, centre[0], centre[1], :], expected[..., 0, 0, :])

    def test_what_was_rendered_is_kept(self, blender, tmp_path):
        maps = torch.rand(3, 4, 8, 3)
        first = CyclesSpheres(JOB, cache=tmp_path).render(maps[:2])
        again = CyclesSpheres(JOB, cache=tmp_path).render(maps)
        assert blender.maps == [2, 1]
        torch.testing.assert_close(again[:2], first, rtol=0, atol=0)
        for other in (
            Job(CAMERA, PRINCIPLED, 5),
            Job(CAMERA, PRINCIPLED, 4, seed=1),
            Job(CAMERA, MATERIALS, 4),
        ):
            CyclesSpheres(other, cache=tmp_path).render(maps[0])
        assert blender.maps == [2, 1, 1, 1, 1]

    def test_the_same_map_twice_is_rendered_once(self, blender, tmp_path):
        CyclesSpheres(JOB, cache=tmp_path).render(torch.ones(2, 4, 8, 3))
        assert blender.maps == [1]

    def test_a_broken_file_is_rendered_anew(self, blender, tmp_path):
        spheres = CyclesSpheres(JOB, cache=tmp_path)
        first = spheres.render(torch.ones(4, 8, 3))
        (file,) = tmp_path.iterdir()
        file.write_bytes(file.read_bytes()[:50])
        torch.testing.assert_close(spheres.render(torch.ones(4, 8, 3)), first, rtol=0, atol=0)
        assert blender.maps == [1, 1]


class TestBadInput:
    def test_maps(self, blender, tmp_path):
        spheres = CyclesSpheres(JOB, cache=tmp_path)
        with pytest.raises(ValueError, match=r"\[..., H, 2 H, 3\], got \(4, 9, 3\)"):
            spheres.render(torch.ones(4, 9, 3))
        for value in (-1.0, math.nan, math.inf):
            with pytest.raises(ValueError, match="negative or not finite"):
                spheres.render(torch.full((4, 8, 3), value))
        assert blender.maps == []

    def test_blender_answers_with_another_size(self, blender, monkeypatch, tmp_path):
        def smaller(script: Path, arguments: Sequence[Path], **more: object) -> str:
            blender.run(script, arguments, **more)
            if script.name != "version.py":
                file = Path(arguments[0]) / "pictures.npy"
                np.save(file, np.load(file)[:, :, 1:])
            return ""

        monkeypatch.setattr(program, "run", smaller)
        with pytest.raises(program.BlenderError, match="expected pictures of shape"):
            CyclesSpheres(JOB, cache=tmp_path).render(torch.ones(4, 8, 3))
        assert list(tmp_path.iterdir()) == []

    def test_no_blender(self, monkeypatch, tmp_path):
        monkeypatch.setenv(program.VARIABLE, str(tmp_path / "none"))
        with pytest.raises(program.BlenderMissing, match="which is no program"):
            CyclesSpheres(JOB, cache=tmp_path)
