"""Members of a training: one start, other views, and the mean of their weights."""

import dataclasses
import json
import shutil
from pathlib import Path

import pytest
import torch

from mixlight.network import weights
from mixlight.network.estimator import Estimator
from mixlight.training.config import TrainingConfig, read_config
from mixlight.training.loop import CONFIG_FILE, MODEL_FILE, Run, train
from mixlight.training.members import average, choose, prepare
from tests.synthetic import CONFIG, write_dataset

pytestmark = pytest.mark.usefixtures("quick")


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> TrainingConfig:
    tiny = CONFIG.replace("[model]", '[model]\nbackbone = "tiny"').replace(
        "workers", 'backbone_weights = "none"\nworkers'
    )
    return dataclasses.replace(
        read_config(write_dataset(tmp_path_factory.mktemp("data"), tiny)), seed=3, members=2
    )


@pytest.fixture(scope="module")
def trained(config: TrainingConfig, quick: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run")
    assert train(config, out, cache=Path(config.tables[0]).parent / "cache") == out / MODEL_FILE
    return out


def test_members_start_from_the_same_weights_and_see_other_views(
    config: TrainingConfig, tmp_path: Path
) -> None:
    cache = Path(config.tables[0]).parent / "cache"
    runs = [
        Run(member, tmp_path / str(member.member), resume=False, cache=cache)
        for member in config.split_members()
    ]
    one, other = (run.model.state_dict() for run in runs)
    assert all(torch.equal(one[name], other[name]) for name in one)
    first, second = (next(iter(run._batches())) for run in runs)
    assert not torch.equal(first.photo, second.photo)
    for run in runs:
        run.log.close()


def test_the_model_is_the_mean_of_the_members_that_make_it_better(
    trained: Path, config: TrainingConfig
) -> None:
    members = [weights.load(trained / f"member-{k}" / MODEL_FILE)[0] for k in range(2)]
    found, card = weights.load(trained / MODEL_FILE)
    assert [member["views_seed"] for member in card["members"]] == [3, 10010]
    joined = [state for state, row in zip(members, card["members"], strict=True) if row["averaged"]]
    for name, value in found.items():
        if value.is_floating_point():
            mean = torch.stack([state[name].double() for state in joined]).mean(0)
            assert torch.allclose(value.double(), mean, rtol=1e-3, atol=1e-7), name
    assert sum(not torch.equal(members[0][name], members[1][name]) for name in found) > 10
    assert card["config"]["members"] == json.loads((trained / CONFIG_FILE).read_text())["members"] == 2
    assert all(member["commit"] for member in card["members"])
    alone = [member["validation"]["score"] for member in card["members"]]
    assert card["validation"]["score"] <= min(alone) + 1e-4  # members were scored before they were rounded
    Estimator.load(trained / MODEL_FILE).estimate(torch.rand(48, 64, 3), 1.0)


def test_a_member_joins_the_mean_only_where_val_is_better_for_it() -> None:
    """On a line with the optimum at 0: -1 is the best; 1.5 joins it (mean .25), 4 and 9 do not."""
    states = [{"w": torch.tensor([value])} for value in (4.0, 1.5, -1.0, 9.0)]
    chosen, metrics = choose(states, lambda state: {"score": abs(float(state["w"]))})
    assert chosen == [2, 1]
    assert metrics == {"score": 0.25}
    assert choose(states[:1], lambda state: {"score": 7.0}) == ([0], {"score": 7.0})
    assert choose([states[0]] * 3, lambda state: {"score": 7.0})[0] == [0]  # no better is not better


def test_the_mean_of_two_is_written_where_both_are_chosen(
    config: TrainingConfig, trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(trained, tmp_path / "run")
    monkeypatch.setattr(
        "mixlight.training.members.choose",
        lambda states, validate: ([1, 0], {"score": 0.5, "real/score": 0.5}),
    )
    train(config, tmp_path / "run", cache=Path(config.tables[0]).parent / "cache")
    found, card = weights.load(tmp_path / "run" / MODEL_FILE)
    members = [weights.load(trained / f"member-{k}" / MODEL_FILE)[0] for k in range(2)]
    mean = (members[0]["heads.outputs.weight"].float() + members[1]["heads.outputs.weight"].float()) / 2
    assert not torch.equal(members[0]["heads.outputs.weight"], members[1]["heads.outputs.weight"])
    torch.testing.assert_close(found["heads.outputs.weight"].float(), mean, rtol=1e-3, atol=1e-6)
    assert [row["averaged"] for row in card["members"]] == [True, True]
    assert card["validation"] == {"score": 0.5, "real/score": 0.5}


def test_a_member_is_killed_or_trained_elsewhere_and_the_training_goes_on(
    config: TrainingConfig, trained: Path, tmp_path: Path
) -> None:
    """As docs/training.md says it: one member by itself, another stopped half way, then the whole."""
    cache = Path(config.tables[0]).parent / "cache"
    folder = Path(config.tables[0]).parent
    elsewhere = read_config(folder / "config.toml", {"seed": 3, "members": 1, "member": 1, "camera_views": 0})
    train(elsewhere, tmp_path / "member-1", cache=cache)
    begun = Run(config.split_members()[0], tmp_path / "member-0", resume=True, cache=cache)
    for batch, _ in zip(begun._batches(), range(3), strict=False):
        begun.train_step(batch)
        begun.step += 1
    begun._validate()
    begun._save_checkpoint()
    begun.log.close()
    train(dataclasses.replace(config, camera_views=3), tmp_path, cache=cache)
    for k in range(2):
        one, other = (weights.load(root / f"member-{k}" / MODEL_FILE)[0] for root in (tmp_path, trained))
        assert all(torch.equal(one[name], other[name]) for name in one), k


def test_a_folder_with_a_single_run_is_refused_and_a_fresh_start_keeps_no_member(
    config: TrainingConfig, trained: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    shutil.copytree(trained, out)
    checkpoint = out / "member-1" / "checkpoint.safetensors"
    single = out / checkpoint.name
    shutil.copy(checkpoint, single)
    with pytest.raises(ValueError, match=r"run: holds a single run, and several members are asked for"):
        train(config, out)
    single.unlink()
    with pytest.raises(
        ValueError, match=r"run: holds a run of several members, and a single one is asked for"
    ):
        train(dataclasses.replace(config, members=1), out)
    shutil.copy(checkpoint, single)
    assert checkpoint.is_file()
    prepare(out, resume=False)
    assert not checkpoint.exists()
    assert not single.exists()
    prepare(out, resume=True)
    with pytest.raises(ValueError, match="expected a config of one member for one run, got members = 2"):
        Run(config, tmp_path / "x", resume=False, cache=None)


def test_a_stopped_training_goes_on_and_one_more_member_may_be_added(
    trained: Path, config: TrainingConfig, tmp_path: Path
) -> None:
    cache = Path(config.tables[0]).parent / "cache"
    trained = shutil.copytree(trained, tmp_path / "run")
    before = (trained / MODEL_FILE).read_bytes()
    (trained / MODEL_FILE).unlink()
    train(config, trained, cache=cache)
    assert (trained / MODEL_FILE).read_bytes() == before
    train(dataclasses.replace(config, members=3), trained, cache=cache)
    assert len(weights.load(trained / MODEL_FILE)[1]["members"]) == 3


def test_a_folder_of_another_training_is_refused(trained: Path, config: TrainingConfig) -> None:
    with pytest.raises(ValueError, match=r"member-0: holds a run with another config \(seed: 3 -> 4\)"):
        train(dataclasses.replace(config, seed=4), trained, cache=Path(config.tables[0]).parent / "cache")


def test_the_average_of_one_network_is_itself_and_counters_are_kept() -> None:
    state = {"w": torch.tensor([[0.25, -3.0]], dtype=torch.float16), "n": torch.tensor(7)}
    found = average([state])
    assert torch.equal(found["w"], state["w"].float())
    assert found["n"] == 7
    assert found["n"].dtype == torch.int64
    weighted = average([{"w": torch.full((2,), 60000.0, dtype=torch.float16)}] * 3)
    assert torch.equal(weighted["w"], torch.full((2,), 60000.0))  # the sum would leave float16's range
    assert average([state, state, state])["w"].dtype == torch.float32


@pytest.mark.parametrize("states", [[], [{"a": torch.ones(2)}, {"b": torch.ones(2)}],
                                    [{"a": torch.ones(2)}, {"a": torch.ones(3)}]])  # fmt: skip
def test_networks_that_do_not_match_are_not_averaged(states: list[dict[str, torch.Tensor]]) -> None:
    with pytest.raises(ValueError, match="expected"):
        average(states)


@pytest.mark.parametrize("change", [{"members": 0}, {"member": -1}, {"camera_views": -1}])
def test_a_count_below_one_is_refused(config: TrainingConfig, change: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=f"expected {next(iter(change))} of at least"):
        dataclasses.replace(config, **change)  # type: ignore[arg-type]
