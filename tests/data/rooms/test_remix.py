"""Relightings are linear and exact; recipes are plausible, deterministic and never dark."""

import dataclasses
import math
import random

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.data.rooms.plan import Plan, Sky
from mixlight.data.rooms.remix import (
    Recipe,
    mix,
    plan_recipe,
    random_recipe,
    remix,
    white_balance_gain,
)
from mixlight.data.rooms.store import SKY, SUN
from mixlight.sphere import equirect
from tests.data.rooms.lit import lit_plan, pictures

LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])
GAINS = st.tuples(*[st.floats(0, 10)] * 3)


def tensors(plan: Plan, height: int = 16) -> dict[str, Tensor]:
    return {name: torch.from_numpy(pixels) for name, pixels in pictures(plan, height).items()}


def mean_of(panorama: Tensor) -> Tensor:
    return equirect.integrate(panorama) / (4 * math.pi)


@given(first=GAINS, second=GAINS)
def test_mixing_is_linear(first: tuple[float, float, float], second: tuple[float, float, float]) -> None:
    groups = tensors(lit_plan(), 4)
    one, two = {"ceiling": first, SKY: second}, {"ceiling": second, SUN: first}
    both = {
        "ceiling": tuple(a + b for a, b in zip(first, second, strict=True)), SKY: second, SUN: first
    }  # fmt: skip
    torch.testing.assert_close(
        mix(groups, both),  # type: ignore[arg-type]
        mix(groups, one) + mix(groups, two),
        rtol=1e-5,
        atol=1e-5,
    )


def test_mixing_works_on_any_shape() -> None:
    groups = {"a": torch.ones(3), "b": torch.ones(3)}
    assert mix(groups, {"a": (1.0, 2.0, 3.0), "b": (1.0, 0.0, 0.0)}).tolist() == [2.0, 2.0, 3.0]
    stacked = {"a": torch.ones(2, 4, 8, 3)}
    assert mix(stacked, {"a": (0.5, 0.5, 0.5)}).shape == (2, 4, 8, 3)


@pytest.mark.parametrize("gain", [(-1.0, 0.0, 0.0), (math.inf, 0.0, 0.0), (math.nan, 0.0, 0.0)])
def test_gains_that_are_no_light_are_refused(gain: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="finite gains"):
        mix({"a": torch.ones(3)}, {"a": gain})


def test_a_gain_for_an_unknown_group_is_refused() -> None:
    with pytest.raises(ValueError, match="lamp"):
        mix({"a": torch.ones(3)}, {"lamp": (1.0, 1.0, 1.0)})


def test_the_plan_s_recipe_is_what_the_plan_switches_on() -> None:
    plan = lit_plan()
    groups = tensors(plan)
    expected = groups["ceiling"] + groups["floor_lamp_1"] + groups[SKY] + groups[SUN]
    torch.testing.assert_close(remix(groups, plan_recipe(plan)), expected)
    night = dataclasses.replace(plan, sky=Sky("night", None, 0.0, 1.0, (1.0, 1.0, 1.0), None))
    assert SUN not in plan_recipe(night).gains


@given(share=st.floats(0, 1), mean=st.tuples(*[st.floats(0.01, 100)] * 3))
def test_white_balance_keeps_luminance_and_takes_a_share_of_the_cast(
    share: float, mean: tuple[float, float, float]
) -> None:
    colour = torch.tensor(mean, dtype=torch.float64)
    gain = white_balance_gain(colour, share)
    after = colour * gain
    weights = LUMINANCE.double()
    assert float(after @ weights) == pytest.approx(float(colour @ weights), rel=1e-6)
    # The cast shrinks to its power 1 - share: warm stays warm until all of it is taken out.
    before_cast, after_cast = (colour[0] / colour[2]).log(), (after[0] / after[2]).log()
    assert float(after_cast) == pytest.approx((1 - share) * float(before_cast), abs=1e-6)


def test_white_balance_works_on_any_batch() -> None:
    means = torch.rand(1, 2, 3) + 0.1
    each = torch.stack([white_balance_gain(m, 0.7) for m in means[0]])
    torch.testing.assert_close(white_balance_gain(means, 0.7)[0], each)


def test_a_remix_is_balanced_by_its_own_mean() -> None:
    groups = tensors(lit_plan())
    recipe = Recipe({"ceiling": (3.0, 1.0, 0.2)}, white_balance=1.0)
    mean = mean_of(remix(groups, recipe))
    torch.testing.assert_close(mean, mean.mean().expand(3), rtol=1e-4, atol=0)
    unbalanced = mix(groups, recipe.gains)
    torch.testing.assert_close(mean @ LUMINANCE, mean_of(unbalanced) @ LUMINANCE)


def recipes(plan: Plan, count: int = 300) -> list[Recipe]:
    groups = tensors(plan, 4)
    return [random_recipe(groups, plan, random.Random(seed)) for seed in range(count)]


def test_recipes_are_a_function_of_the_generator() -> None:
    plan = lit_plan()
    groups = tensors(plan, 4)
    assert random_recipe(groups, plan, random.Random(3)) == random_recipe(groups, plan, random.Random(3))
    assert random_recipe(groups, plan, random.Random(3)) != random_recipe(groups, plan, random.Random(4))


def test_recipes_vary_and_always_light_the_room() -> None:
    plan = lit_plan()
    groups = tensors(plan, 4)
    made = recipes(plan)
    times = {recipe.facts["time"] for recipe in made}
    assert times == {"day", "dusk", "night"}
    for name in ("ceiling", "floor_lamp_1", "table_lamp_1", SUN):
        on = sum(name in recipe.gains for recipe in made) / len(made)
        assert 0.1 < on < 0.95, name
    for recipe in made:
        assert set(recipe.gains) <= set(groups)
        assert 0.6 <= recipe.white_balance <= 1.0
        light = remix(groups, recipe)
        equirect.check(light)


def test_dim_rooms_get_more_lamps() -> None:
    """Every lamp gives 1 cd/m², the sky nothing: half of that is always there, and at times one lamp does."""
    plan = lit_plan()
    groups = {name: torch.full((4, 8, 3), 1 / 683) for name in tensors(plan, 4)}
    groups[SKY], groups[SUN] = torch.zeros(4, 8, 3), torch.zeros(4, 8, 3)
    lamps = []
    for seed in range(200):
        recipe = random_recipe(groups, plan, random.Random(seed))
        lamps.append(len(set(recipe.gains) - {SKY, SUN}))
        assert float(mix(groups, recipe.gains).mean()) * 683 > 0.45
    assert {1, 2, 3} <= set(lamps)


def test_the_sky_follows_the_time_of_day() -> None:
    made = recipes(lit_plan())
    level = {"day": [], "dusk": [], "night": []}
    for recipe in made:
        level[recipe.facts["time"]].append(recipe.facts["sky_lx"])
        if recipe.facts["time"] == "night":
            assert SUN not in recipe.gains
    assert (
        max(level["night"]) <= 8 < 30 <= min(level["dusk"]) <= max(level["dusk"]) <= 2000 < min(level["day"])
    )


@pytest.mark.parametrize("time", ["dusk", "night"])
def test_night_never_becomes_day(time: str) -> None:
    plan = lit_plan(sky=Sky(time, None, 0.0, 3.0, (1.0, 1.0, 1.0), None))
    order = ("day", "dusk", "night")
    assert {recipe.facts["time"] for recipe in recipes(plan, 60)} <= set(order[order.index(time) :])


def test_a_room_with_nothing_but_sky_keeps_it() -> None:
    plan = lit_plan(fixtures=())
    for recipe in recipes(plan, 60):
        assert min(recipe.gains[SKY]) > 0


def test_a_windowless_room_at_night_has_a_lamp_on() -> None:
    plan = lit_plan(openings=(), sky=Sky("night", None, 0.0, 3.0, (1.0, 1.0, 1.0), None))
    groups = tensors(plan, 4)
    groups[SKY] = torch.zeros_like(groups[SKY])
    for seed in range(200):
        recipe = random_recipe(groups, plan, random.Random(seed))
        assert set(recipe.gains) & {"ceiling", "floor_lamp_1", "table_lamp_1"}
