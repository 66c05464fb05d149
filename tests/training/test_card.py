"""The card: where weights come from, without a word on the machine."""

import subprocess
from pathlib import Path

import pytest

from mixlight.data.panoramas import PanoramaRecord
from mixlight.network.model import ModelSettings
from mixlight.training import card
from mixlight.training.config import TrainingConfig

RECORDS = [
    PanoramaRecord(s, Path(s), "train", c, s) for s, c in (("a", "indoor"), ("b", "room"), ("c", "room"))
]


@pytest.mark.parametrize(
    ("start", "backbone", "says"),
    [
        ("imagenet", "efficientnet_lite0", "initialised from EfficientNet-Lite0 (Apache-2.0, ImageNet)"),
        ("imagenet", "densenet121", "initialised from the shipped densenet121 weights (ImageNet)"),
        ("none", "densenet121", "initialised at random"),
        ("/home/somebody/densenet.safetensors", "densenet121", "initialised from densenet.safetensors"),
    ],
)
def test_the_card_names_the_start_of_the_backbone(start: str, backbone: str, says: str) -> None:
    config = TrainingConfig(("/home/somebody/a.csv",), model=ModelSettings(backbone), backbone_weights=start)
    made = card.make_card(config, RECORDS, {"score": 0.5})
    assert made["licence"] == f"Apache-2.0; backbone {says}"
    assert made["data"] == {"tables": ["a.csv"], "panoramas": 3, "by_category": {"indoor": 1, "room": 2}}
    assert made["validation"] == {"score": 0.5}
    assert "somebody" not in str(made)


def test_the_commit_is_that_of_this_checkout() -> None:
    found = card.commit()
    done = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=Path(__file__).parent, capture_output=True, text=True, check=False
    )
    if done.returncode:
        assert found == "unknown"  # an unpacked source archive
    else:
        assert found != "unknown"


@pytest.mark.parametrize("error", [FileNotFoundError("git"), subprocess.CalledProcessError(128, "git")])
def test_outside_a_checkout_the_commit_is_unknown(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(card.subprocess, "run", fail)
    assert card.commit() == "unknown"


def test_a_package_inside_another_repository_has_no_commit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(
        card, "_git", lambda *arguments: str(tmp_path) if "--show-toplevel" in arguments else "abc"
    )
    assert card.commit() == "unknown"
