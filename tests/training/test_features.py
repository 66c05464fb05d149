"""Heads on cached features: the same light as photos give, kept in the cache, and only heads that learn."""

import dataclasses
from pathlib import Path

import pytest
import torch

from mixlight.data.panoramas import read_table, select
from mixlight.network import weights
from mixlight.network.model import mean_linear_colour
from mixlight.training.config import TrainingConfig, read_config
from mixlight.training.features import FeatureBank, FeatureBatch
from mixlight.training.loop import Run, train
from tests.synthetic import CONFIG, write_dataset

pytestmark = pytest.mark.usefixtures("quick")

TINY = CONFIG.replace("[model]", 'backbone_weights = "none"\nfrozen_views = 5\n[model]\nbackbone = "tiny"')


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> TrainingConfig:
    return read_config(write_dataset(tmp_path_factory.mktemp("data"), TINY))


@pytest.fixture(scope="module")
def run(config: TrainingConfig, quick: None, tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("run")
    return Run(config, folder / "out", resume=False, cache=folder / "cache" / "labels")


def test_features_are_those_of_the_photos(config: TrainingConfig, run: Run) -> None:
    """The bank's views are the training set's own, in order; its features what the backbone says of them."""
    photos = Run(
        dataclasses.replace(config, frozen_views=0),
        run.out.parent / "p",
        resume=False,
        cache=run.out.parent / "cache" / "labels",
    )
    bank = run.training_set
    assert isinstance(bank, FeatureBank)
    assert len(bank) == 5
    batch = photos.training_set.batch(0, 0, 5)
    torch.testing.assert_close(bank.views.anchor_energy, batch.anchor_energy)
    torch.testing.assert_close(bank.views.mean, mean_linear_colour(batch.photo))
    run.model.backbone.eval()
    with torch.no_grad():
        features = run.model.backbone(batch.photo)
    torch.testing.assert_close(bank.views.features.float(), features, rtol=2e-3, atol=2e-3)


def test_batches_depend_on_seed_and_step_alone(run: Run) -> None:
    bank = run.training_set
    assert isinstance(bank, FeatureBank)
    one, same, other = bank.batch(3, 7, 4), bank.batch(3, 7, 4), bank.batch(3, 8, 4)
    assert torch.equal(one.features, same.features)
    assert not torch.equal(one.camera, other.camera)
    assert len({tuple(pose.tolist()) for pose in one.camera}) == 4  # each view at most once
    assert len(bank.batch(0, 0, 99).mean) == 5


def test_a_bank_comes_from_the_cache_unless_something_changed(
    config: TrainingConfig, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = run.out.parent / "cache" / "labels"
    (entry,) = (run.out.parent / "cache" / "features").iterdir()

    def never(*arguments: object) -> FeatureBank:
        raise AssertionError("made anew")

    with monkeypatch.context() as patch:
        patch.setattr(FeatureBank, "make", never)
        again = Run(dataclasses.replace(config, steps=9), run.out.parent / "again", resume=False, cache=cache)
        assert isinstance(again.training_set, FeatureBank)
        assert isinstance(run.training_set, FeatureBank)
        for field in dataclasses.fields(FeatureBatch):
            one, other = (getattr(b.views, field.name) for b in (run.training_set, again.training_set))
            assert torch.equal(one, other)
        labels = dataclasses.replace(config.labels, separation="max_fraction")
        with pytest.raises(AssertionError, match="made anew"):
            Run(dataclasses.replace(config, labels=labels), run.out.parent / "x", resume=False, cache=cache)
    entry.write_bytes(b"damaged")
    healed = Run(config, run.out.parent / "healed", resume=False, cache=cache).training_set
    assert isinstance(healed, FeatureBank)
    assert torch.equal(healed.views.camera, run.training_set.views.camera)


def test_only_the_heads_learn(config: TrainingConfig, run: Run, tmp_path: Path) -> None:
    before = {k: v.clone() for k, v in run.model.backbone.state_dict().items()}
    model = train(config, tmp_path, cache=run.out.parent / "cache" / "labels")
    state, card = weights.load(model)
    for name, tensor in before.items():
        torch.testing.assert_close(state[f"backbone.{name}"].float(), tensor.float(), rtol=1e-3, atol=1e-3)
    assert not torch.equal(state["heads.outputs.bias"], run.model.state_dict()["heads.outputs.bias"])
    assert card["data"]["panoramas"] == len(select(read_table(config.tables[0]), "train"))
