"""Six faces: what a sampler finds for each direction, in each layout."""

from pathlib import Path

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mixlight.export import cubemap as target
from mixlight.image import exr
from mixlight.sphere import cubemap, equirect
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE, calibration_card
from tests.export.rigs import lighting


@pytest.mark.parametrize("layout", target.LAYOUTS)
def test_the_middle_of_each_face_is_the_axis_that_is_sampled_there(layout: str) -> None:
    faces = target.faces(calibration_card(64), layout)
    signs = target.LAYOUTS[layout].signs
    for name, face in zip(cubemap.FACES, faces, strict=True):
        ours = [sign * part for sign, part in zip(signs, CARD_AXES[name], strict=True)]
        (there,) = [other for other, axis in CARD_AXES.items() if list(axis) == ours]
        colour = torch.tensor(CARD_COLOURS[there]) * CARD_RADIANCE
        middle = face[len(face) // 2 - 1 : len(face) // 2 + 1].mean(0)[len(face) // 2]
        torch.testing.assert_close(middle, colour, rtol=0, atol=0.6)  # the name begins right beside it


@settings(max_examples=3)
@given(seed=st.integers(0, 99), layout=st.sampled_from(sorted(target.LAYOUTS)))
def test_every_texel_holds_the_radiance_of_its_direction(seed: int, layout: str) -> None:
    """Independent reference: each texel's direction, turned by the layout's signs, looked up in the map."""
    panorama = lighting(seed).ambient_map(64)
    faces = target.faces(panorama, layout)
    directions = cubemap.pixel_directions(faces.shape[1]) * torch.tensor(target.LAYOUTS[layout].signs)
    expected = equirect.sample(panorama, directions)
    torch.testing.assert_close(faces, expected, rtol=0, atol=0.02 * float(panorama.max()))


@settings(max_examples=3)
@given(seed=st.integers(0, 99))
def test_the_cube_holds_the_maps_energy(seed: int) -> None:
    panorama = lighting(seed).environment(64)
    for layout in target.LAYOUTS:
        faces = target.faces(panorama, layout)
        energy = (faces * cubemap.solid_angle(faces.shape[1])[..., None]).sum((0, 1, 2))
        torch.testing.assert_close(energy, equirect.integrate(panorama), rtol=1e-4, atol=0)


def test_files_are_named_in_the_order_of_graphics_cards(tmp_path: Path) -> None:
    from mixlight.export.rig import make_rig

    paths = target.write(make_rig(lighting(1), height=16), tmp_path)
    assert {path.parent.name for path in paths if path.suffix == ".hdr"} == {"opengl", "three", "unity"}
    assert len([path for path in paths if path.suffix == ".exr"]) == 18
    pixels, header = exr.read(tmp_path / "opengl" / "nz.exr")
    assert pixels.shape == (8, 8, 3)
    assert (header["face"], header["cube"], header["map"]) == ("nz", "opengl", "residual")
    assert "envmap" not in header
