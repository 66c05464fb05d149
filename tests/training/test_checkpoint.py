"""Checkpoints: exact round trips, an optimiser that goes on, and nothing foreign."""

from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import nn

from mixlight.training import checkpoint as checkpoints
from mixlight.training.checkpoint import Checkpoint


def example(step: int = 12) -> Checkpoint:
    generator = torch.Generator().manual_seed(step)
    weights = {"a/b.weight": torch.randn(3, 4, generator=generator), "count": torch.tensor(5)}
    return Checkpoint(
        step,
        weights,
        {key: value * 2 for key, value in weights.items()},
        {},
        {"0.step": torch.tensor(3.0), "0.exp_avg": torch.randn(3, 4, generator=generator).T},
        {"config": {"seed": 1}, "best_metrics": {"score": 0.1 + 0.2}},
    )


def test_a_checkpoint_comes_back_bit_by_bit(tmp_path: Path) -> None:
    saved = example()
    checkpoints.save(tmp_path / "c.safetensors", saved)
    loaded = checkpoints.load(tmp_path / "c.safetensors")
    assert (loaded.step, loaded.notes) == (saved.step, saved.notes)
    for part in ("model", "average", "best", "optimiser"):
        old, new = getattr(saved, part), getattr(loaded, part)
        assert old.keys() == new.keys()
        assert all(torch.equal(old[key], new[key]) and old[key].dtype == new[key].dtype for key in old)


def test_tensors_that_share_memory_are_stored_apart(tmp_path: Path) -> None:
    saved = example()
    saved.average = saved.best = saved.model
    checkpoints.save(tmp_path / "c.safetensors", saved)
    assert torch.equal(checkpoints.load(tmp_path / "c.safetensors").best["count"], torch.tensor(5))


def test_a_failed_write_leaves_the_old_checkpoint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.safetensors"
    checkpoints.save(path, example(1))

    def full(*_: object, **__: object) -> bytes:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(checkpoints, "to_bytes", full)
    with pytest.raises(OSError, match="No space"):
        checkpoints.save(path, example(2))
    assert checkpoints.load(path).step == 1
    assert list(tmp_path.iterdir()) == [path]


def test_leftovers_of_a_killed_write_are_removed_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.safetensors"
    checkpoints.save(path, example())
    (tmp_path / ".checkpoint.0a1b2c.part.safetensors").touch()
    (tmp_path / ".model.0a1b2c.part.safetensors").touch()
    checkpoints.remove_leftovers(path)
    assert sorted(p.name for p in tmp_path.iterdir()) == [".model.0a1b2c.part.safetensors", path.name]


def test_foreign_files_are_refused_by_name(tmp_path: Path) -> None:
    tensors = {"model/a": torch.zeros(2)}
    cases = {
        "empty": lambda p: p.write_bytes(b""),
        "text": lambda p: p.write_text("no checkpoint at all, but long enough to look like one"),
        "pickle": lambda p: torch.save(tensors, p),
        "weights": lambda p: save_file({"conv.weight": torch.zeros(2)}, p),
        "bare": lambda p: save_file(tensors, p),
        "step": lambda p: save_file(tensors, p, {"step": "one", "notes": "{}"}),
        "notes": lambda p: save_file(tensors, p, {"step": "1", "notes": "[1]"}),
        "json": lambda p: save_file(tensors, p, {"step": "1", "notes": "{"}),
        "hollow": lambda p: save_file({"best/a": torch.zeros(2)}, p, {"step": "1", "notes": "{}"}),
    }
    for name, write in cases.items():
        path = tmp_path / name
        write(path)
        with pytest.raises(ValueError, match="expected a training checkpoint, got") as caught:
            checkpoints.load(path)
        assert str(caught.value).startswith(f"{path}: ")
    with pytest.raises(FileNotFoundError):
        checkpoints.load(tmp_path / "missing")


def test_a_truncated_checkpoint_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.safetensors"
    checkpoints.save(path, example())
    path.write_bytes(path.read_bytes()[:-7])
    with pytest.raises(ValueError, match="expected a training checkpoint"):
        checkpoints.load(path)


@pytest.mark.parametrize("kind", [torch.optim.AdamW, torch.optim.Adam])
def test_a_restored_optimiser_goes_on_as_the_old_one(kind: type[torch.optim.AdamW], tmp_path: Path) -> None:
    def steps(model: nn.Linear, optimiser: torch.optim.Optimizer, numbers: range) -> None:
        for k in numbers:
            optimiser.zero_grad()
            model(torch.full((2, 3), float(k))).square().sum().backward()
            optimiser.step()

    def fresh() -> tuple[nn.Linear, torch.optim.Optimizer]:
        model = nn.Linear(3, 2)
        nn.init.constant_(model.weight, 0.3)
        nn.init.zeros_(model.bias)
        groups = [
            {"params": [model.weight], "lr": 0.1, "peak": 1},
            {"params": [model.bias], "lr": 0.01, "peak": 2},
        ]
        return model, kind(groups)

    unbroken, optimiser = fresh()
    steps(unbroken, optimiser, range(1, 7))
    first, before = fresh()
    steps(first, before, range(1, 4))
    saved = Checkpoint(3, first.state_dict(), {}, {}, checkpoints.flatten_optimiser(before), {})
    checkpoints.save(tmp_path / "c", saved)
    loaded = checkpoints.load(tmp_path / "c")
    second, after = fresh()
    second.load_state_dict(loaded.model)
    checkpoints.restore_optimiser(after, loaded.optimiser)
    steps(second, after, range(4, 7))
    assert torch.equal(second.weight, unbroken.weight)
    assert torch.equal(second.bias, unbroken.bias)
    assert [group["peak"] for group in after.param_groups] == [1, 2]


def test_state_comes_back_in_the_weights_own_order_in_memory(tmp_path: Path) -> None:
    """A fused optimiser walks memory, not indices; beside channels-last weights other orders mix."""

    def step(model: nn.Conv2d, optimiser: torch.optim.Optimizer, k: int) -> None:
        optimiser.zero_grad()
        picture = torch.randn(1, 3, 8, 8, generator=torch.Generator().manual_seed(k))
        model(picture.to(memory_format=torch.channels_last)).square().sum().backward()
        optimiser.step()

    def fresh() -> tuple[nn.Conv2d, torch.optim.Optimizer]:
        with torch.random.fork_rng():
            torch.manual_seed(0)
            model = nn.Conv2d(3, 4, 3)
        model = model.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        return model, torch.optim.AdamW(model.parameters(), 0.1, fused=True)

    unbroken, optimiser = fresh()
    first, before = fresh()
    for k in range(3):
        step(unbroken, optimiser, k)
        step(first, before, k)
    checkpoints.save(
        tmp_path / "c", Checkpoint(3, first.state_dict(), {}, {}, checkpoints.flatten_optimiser(before), {})
    )
    loaded = checkpoints.load(tmp_path / "c")
    second, after = fresh()
    second.load_state_dict(loaded.model)
    checkpoints.restore_optimiser(after, loaded.optimiser)
    for k in range(3, 6):
        step(unbroken, optimiser, k)
        step(second, after, k)
    assert torch.equal(second.weight, unbroken.weight)
    assert torch.equal(second.bias, unbroken.bias)
