"""Every method trains: its preset, its start, and a loss that falls."""

import dataclasses
from pathlib import Path

import pytest
import torch

from mixlight.network import weights
from mixlight.network.methods import environments
from mixlight.sphere import equirect
from mixlight.training.config import TrainingConfig, read_config, to_plain
from mixlight.training.features import FeatureBatch
from mixlight.training.loop import Run
from mixlight.training.objective import (
    AnchorObjective,
    ExpandedObjective,
    LampObjective,
    make_objective,
    truth_of,
)
from mixlight.training.presets import PRESETS, with_preset
from tests.synthetic import CONFIG, write_dataset

pytestmark = pytest.mark.usefixtures("quick")

TINY = CONFIG.replace("[model]", 'backbone_weights = "none"\nfrozen_views = 4\n[model]\nbackbone = "tiny"')


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_dataset(tmp_path_factory.mktemp("data"), TINY)


CASES = {
    "mixlight": {},
    "gardner19": {"method": "gardner19"},
    "emlight": {"method": "emlight"},
    "SGG": {"model.ambient": "sg9"},
    "SGH": {"model.ambient": "sg9", "model.sources": "sh6"},
    "colours": {"model.sources": "colours"},
}


@pytest.mark.parametrize("case", CASES)
def test_a_few_steps_on_one_batch_lower_its_loss(file: Path, tmp_path: Path, case: str) -> None:
    changes = {
        "optimiser.learning_rate": 5e-3,
        "optimiser.warmup_steps": 0,
        "model.dropout": 0.0,
        "steps": 100,
    }
    config = read_config(file, {**CASES[case], **changes})  # type: ignore[dict-item]
    run = Run(config, tmp_path, resume=False, cache=file.parent / "cache" / "labels")
    run.step = 50  # past the first stage of lamps
    batch = run.training_set.batch(0, 0, 4)
    losses = [run.train_step(batch)["loss"] for _ in range(25)]
    assert losses[-1] < 0.9 * losses[0]


@pytest.mark.parametrize("case", CASES)
def test_training_starts_from_light_of_the_right_brightness(file: Path, tmp_path: Path, case: str) -> None:
    config = read_config(file, CASES[case])
    run = Run(config, tmp_path, resume=False, cache=file.parent / "cache" / "labels")
    batch = run.training_set.batch(0, 0, 4)
    assert isinstance(batch, FeatureBatch)
    torch.nn.init.zeros_(run.model.heads.outputs.weight)
    with torch.no_grad():
        light = run.model.eval().exposed(run.model.heads(batch.features, batch.mean), batch.mean)
        maps = environments(light, config.model, 16)
    ratio = equirect.integrate(maps).log().mean() - equirect.integrate(batch.small_map).log().mean()
    assert abs(float(ratio)) < 1.0


def test_targets_are_in_the_methods_own_terms(file: Path) -> None:
    kinds = {
        "gardner19": LampObjective,
        "SGH": ExpandedObjective,
        "SGG": AnchorObjective,
        "emlight": AnchorObjective,
    }
    for case, kind in kinds.items():
        assert isinstance(make_objective(read_config(file, CASES[case])), kind)


def test_constant_ambient_light_is_the_mean_of_the_rest(file: Path, tmp_path: Path) -> None:
    run = Run(
        read_config(file, CASES["emlight"]), tmp_path, resume=False, cache=file.parent / "cache" / "labels"
    )
    truth = truth_of(run.training_set.batch(0, 0, 4))
    assert torch.equal(run.objective.ambient(truth), truth.ambient[:, :1])


def test_the_file_stands_above_the_preset(file: Path) -> None:
    config = read_config(file, {"method": "gardner19", "lamps.first_stage": 0.5, "loss.reconstruction": 2.0})
    assert config.model.sources == "lamps"
    assert config.lamps.first_stage == 0.5
    assert (config.loss.reconstruction, config.loss.rendering) == (2.0, 0.0)
    for method in PRESETS:
        assert read_config(file, {"method": method}).method == method
    with pytest.raises(
        ValueError, match="expected a method out of mixlight, gardner19, emlight, got 'stylelight'"
    ):
        with_preset({"method": "stylelight"})
    plain = to_plain(config)
    with pytest.raises(ValueError, match="expected a method out of"):
        dataclasses.replace(config, method="other")
    assert plain["lamps"]["first_stage"] == 0.5


def test_a_card_says_which_method_it_is(file: Path, tmp_path: Path) -> None:
    for case, kind in (("gardner19", "gardner19"), ("SGG", "variant")):
        config: TrainingConfig = dataclasses.replace(read_config(file, CASES[case]), steps=1)
        path = Run(config, tmp_path / case, resume=False, cache=file.parent / "cache" / "labels").finish()
        assert weights.load(path)[1]["kind"] == kind
