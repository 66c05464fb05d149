import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import gaussians
from mixlight.light.lighting import Lighting
from mixlight.light.lights import merge
from mixlight.light.separate import luminance
from mixlight.sphere.points import nearest, vogel


def lit(energies: dict[int, object], count: int = 128) -> Lighting:
    energy = torch.zeros(count, 3, dtype=torch.float64)
    for index, value in energies.items():
        energy[index] = torch.as_tensor(value, dtype=torch.float64)
    return Lighting(torch.zeros(9, 3, dtype=torch.float64), energy)


def near(direction: list[float], how_many: int) -> list[int]:
    cosine = vogel(128, dtype=torch.float64) @ torch.tensor(direction, dtype=torch.float64)
    return cosine.argsort(descending=True)[:how_many].tolist()


def lightings() -> st.SearchStrategy[Lighting]:
    def make(drawn: tuple[int, float]) -> Lighting:
        seed, share = drawn
        generator = torch.Generator().manual_seed(seed)
        energy = torch.rand(128, 3, generator=generator).double() ** 3
        energy[torch.rand(128, generator=generator) > share] = 0
        return Lighting(torch.zeros(9, 3).double(), energy)

    return st.tuples(st.integers(0, 999), st.floats(0, 1)).map(make)


def test_one_lobe_is_one_light() -> None:
    (light,) = merge(lit({40: [3.0, 2.0, 1.0]}))
    assert light.name == "light_1"
    assert light.anchors == (40,)
    torch.testing.assert_close(light.direction, vogel(128, dtype=torch.float64)[40])
    assert light.irradiance.tolist() == pytest.approx([3, 2, 1])
    assert light.angular_diameter == pytest.approx(2 * gaussians.cone_half_angle(0.0025))


def test_no_light() -> None:
    assert merge(lit({})) == []


def test_neighbours_join_and_strangers_do_not() -> None:
    window, lamp = near([0.0, 0.6, -0.8], 4), near([0.8, 0.0, 0.6], 1)
    lights = merge(lit(dict.fromkeys(window, 1.0) | dict.fromkeys(lamp, 10.0)))
    assert [light.name for light in lights] == ["light_1", "light_2"]
    assert [list(light.anchors) for light in lights] == [lamp, sorted(window)]
    assert float(lights[1].direction @ torch.tensor([0.0, 0.6, -0.8]).double()) > math.cos(0.2)
    assert lights[1].angular_diameter > lights[0].angular_diameter


def test_a_whole_ceiling_is_several_lights() -> None:
    above = (vogel(128)[:, 1] > 0.3).nonzero()[:, 0].tolist()
    lights = merge(lit(dict.fromkeys(above, 1.0)))
    assert len(lights) > 2
    assert all(light.angular_diameter < math.radians(90) for light in lights)


@given(lighting=lightings())
def test_every_active_lobe_is_in_one_light(lighting: Lighting) -> None:
    lights = merge(lighting)
    anchors = sorted(index for light in lights for index in light.anchors)
    assert anchors == lighting.active.tolist()
    strengths = [float(luminance(light.irradiance)) for light in lights]
    assert strengths == sorted(strengths, reverse=True)
    assert [light.name for light in lights] == [f"light_{n}" for n in range(1, len(lights) + 1)]
    for light in lights:
        assert float(light.direction.norm()) == pytest.approx(1)


@given(seed=st.integers(0, 99))
def test_lights_a_surface_as_its_lobes_do(seed: int) -> None:
    strength = torch.rand(5, 1, generator=torch.Generator().manual_seed(seed)).double() + 0.1
    cluster = near([0.0, 0.8, -0.6], 5)
    lighting = lit(dict(zip(cluster, strength * torch.tensor([3.0, 2.0, 1.0]).double(), strict=True)))
    (light,) = merge(lighting)
    normal = torch.nn.functional.normalize(light.direction + torch.tensor([0.3, 0.1, 0.2]).double(), dim=0)
    seen = light.irradiance * (normal @ light.direction)
    torch.testing.assert_close(seen, lighting.irradiance(normal) / (1 - 0.0025), rtol=1e-3, atol=0)


def test_limit() -> None:
    places = [near(d, 1)[0] for d in ([1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0])]
    lighting = lit(dict(zip(places, [1.0, 3.0, 2.0], strict=True)))
    assert [light.anchors[0] for light in merge(lighting, limit=2)] == [places[1], places[2]]
    assert merge(lighting, limit=0) == []
    with pytest.raises(ValueError, match="at least 0, received -1"):
        merge(lighting, limit=-1)


def test_lights_taken_out_of_the_map_leave_the_rest() -> None:
    lighting = lit({3: 1.0, 90: 2.0})
    left = lighting.without(merge(lighting, limit=1)[0].anchors)
    assert left.active.tolist() == [3]


@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_few_anchors(count: int) -> None:
    lights = merge(lit(dict.fromkeys(range(count), 1.0), count))
    assert sorted(index for light in lights for index in light.anchors) == list(range(count))


def test_dtype_follows(room: Tensor) -> None:
    (light,) = merge(lit({5: 1.0}).to(torch.float32))
    assert light.direction.dtype == light.irradiance.dtype == torch.float32
    assert int(nearest(vogel(128), light.direction)) == 5


def test_a_batch() -> None:
    with pytest.raises(ValueError, match="single lighting"):
        merge(Lighting(torch.zeros(2, 9, 3), torch.zeros(2, 128, 3)))
