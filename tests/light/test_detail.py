import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import gaussians
from mixlight.light.detail import GATHER, GATHER_AREA, Detail
from mixlight.light.lighting import Lighting
from mixlight.light.lights import merge
from mixlight.sphere import equirect
from mixlight.sphere.points import nearest

HEIGHT = 64
FOV = math.radians(60)


def lit(where: dict[tuple[float, float, float], float], ambient: float = 0.6, count: int = 128) -> Lighting:
    """Even ambient light of that radiance, and white lobes at the anchors nearest to some directions."""
    coefficients, energy = torch.zeros(9, 3), torch.zeros(count, 3)
    coefficients[0] = ambient * math.sqrt(4 * math.pi)
    light = Lighting(coefficients, energy)
    for direction, strength in where.items():
        energy[nearest(light.axes, torch.tensor(direction))] += strength
    return light


def gray(value: float = 0.5) -> Tensor:
    return torch.full((60, 80, 3), value)


def with_lamp(rows: slice = slice(10, 16), columns: slice = slice(50, 56)) -> Tensor:
    photo = gray(0.3)
    photo[rows, columns] = 1.0
    return photo


def random_lighting(seed: int) -> Lighting:
    generator = torch.Generator().manual_seed(seed)
    ambient = 0.2 * torch.randn(9, 3, generator=generator)
    ambient[0] = 1 + torch.rand(3, generator=generator)
    energy = torch.rand(128, 3, generator=generator)
    energy[torch.rand(128, generator=generator) > 0.06] = 0
    return Lighting(ambient, energy)


@given(
    seed=st.integers(0, 500), pitch=st.floats(-0.6, 0.6), roll=st.floats(-0.3, 0.3), fov=st.floats(0.5, 2.0)
)
def test_the_energy_of_the_map_is_kept_whatever_the_photo(
    seed: int, pitch: float, roll: float, fov: float
) -> None:
    generator = torch.Generator().manual_seed(seed)
    photo = (2 * torch.rand(12, 16, 3, generator=generator)) ** 2
    lighting = random_lighting(seed)
    detail = Detail.of_photo(photo, fov, 32, pitch=pitch, roll=roll)
    made = detail.environment(lighting)
    assert bool((made >= 0).all())
    torch.testing.assert_close(
        equirect.integrate(made), equirect.integrate(lighting.environment(32)), rtol=2e-5, atol=0
    )
    torch.testing.assert_close(
        equirect.integrate(detail.sources_map(lighting)), lighting.energy.sum(0), rtol=2e-5, atol=0
    )


def test_where_the_photo_looks_its_pixels_are_in_the_map() -> None:
    photo = torch.linspace(0.1, 0.8, 80)[:, None].expand(60, 80, 3).contiguous()
    detail = Detail.of_photo(photo, FOV, HEIGHT)
    made = detail.environment(lit({(0.0, 0.0, 1.0): 2.0}))
    inside = detail.weight > 0.999
    assert int(inside.sum()) > 100
    torch.testing.assert_close(made[inside], detail.radiance[inside], rtol=0, atol=1e-6)
    # The picture's columns, found by hand: texel (32, 64 + k) is (k + 1/2) 180 / 64 degrees to the right.
    for k in (-6, 0, 5):
        column = 40 + 40 * math.tan((k + 0.5) * math.pi / 64) / math.tan(FOV / 2)
        assert float(made[32, 64 + k, 0]) == pytest.approx(0.1 + 0.7 * (column - 0.5) / 79, abs=3e-3)


def test_what_is_hidden_is_the_prediction_times_one_number() -> None:
    lighting = random_lighting(3)
    detail = Detail.of_photo(gray(0.2), FOV, HEIGHT)
    hidden = detail.weight == 0
    before, after = lighting.ambient_map(HEIGHT), detail.ambient_map(lighting)
    lit_before = hidden[..., None] & (before > 1e-3)
    for channel in range(3):
        some = lit_before[..., channel]
        ratio = (after / before)[..., channel][some]
        assert float(ratio.max() - ratio.min()) < 1e-5
    assert bool((after[hidden[..., None] & (before == 0)] == 0).all())


def test_without_contrast_to_the_prediction_nothing_changes() -> None:
    lighting = lit({(0.0, 0.3, 1.0): 3.0}, ambient=0.5)
    made = Detail.of_photo(gray(0.5), FOV, HEIGHT).environment(lighting)
    torch.testing.assert_close(made, lighting.environment(HEIGHT), rtol=1e-5, atol=1e-5)


def test_lobes_go_to_where_the_photo_clips_by_the_formula() -> None:
    """Golden: share k / (k + area), spread by exp((d.u - 1) / gather) over the clipped pixels."""
    photo = with_lamp()
    detail = Detail.of_photo(photo, FOV, HEIGHT)
    lighting = lit({(0.5, 0.5, 0.7): 5.0}, ambient=0.3)
    (anchor,) = (lighting.energy != 0).any(-1).nonzero()[:, 0].tolist()
    axis = lighting.axes[anchor]
    directions, solid_angle = equirect.pixel_directions(HEIGHT), equirect.solid_angle(HEIGHT)
    pull = detail.clipped * ((directions @ axis - 1) / GATHER).exp()
    area = float((pull * solid_angle).sum())
    share = area / (area + GATHER_AREA)
    assert 0 < share < 0.2  # it lies behind the camera
    lobe = gaussians.evaluate_map(lighting.axes, lighting.energy, lighting.sharpness, HEIGHT)
    expected = lobe * (1 - share) + 5.0 * share * (pull / area)[..., None]
    torch.testing.assert_close(detail.sources_map(lighting), expected, rtol=1e-4, atol=1e-5)


def test_a_lamp_in_the_picture_draws_the_lobe_beside_it() -> None:
    detail = Detail.of_photo(with_lamp(), FOV, HEIGHT)
    at_lamp = detail.clipped > 0.3
    aim = torch.nn.functional.normalize(
        equirect.integrate(equirect.pixel_directions(HEIGHT) * detail.clipped[..., None]), dim=0
    )
    lighting = lit({tuple(aim.tolist()): 1.0}, ambient=0.3)  # type: ignore[dict-item]
    before, after = lighting.sources_map(HEIGHT), detail.sources_map(lighting)
    solid_angle = equirect.solid_angle(HEIGHT)[..., None]
    assert float((after * solid_angle)[at_lamp].sum()) > 2 * float((before * solid_angle)[at_lamp].sum())


def test_clipped_pixels_are_at_least_white_and_keep_brighter_ambient_light() -> None:
    detail = Detail.of_photo(gray(1.0), FOV, HEIGHT)
    inside = detail.weight > 0.999
    dim, bright = (detail.ambient_map(lit({}, ambient=value)) for value in (0.9, 3.0))
    torch.testing.assert_close(dim[inside], torch.ones_like(dim[inside]), rtol=1e-5, atol=0)
    torch.testing.assert_close(bright[inside], torch.full_like(bright[inside], 3.0), rtol=1e-5, atol=0)


def test_a_lobe_where_the_photo_shows_no_lamp_moves_out_of_the_picture() -> None:
    detail = Detail.of_photo(gray(0.5), FOV, HEIGHT)
    lighting = lit({(0.05, 0.1, -1.0): 1.0}, ambient=0.5)
    after = detail.sources_map(lighting)
    inside = detail.weight > 0.999
    assert float(lighting.sources_map(HEIGHT)[inside].max()) > 1
    assert float(after[inside].max()) < 1e-5
    torch.testing.assert_close(equirect.integrate(after), torch.ones(3), rtol=1e-5, atol=0)
    mean = equirect.integrate(equirect.pixel_directions(HEIGHT) * after[..., :1])
    assert float(mean[2]) < -0.6  # not to the other side of the room


def test_sources_are_linear_so_a_map_without_lights_holds_the_rest() -> None:
    lighting = random_lighting(7)
    detail = Detail.of_photo(with_lamp(), FOV, HEIGHT, pitch=-0.1)
    lights = merge(lighting, 2)
    taken = [anchor for light in lights for anchor in light.anchors]
    whole, rest = detail.environment(lighting), detail.environment(lighting.without(taken))
    only = detail.sources_map(lighting) - detail.sources_map(lighting.without(taken))
    torch.testing.assert_close(whole, rest + only, rtol=1e-5, atol=1e-5)
    assert bool((whole >= rest - 1e-5).all())
    torch.testing.assert_close(
        equirect.integrate(whole) - equirect.integrate(rest), lighting.energy[taken].sum(0), rtol=1e-4, atol=0
    )


def test_a_photo_too_bright_for_the_predicted_light_fades() -> None:
    """The rest is never dimmed below a quarter, and the energy is kept all the same."""
    lighting = lit({}, ambient=0.02)
    detail = Detail.of_photo(gray(0.9), math.radians(120), HEIGHT)
    opacity = detail.opacity(lighting)
    assert 0 < opacity < 0.2
    made = detail.environment(lighting)
    torch.testing.assert_close(
        equirect.integrate(made), equirect.integrate(lighting.environment(HEIGHT)), rtol=1e-4, atol=0
    )
    hidden = detail.weight == 0
    assert float(made[hidden].min()) == pytest.approx(0.005, rel=1e-3)
    assert Detail.of_photo(gray(0.2), FOV, HEIGHT).opacity(lit({}, ambient=0.2)) == 1
    assert detail.opacity(lit({}, ambient=0.0)) == 0
    assert float(detail.environment(lit({}, ambient=0.0)).max()) == 0


def test_a_linear_photo_counts_as_its_clipped_copy() -> None:
    photo = gray(0.4)
    photo[20:30, 20:30] = 30.0
    linear, clipped = (Detail.of_photo(p, FOV, HEIGHT) for p in (photo, photo.clamp(max=1)))
    torch.testing.assert_close(linear.radiance, clipped.radiance)
    torch.testing.assert_close(linear.clipped, clipped.clipped)
    assert float(linear.clipped.max()) > 0.9


def test_the_share_of_the_sphere_and_an_upright_photo() -> None:
    wide, tall = torch.ones(60, 80, 3), torch.ones(80, 60, 3)
    a, b = math.tan(FOV / 2), math.tan(FOV / 2) * 0.75
    true = math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b))) / math.pi
    assert Detail.of_photo(wide, FOV, HEIGHT, feather=0.0).share == pytest.approx(true, rel=2e-2)
    assert Detail.of_photo(tall, FOV, HEIGHT).share > Detail.of_photo(wide, FOV, HEIGHT).share


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1])
def test_what_is_no_photo_is_refused(value: float) -> None:
    photo = gray()
    photo[3, 4, 1] = value
    with pytest.raises(ValueError, match="photo: expected finite values of at least 0"):
        Detail.of_photo(photo, FOV)


def test_a_batch_of_lightings_is_refused() -> None:
    detail = Detail.of_photo(gray(), FOV, 16)
    with pytest.raises(ValueError, match="expected a single"):
        detail.sources_map(Lighting(torch.zeros(2, 9, 3), torch.zeros(2, 128, 3)))


def test_double_precision_stays() -> None:
    detail = Detail.of_photo(with_lamp().double(), FOV, 16)
    made = detail.environment(random_lighting(1).to(torch.float64))
    assert made.dtype == torch.float64
    torch.testing.assert_close(
        equirect.integrate(made),
        equirect.integrate(random_lighting(1).to(torch.float64).environment(16)),
        rtol=1e-12,
        atol=0,
    )
