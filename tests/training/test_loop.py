"""Runs: what they leave behind, how they go on, and what they refuse. A kill is in `test_resume.py`."""

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from mixlight.data.training_set import Batch
from mixlight.network import weights
from mixlight.network.estimator import Estimator
from mixlight.training import checkpoint as checkpoints
from mixlight.training.config import TrainingConfig, read_config
from mixlight.training.loop import CONFIG_FILE, MODEL_FILE, Run, train
from tests.synthetic import CONFIG, write_dataset

pytestmark = pytest.mark.usefixtures("quick")

TINY = CONFIG.replace("[model]", '[model]\nbackbone = "tiny"').replace(
    "workers", 'backbone_weights = "none"\nworkers'
)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_dataset(tmp_path_factory.mktemp("data"), TINY)


@pytest.fixture(scope="module")
def finished(dataset: Path, quick: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that ended; tests copy it before they touch it."""
    out = tmp_path_factory.mktemp("run") / "deep" / "out"
    train(read_config(dataset), out, cache=dataset.parent / "cache")
    return out


def read_log(out: Path, kind: str) -> list[dict[str, Any]]:
    lines = (out / "log.jsonl").read_text().splitlines()
    return [record for record in map(json.loads, lines) if record["kind"] == kind]


def small(dataset: Path, **changes: object) -> TrainingConfig:
    return dataclasses.replace(read_config(dataset), **changes)  # type: ignore[arg-type]


# ------------------------------------------------------------------------------------------ what a run leaves


def test_a_run_leaves_model_log_config_and_checkpoint(finished: Path, dataset: Path) -> None:
    assert sorted(p.name for p in finished.iterdir()) == sorted(
        [MODEL_FILE, CONFIG_FILE, checkpoints.FILE_NAME, "log.jsonl"]
    )
    assert json.loads((finished / CONFIG_FILE).read_text())["optimiser"]["name"] == "adamw"
    (start,) = read_log(finished, "start")
    assert start["torch"] == torch.__version__
    assert {"commit", "mixlight", "numpy", "python"} <= start.keys()
    assert [record["step"] for record in read_log(finished, "train")] == [6]
    assert [record["step"] for record in read_log(finished, "validation")] == [3, 6]
    assert checkpoints.load(finished / checkpoints.FILE_NAME).step == 6
    modes = {oct((finished / name).stat().st_mode & 0o777) for name in (MODEL_FILE, checkpoints.FILE_NAME)}
    assert modes == {oct((finished / CONFIG_FILE).stat().st_mode & 0o777)}


def test_the_model_is_the_best_average_in_half_precision_and_estimates(finished: Path) -> None:
    best = checkpoints.load(finished / checkpoints.FILE_NAME).best
    state, card = weights.load(finished / MODEL_FILE)
    for key, value in best.items():
        half = value.half().float() if value.is_floating_point() and value.ndim > 1 else value
        assert torch.equal(state[key].to(half.dtype), half), key
    scores = {record["step"]: record["score"] for record in read_log(finished, "validation")}
    assert card["validation"]["step"] == min(scores, key=scores.__getitem__)
    photo = torch.rand(48, 64, 3, generator=torch.Generator().manual_seed(0))
    estimate = Estimator.load(finished / MODEL_FILE).estimate(photo, 1.0)
    assert float(estimate.lighting.total_energy().min()) > 0


def test_how_often_val_is_looked_at_changes_no_weight(finished: Path, dataset: Path, tmp_path: Path) -> None:
    """Validated at the end alone, a run gives the weights of its last step, whatever val says of it."""
    train(small(dataset, validate_every=6), tmp_path, cache=dataset.parent / "cache")
    rarely, often = (checkpoints.load(out / checkpoints.FILE_NAME) for out in (tmp_path, finished))
    assert [record["step"] for record in read_log(tmp_path, "validation")] == [6]
    for key, value in often.average.items():
        assert torch.equal(rarely.average[key], value), key
        assert torch.equal(rarely.best[key], value), key


def test_the_card_tells_all_and_no_path_of_this_machine(finished: Path, dataset: Path) -> None:
    card = weights.load(finished / MODEL_FILE)[1]
    assert (card["kind"], card["name"]) == ("mixlight", "tiny")
    assert card["data"] == {"tables": ["table.csv"], "panoramas": 2, "by_category": {"indoor": 2}}
    assert card["config"]["steps"] == 6
    assert card["licence"] == "Apache-2.0; backbone initialised at random"
    assert {"commit", "frame", "units", "versions", "settings"} <= card.keys()
    text = json.dumps(card)
    assert str(dataset.parent) not in text
    assert str(finished) not in text


def test_the_callers_random_numbers_stay_as_they_were(dataset: Path, tmp_path: Path) -> None:
    torch.manual_seed(17)
    before = torch.random.get_rng_state()
    train(small(dataset, steps=1), tmp_path / "out", cache=dataset.parent / "cache")
    assert torch.equal(torch.random.get_rng_state(), before)


# --------------------------------------------------------------------------------------------------- going on


def stop_after(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """The run is interrupted after some steps."""
    original, done = Run.train_step, 0

    def step(self: Run, batch: Batch) -> dict[str, float]:
        nonlocal done
        if done == count:
            raise KeyboardInterrupt
        done += 1
        return original(self, batch)

    monkeypatch.setattr(Run, "train_step", step)


@pytest.mark.parametrize("stop", [1, 3, 5])
def test_an_interrupted_run_ends_with_the_weights_of_an_unbroken_one(
    finished: Path, dataset: Path, tmp_path: Path, stop: int
) -> None:
    """Before the first checkpoint (2), between two, and after the last; with a validation (3) in between."""
    config, cache = read_config(dataset), dataset.parent / "cache"
    with pytest.MonkeyPatch.context() as patch:
        stop_after(patch, stop)
        with pytest.raises(KeyboardInterrupt):
            train(config, tmp_path, cache=cache)
    assert not (tmp_path / MODEL_FILE).exists()
    train(config, tmp_path, cache=cache)
    one = checkpoints.load(finished / checkpoints.FILE_NAME)
    other = checkpoints.load(tmp_path / checkpoints.FILE_NAME)
    assert one.notes == other.notes
    for part in ("model", "average", "best", "optimiser"):
        a, b = getattr(one, part), getattr(other, part)
        assert a.keys() == b.keys()
        assert all(torch.equal(a[key], b[key]) for key in a), part
    (state, card), (other_state, other_card) = (
        weights.load(out / MODEL_FILE) for out in (finished, tmp_path)
    )
    assert all(torch.equal(state[key], other_state[key]) for key in state)
    assert card | {"commit": ""} == other_card | {"commit": ""}  # somebody may commit during the tests
    for kind in ("train", "validation"):
        logs = [[r | {"seconds": 0} for r in read_log(out, kind)] for out in (finished, tmp_path)]
        assert logs[0] == logs[1]


def test_a_finished_run_does_nothing_more(finished: Path, dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    (out / MODEL_FILE).unlink()
    with pytest.MonkeyPatch.context() as patch:
        stop_after(patch, 0)
        train(small(dataset, workers=1, checkpoint_every=5), out, cache=dataset.parent / "cache")
    assert weights.load(out / MODEL_FILE)[0].keys() == weights.load(finished / MODEL_FILE)[0].keys()


def test_a_run_with_another_config_or_other_panoramas_is_refused(
    finished: Path, dataset: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    other = small(dataset, seed=3, batch_size=4)
    with pytest.raises(ValueError, match=r"another config \(batch_size: 2 -> 4; seed: 0 -> 3\)"):
        train(other, out)
    assert checkpoints.load(out / checkpoints.FILE_NAME).step == 6
    table = dataset.parent / "table.csv"
    text = table.read_text()
    try:
        table.write_text(text.replace("room1,", "renamed,"))
        with pytest.raises(ValueError, match="holds a run on other panoramas"):
            train(read_config(dataset), out, cache=dataset.parent / "cache")
    finally:
        table.write_text(text)


def test_a_fresh_run_drops_the_old_one(finished: Path, dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    leftover = out / ".checkpoint.0123.part.safetensors"
    leftover.touch()
    run = Run(small(dataset, seed=3), out, resume=False, cache=dataset.parent / "cache")
    assert run.step == 0
    assert not (out / checkpoints.FILE_NAME).exists()
    assert not leftover.exists()
    assert read_log(out, "train") == []


def test_a_foreign_checkpoint_is_refused(dataset: Path, tmp_path: Path) -> None:
    path = tmp_path / checkpoints.FILE_NAME
    path.write_text("not ours")
    with pytest.raises(ValueError, match="expected a training checkpoint"):
        train(read_config(dataset), tmp_path)
    checkpoints.save(path, checkpoints.Checkpoint(1, {"a": torch.zeros(1)}, {}, {}, {}, {}))
    with pytest.raises(ValueError, match="expected a checkpoint of a training run"):
        train(read_config(dataset), tmp_path)


# --------------------------------------------------------------------------------------------------- learning


def test_weights_move_frozen_ones_do_not_and_the_average_follows(dataset: Path, tmp_path: Path) -> None:
    config = small(dataset)
    config = dataclasses.replace(
        config, optimiser=dataclasses.replace(config.optimiser, frozen_share=0.33, warmup_steps=0)
    )
    run = Run(config, tmp_path, resume=False, cache=dataset.parent / "cache")
    before = {name: p.detach().clone() for name, p in run.model.named_parameters()}
    terms = run.train_step(run.training_set.batch(0, 0, 2))
    moved = {name for name, p in run.model.named_parameters() if not torch.equal(p, before[name])}
    frozen = {name for name, p in run.model.named_parameters() if not p.requires_grad}
    assert len(frozen) == 3
    assert moved == before.keys() - frozen
    name = "heads.outputs.weight"
    after = run.model.state_dict()[name]
    # The first average takes nine tenths of what there is: 1 - (1 + 0) / (10 + 0).
    torch.testing.assert_close(run.average[name], before[name].lerp(after, 0.9))
    assert {"loss", "gradient", "spheres", "camera"} <= terms.keys()


def test_a_network_starts_from_the_mean_light_of_its_data(dataset: Path, tmp_path: Path) -> None:
    run = Run(read_config(dataset), tmp_path, resume=False, cache=dataset.parent / "cache")
    batch = run.training_set.batch(5, 0, 32)
    with torch.no_grad():
        light = run.model.eval()(batch.photo)
    ratio = light.anchor_energy.sum((1, 2)).log().mean() - batch.anchor_energy.sum((1, 2)).log().mean()
    assert abs(float(ratio)) < 0.7
    ratio = light.ambient[:, 0].log().mean() - batch.ambient[:, 0].log().mean()
    assert abs(float(ratio)) < 0.4
    first = [run.training_set.batch(0, 2**31 - 1 - k, 2).camera for k in range(4)]
    torch.testing.assert_close(run.model.heads.outputs.bias[-2:].detach(), torch.cat(first).mean(0))


def test_steps_without_a_finite_gradient_are_logged_left_out_and_end_a_diverging_run(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mixlight.training.loop._MOST_SKIPPED", 2)
    run = Run(read_config(dataset), tmp_path, resume=False, cache=dataset.parent / "cache")
    before = run.model.state_dict()["heads.outputs.weight"].clone()
    forward = run.objective.forward

    def broken(*arguments: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        loss, terms = forward(*arguments)
        return loss * torch.nan, terms

    monkeypatch.setattr(run.objective, "forward", broken)
    with pytest.raises(FloatingPointError, match="got none in 2 steps up to 2"):
        run.finish()
    assert torch.equal(run.model.state_dict()["heads.outputs.weight"], before)
    assert [(r["step"], r["loss"]) for r in read_log(tmp_path, "skipped")] == [(1, None), (2, None)]
    assert not (tmp_path / MODEL_FILE).exists()


def test_a_validation_score_that_is_no_number_ends_the_run(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Run(read_config(dataset), tmp_path, resume=False, cache=dataset.parent / "cache")
    monkeypatch.setattr(run.validation, "evaluate", lambda model: {"score": torch.nan})
    with pytest.raises(FloatingPointError, match="finite validation score, got nan at step 3"):
        run.finish()


@pytest.mark.parametrize("start", ["none", "file"])
def test_a_backbone_may_start_elsewhere(dataset: Path, tmp_path: Path, start: str) -> None:
    first = Run(
        small(dataset, backbone_weights="none"), tmp_path / "a", resume=False, cache=dataset.parent / "cache"
    )
    found = first.model.backbone.state_dict()
    if start == "none":
        again = Run(
            small(dataset, backbone_weights="none"),
            tmp_path / "b",
            resume=False,
            cache=dataset.parent / "cache",
        )
    else:
        path = tmp_path / "start.safetensors"
        weights.save(path, found, {"name": "start"})
        changed = small(dataset, backbone_weights=str(path), seed=9)
        again = Run(changed, tmp_path / "b", resume=False, cache=dataset.parent / "cache")
    assert all(torch.equal(value, again.model.backbone.state_dict()[key]) for key, value in found.items())


def test_a_run_goes_on_from_a_whole_model_of_another_size(dataset: Path, tmp_path: Path) -> None:
    cache = dataset.parent / "cache"
    first = train(small(dataset, backbone_weights="none"), tmp_path / "a", cache=cache)
    larger = read_config(
        dataset,
        {
            "model_weights": str(first),
            "model.height": 48,
            "model.width": 64,
            "optimiser.learning_rate": 0.0,
            "optimiser.backbone_rate": 0.0,
        },
    )
    run = Run(larger, tmp_path / "b", resume=False, cache=cache)
    state, card = weights.load(first)
    for key, value in run.model.state_dict().items():
        torch.testing.assert_close(value, state[key].to(value.dtype), rtol=0, atol=0)
    _, grown = weights.load(run.finish())
    assert grown["started_from"] == card
    assert grown["settings"]["height"] == 48
    assert "/" not in grown["config"]["model_weights"]


# -------------------------------------------------------------------------------------------------- bad input


def test_a_model_to_go_on_from_has_to_fit(dataset: Path, tmp_path: Path) -> None:
    path = tmp_path / "foreign.safetensors"
    weights.save(path, {"x": torch.ones(2)}, {"kind": "something"})
    with pytest.raises(weights.WeightsError, match=r"foreign\.safetensors"):
        train(small(dataset, model_weights=str(path)), tmp_path / "out", cache=dataset.parent / "cache")
    with pytest.raises(weights.WeightsError, match="unheard"):
        train(small(dataset, model_weights="unheard"), tmp_path / "out", cache=dataset.parent / "cache")


def test_one_group_in_two_tables_stays_on_one_side(dataset: Path, tmp_path: Path) -> None:
    twin = dataset.parent / "twin.csv"
    twin.write_text("scene,file,split,category,group\ntwin,room2.hdr,train,indoor,group2\n")
    config = read_config(dataset, {"tables": ["table.csv", "twin.csv"]})
    with pytest.raises(ValueError, match="'group2' in both val and train"):
        train(config, tmp_path, cache=dataset.parent / "cache")


def test_an_output_that_cannot_be_a_folder_is_refused(dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        train(read_config(dataset), tmp_path / "file" / "out")


def test_panoramas_to_train_and_to_validate_on_are_asked_for(dataset: Path, tmp_path: Path) -> None:
    for split, says in (("train", "split val"), ("val", "expected training panoramas")):
        (dataset.parent / "one.csv").write_text(f"file,split,category\nroom0.hdr,{split},indoor\n")
        with pytest.raises(ValueError, match=says):
            train(read_config(dataset, {"tables": ["one.csv"]}), tmp_path, cache=dataset.parent / "cache")
