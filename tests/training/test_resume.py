"""`mixlight train`, killed by SIGKILL and started again, ends with the very weights of an unbroken run."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from mixlight.network import weights
from mixlight.training import checkpoint as checkpoints
from tests.synthetic import write_dataset

TIMEOUT = 600


def start(config: Path, out: Path, *more: str) -> "subprocess.Popen[str]":
    # One thread in all runs: sums over threads depend on their number.
    environment = os.environ | {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "mixlight.app.cli", "train", str(config), "--out", str(out), "--json"]
    return subprocess.Popen(
        [*command, "--cache", str(config.parent / "cache"), *more],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip


def finish(process: "subprocess.Popen[str]") -> dict[str, object]:
    out, err = process.communicate(timeout=TIMEOUT)
    assert process.returncode == 0, err
    assert err == ""  # no progress bar where there is no terminal
    result: dict[str, object] = json.loads(out)
    return result


@pytest.mark.slow
def test_a_killed_run_ends_as_an_unbroken_one(tmp_path: Path) -> None:
    config = write_dataset(tmp_path)
    unbroken, broken = tmp_path / "unbroken", tmp_path / "broken"
    result = finish(start(config, unbroken))
    assert result == {"input": str(config), "ok": True, "out": str(unbroken / "model.safetensors")}

    checkpoint = broken / checkpoints.FILE_NAME
    # Batches come from another process here: they must be the same, and that process not in the way.
    victim = start(config, broken, "--set", "workers=1")
    deadline = time.monotonic() + TIMEOUT
    while not checkpoint.exists():
        assert victim.poll() is None, victim.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    victim.send_signal(signal.SIGKILL)
    victim.communicate(timeout=TIMEOUT)
    assert victim.returncode == -signal.SIGKILL
    killed = checkpoints.load(checkpoint).step
    assert killed < 6
    assert not (broken / "model.safetensors").exists()

    finish(start(config, broken))
    one, other = (checkpoints.load(out / checkpoints.FILE_NAME) for out in (unbroken, broken))
    for part in ("model", "average", "best", "optimiser"):
        a, b = getattr(one, part), getattr(other, part)
        assert a.keys() == b.keys()
        assert all(torch.equal(a[key], b[key]) for key in a), part
    assert one.notes["best_metrics"] == other.notes["best_metrics"]
    (first, card), (second, other_card) = (
        weights.load(out / "model.safetensors") for out in (unbroken, broken)
    )
    assert all(torch.equal(first[key], second[key]) for key in first)
    assert card | {"commit": ""} == other_card | {"commit": ""}  # somebody may commit during the test
    log = [json.loads(line) for line in (broken / "log.jsonl").read_text().splitlines()]
    assert [r["step"] for r in log if r["kind"] == "start"] == [0, killed]
    assert [r["step"] for r in log if r["kind"] == "validation"] == [3, 6]
