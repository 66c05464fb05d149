"""Cube maps: against the face selection that graphics cards specify, quadrature, and the panorama."""

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.sphere import cubemap, equirect
from tests.tolerances import TOLERANCE

BATCHES = [(), (2,), (1, 2)]
F64 = TOLERANCE[torch.float64]


def random_map(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))


def hardware_lookup(direction: np.ndarray) -> tuple[int, float, float]:
    """Face, s and t in [0, 1] from the table "Selection of cube map images" of the OpenGL specification."""
    x, y, z = direction
    table = {
        (0, True): (0, -z, -y),
        (0, False): (1, z, -y),
        (1, True): (2, x, z),
        (1, False): (3, x, -z),
        (2, True): (4, x, -y),
        (2, False): (5, -x, -y),
    }
    major = int(np.argmax(np.abs(direction)))
    face, sc, tc = table[major, bool(direction[major] > 0)]
    ma = abs(direction[major])
    return face, (sc / ma + 1) / 2, (tc / ma + 1) / 2


@pytest.mark.parametrize("size", [1, 2, 5])
def test_texels_lie_where_the_hardware_looks(size: int) -> None:
    directions = cubemap.pixel_directions(size, dtype=torch.float64)
    torch.testing.assert_close(directions.norm(dim=-1), torch.ones(6, size, size).double(), **F64)
    for face in range(6):
        for i in range(size):
            for j in range(size):
                found = hardware_lookup(directions[face, i, j].numpy())
                assert found[0] == face
                assert found[1:] == pytest.approx(((j + 0.5) / size, (i + 0.5) / size))


def test_faces_are_in_the_order_of_their_names() -> None:
    for name, direction in zip(cubemap.FACES, cubemap.pixel_directions(1)[:, 0, 0], strict=True):
        expected = torch.zeros(3)
        expected["XYZ".index(name[1])] = 1.0 if name[0] == "+" else -1.0
        assert torch.equal(direction, expected)


def test_solid_angle_equals_quadrature() -> None:
    """Of 1 / (s^2 + t^2 + 1)^(3/2) over each texel."""
    size = 5
    node, weight = np.polynomial.legendre.leggauss(12)
    centre = (np.arange(size) + 0.5) * 2 / size - 1
    s = (centre[:, None] + node / size).reshape(-1)
    w = np.tile(weight / size, size)
    density = (s[None, :] ** 2 + s[:, None] ** 2 + 1) ** -1.5 * w[:, None] * w[None, :]
    expected = density.reshape(size, 12, size, 12).sum((1, 3))
    np.testing.assert_allclose(cubemap.solid_angle(size, dtype=torch.float64), expected, rtol=1e-10)


@pytest.mark.parametrize("size", [1, 2, 3, 64, 333])
def test_solid_angle_of_the_cube_is_the_sphere(size: int) -> None:
    assert 6 * cubemap.solid_angle(size, dtype=torch.float64).sum().item() == pytest.approx(4 * math.pi)


@pytest.mark.parametrize("size", [4, 7])
def test_from_equirect_looks_the_panorama_up(size: int) -> None:
    panorama = random_map(8, 16, 3)
    found = cubemap.from_equirect(panorama, size, supersample=1)
    expected = equirect.sample(panorama, cubemap.pixel_directions(size, dtype=torch.float64))
    torch.testing.assert_close(found, expected, **F64)
    fine = cubemap.from_equirect(panorama, 3 * size, supersample=1)
    mean = fine.view(6, size, 3, size, 3, 3).mean((2, 4))
    torch.testing.assert_close(cubemap.from_equirect(panorama, size, supersample=3), mean, **F64)


@pytest.mark.parametrize("size", [16, 33])
def test_the_way_there_and_back_keeps_smooth_light_and_its_energy(size: int) -> None:
    x, y, z = equirect.pixel_directions(64, dtype=torch.float64).unbind(-1)
    panorama = torch.stack((2 + x + y * z, 2 - y + x * x, 2 + z), -1)
    cube = cubemap.from_equirect(panorama, size)
    weights = cubemap.solid_angle(size, dtype=torch.float64)[..., None]
    torch.testing.assert_close(
        (cube * weights).sum((0, 1, 2)), equirect.integrate(panorama), rtol=1e-3, atol=0
    )
    back = cubemap.to_equirect(cube, 64)
    torch.testing.assert_close(back, panorama, rtol=0, atol=0.02)
    torch.testing.assert_close(equirect.integrate(back), equirect.integrate(panorama), rtol=1e-3, atol=0)


@pytest.mark.parametrize("size", [1, 2, 5])
def test_to_equirect_of_a_uniform_cube_is_uniform(size: int) -> None:
    found = cubemap.to_equirect(torch.full((6, size, size, 2), 0.3), 16)
    torch.testing.assert_close(found, torch.full((16, 32, 2), 0.3), **TOLERANCE[torch.float32])


def test_to_equirect_returns_the_texels_at_their_centres() -> None:
    """Around each centre the interpolation is within a slope's reach of the texel."""
    cube = random_map(6, 3, 3, 1)
    panorama = cubemap.to_equirect(cube, 512)
    found = equirect.sample(panorama, cubemap.pixel_directions(3, dtype=torch.float64))
    torch.testing.assert_close(found, cube, rtol=0, atol=0.02)


def test_to_equirect_is_seamless_over_edges_and_corners() -> None:
    """Neighbouring fine pixels never differ by more than the slope of the interpolation allows."""
    size, height = 4, 256
    panorama = cubemap.to_equirect(random_map(6, size, size, 1), height)[..., 0]
    # Texels a pixel; a face seen at a slant towards its corner has up to three times as many.
    step = 3 * (math.pi / height) / (2 / size)
    assert panorama.diff(dim=0).abs().max() < step
    across = (panorama - panorama.roll(1, 1)).abs()
    assert across.max() < step


def test_to_equirect_of_a_fine_cube_misses_no_light() -> None:
    cube = torch.zeros(6, 64, 64, 1, dtype=torch.float64)
    cube[2, 20, 40] = 1.0
    energy = cubemap.solid_angle(64, dtype=torch.float64)[20, 40].item()
    found = equirect.integrate(cubemap.to_equirect(cube, 16)).item()
    assert found == pytest.approx(energy, rel=0.15)


@pytest.mark.parametrize("batch", BATCHES)
def test_both_ways_take_any_batch(batch: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 8, 16, 3)
    cube = cubemap.from_equirect(panorama, 4)
    assert cube.shape == (*batch, 6, 4, 4, 3)
    back = cubemap.to_equirect(cube, 8)
    assert back.shape == panorama.shape
    last = cubemap.from_equirect(panorama.reshape(-1, 8, 16, 3)[-1], 4)
    torch.testing.assert_close(cube.reshape(-1, 6, 4, 4, 3)[-1], last)
    torch.testing.assert_close(back.reshape(-1, 8, 16, 3)[-1], cubemap.to_equirect(last, 8))


def test_gradients() -> None:
    panorama = random_map(2, 4, 1).requires_grad_()
    assert torch.autograd.gradcheck(lambda p: cubemap.from_equirect(p, 2), (panorama,))
    cube = random_map(6, 2, 2, 1).requires_grad_()
    assert torch.autograd.gradcheck(lambda c: cubemap.to_equirect(c, 3), (cube,))


def test_bad_input_is_refused() -> None:
    with pytest.raises(ValueError, match="faces of at least 1 x 1, received size 0"):
        cubemap.pixel_directions(0)
    with pytest.raises(ValueError, match="received size 0"):
        cubemap.solid_angle(0)
    with pytest.raises(ValueError, match="received size 0"):
        cubemap.from_equirect(torch.zeros(2, 4, 3), 0)
    with pytest.raises(ValueError, match="supersample of at least 1, received 0"):
        cubemap.from_equirect(torch.zeros(2, 4, 3), 2, 0)
    with pytest.raises(ValueError, match="height of at least 1, received 0"):
        cubemap.to_equirect(torch.zeros(6, 2, 2, 3), 0)
    check = getattr(cubemap.to_equirect, "__wrapped__", cubemap.to_equirect)
    for shape in ((5, 2, 2, 3), (6, 2, 3, 3), (2, 2, 3)):
        with pytest.raises(ValueError, match=r"cube map \[..., 6, S, S, C\], received shape"):
            check(torch.zeros(shape), 4)
