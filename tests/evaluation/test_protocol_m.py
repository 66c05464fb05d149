"""Protocol M: every method on every sample, summarised with intervals over whole panoramas."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.floors import oracle_light, photo_mean_light
from mixlight.evaluation.protocol_m import Scores, evaluate
from mixlight.image import exr
from mixlight.network.canonical import CanonicalView
from mixlight.render.spheres import SphereRenderer
from tests.synthetic import room


@pytest.fixture(scope="module")
def renderer() -> SphereRenderer:
    return SphereRenderer(resolution=16, height=32)


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> list[EvaluationSample]:
    folder = tmp_path_factory.mktemp("rooms")
    records = []
    for k in range(2):
        exr.write(folder / f"{k}.exr", room(32, k).numpy(), {})
        records.append(PanoramaRecord(f"room{k}", folder / f"{k}.exr", "test", "indoor", f"room{k}"))
    return collect(records, CanonicalView(24, 32), 2)


def test_methods_are_scored_in_their_order_of_merit(
    samples: list[EvaluationSample], renderer: SphereRenderer
) -> None:
    methods = {
        "truth": lambda sample: sample.environment,
        "truth, twice as bright": lambda sample: 2 * sample.environment,
        "oracle": oracle_light,
        "photo": photo_mean_light,
    }
    found = evaluate(methods, samples, renderer)
    assert list(found) == list(methods)
    assert {tuple(scores.rmse.shape) for scores in found.values()} == {(4, 3)}
    zero = torch.zeros(4, 3)
    torch.testing.assert_close(found["truth"].rmse, zero, rtol=0, atol=1e-6)
    torch.testing.assert_close(found["truth, twice as bright"].si_rmse, zero, rtol=0, atol=1e-5)
    # Twice the truth is off by the truth itself.
    for k, sample in enumerate(samples):
        shown = renderer.render(sample.environment)[:, renderer.mask]
        expected = shown.square().mean((1, 2)).sqrt()
        torch.testing.assert_close(found["truth, twice as bright"].rmse[k], expected, rtol=1e-4, atol=0)
    assert bool((found["oracle"].rmse[:, 0] < 0.5 * found["photo"].rmse[:, 0]).all())


def test_scores_are_invariant_where_they_should_be(
    samples: list[EvaluationSample], renderer: SphereRenderer
) -> None:
    def dimmed(sample: EvaluationSample) -> Tensor:
        return 0.125 * photo_mean_light(sample)

    found = evaluate({"one": photo_mean_light, "dimmed": dimmed}, samples, renderer)
    torch.testing.assert_close(found["one"].si_rmse, found["dimmed"].si_rmse, rtol=1e-4, atol=1e-6)
    assert not torch.allclose(found["one"].rmse, found["dimmed"].rmse)


def test_methods_and_samples_are_asked_for(samples: list[EvaluationSample]) -> None:
    with pytest.raises(ValueError, match="got 0 and 4"):
        evaluate({}, samples)
    with pytest.raises(ValueError, match="got 1 and 0"):
        evaluate({"photo": photo_mean_light}, [])


def test_the_summary_holds_medians_means_and_intervals_of_six_cells() -> None:
    generator = torch.Generator().manual_seed(0)
    scores = Scores(torch.rand(40, 3, generator=generator), torch.rand(40, 3, generator=generator))
    groups = [f"room{k // 8}" for k in range(40)]
    table = scores.summary(groups, resamples=200)
    assert list(table) == [f"{s}_{e}" for e in ("rmse", "si_rmse") for s in ("diffuse", "matte", "mirror")]
    for i, sphere in enumerate(("diffuse", "matte", "mirror")):
        cell = table[f"{sphere}_rmse"]
        values = scores.rmse[:, i].double().numpy()
        assert cell["median"] == pytest.approx(np.median(values), abs=1e-4)
        assert cell["mean"] == pytest.approx(values.mean(), abs=1e-4)
        low, high = cell["median_95"]  # type: ignore[misc]
        assert values.min() <= low <= cell["median"] <= high <= values.max()
    assert scores.summary(groups, resamples=200) == table


def test_intervals_are_over_panoramas_not_views() -> None:
    """Eight equal views of each panorama say no more than one of each."""
    one = torch.linspace(0.1, 1.0, 10)[:, None].expand(-1, 3)
    views = one.repeat_interleave(8, 0)
    rooms = [f"room{k}" for k in range(10)]
    wide = Scores(views, views).summary([r for r in rooms for _ in range(8)], 500)["diffuse_rmse"][
        "median_95"
    ]
    same = Scores(one, one).summary(rooms, 500)["diffuse_rmse"]["median_95"]
    apart = Scores(views, views).summary([str(k) for k in range(80)], 500)["diffuse_rmse"]["median_95"]
    assert wide == same
    assert wide[1] - wide[0] > 1.5 * (apart[1] - apart[0])  # type: ignore[index]


def test_a_group_for_every_sample_is_asked_for() -> None:
    with pytest.raises(ValueError, match="one group for each of 2 samples, got 1"):
        Scores(torch.zeros(2, 3), torch.zeros(2, 3)).summary(["room"])


def test_a_sample_says_where_it_looked(samples: list[EvaluationSample], tmp_path: Path) -> None:
    assert [(sample.scene, sample.azimuth_deg) for sample in samples] == [
        ("room0", 0.0), ("room0", 180.0), ("room1", 0.0), ("room1", 180.0),
    ]  # fmt: skip
