"""Configs: defaults, overrides, and messages that name the dotted key."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from mixlight.training.config import TrainingConfig, differences, read_config, to_plain


def write(folder: Path, text: str = "", tables: str = 'tables = ["rooms.csv"]\n') -> Path:
    path = folder / "config.toml"
    path.write_text(tables + text, encoding="utf-8")
    return path


def test_what_the_file_does_not_say_keeps_its_default(tmp_path: Path) -> None:
    config = read_config(
        write(tmp_path, "steps = 7\n[optimiser]\nlearning_rate = 1\n[crops]\npitch_deg = [-9, -8, -7]\n")
    )
    default = TrainingConfig(("x",))
    assert (config.steps, config.batch_size) == (7, default.batch_size)
    assert config.optimiser.learning_rate == 1.0
    assert isinstance(config.optimiser.learning_rate, float)
    assert config.optimiser.backbone_rate == default.optimiser.backbone_rate
    assert config.crops.pitch_deg == (-9.0, -8.0, -7.0)
    assert config.camera == default.camera


def test_paths_are_relative_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    config = read_config(
        write(tmp_path / "deep", 'backbone_weights = "../start.safetensors"\n', 'tables = ["../a.csv"]\n')
    )
    assert config.tables == (str(tmp_path / "a.csv"),)
    assert config.backbone_weights == str(tmp_path / "start.safetensors")
    assert read_config(write(tmp_path, 'backbone_weights = "none"\n')).backbone_weights == "none"
    whole = read_config(write(tmp_path / "deep", 'model_weights = "../a.safetensors"\n'))
    assert whole.model_weights == str(tmp_path / "a.safetensors")
    assert read_config(write(tmp_path, 'model_weights = "default"\n')).model_weights == "default"


def test_overrides_replace_values_by_their_dotted_key(tmp_path: Path) -> None:
    overrides: dict[str, Any] = {
        "steps": 3,
        "optimiser.learning_rate": 1e-5,
        "loss.spheres": [1, 0, 0],
        "tables": ["b.csv"],
    }
    config = read_config(write(tmp_path, "steps = 7\n[loss]\nspheres = [0.5, 0, 0]\n"), overrides)
    assert (config.steps, config.optimiser.learning_rate, config.loss.spheres) == (3, 1e-5, (1, 0, 0))
    assert config.tables == (str(tmp_path / "b.csv"),)


def test_a_table_of_weights_is_replaced_whole_by_the_file_and_by_key_by_an_override(tmp_path: Path) -> None:
    path = write(tmp_path, "[sampling.weights]\nroom = 2\n")
    assert read_config(path).sampling.weights == {"room": 2.0}
    assert read_config(path, {"sampling.weights.cave": 1}).sampling.weights == {"room": 2.0, "cave": 1.0}
    default = TrainingConfig(("x",)).sampling.weights
    changed = read_config(write(tmp_path), {"sampling.weights.outdoor": 0}).sampling.weights
    assert changed == {**default, "outdoor": 0.0}
    assert TrainingConfig(("x",)).sampling.weights == default


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("step = 7", "unknown key step; expected one of tables, name, method, seed, steps"),
        ("[optimiser]\nrate = 1", "unknown key optimiser.rate; expected one of name, learning_rate"),
        ("[optimizer]\nname = 'adam'", "unknown key optimizer"),
        ("steps = 7.5", "expected a whole number for steps, got 7.5"),
        ("steps = true", "expected a whole number for steps, got True"),
        ("steps = '7'", "expected a whole number for steps, got '7'"),
        ("tensorboard = 1", "expected true or false for tensorboard, got 1"),
        ("name = 3", "expected a string for name, got 3"),
        ("optimiser = 3", "expected a table for optimiser, got 3"),
        ("[optimiser]\nlearning_rate = 'fast'", "expected a number for optimiser.learning_rate, got 'fast'"),
        ("[optimiser]\nlearning_rate = nan", "expected a finite number for optimiser.learning_rate, got nan"),
        ("[crops]\npitch_deg = [1, 2]", "expected 3 values for crops.pitch_deg, got 2"),
        ("[crops]\npitch_deg = 5", "expected a list for crops.pitch_deg, got 5"),
        ("[loss]\nspheres = [1, 2, 'x']", "expected a number for loss.spheres, got 'x'"),
        ("[sampling]\nweights = [1]", "expected a table for sampling.weights, got [1]"),
        ("[sampling.weights]\nroom = 'much'", "expected a number for sampling.weights.room, got 'much'"),
        (
            "[model]\nsparse_mode = 'dense'",
            "expected masked or literal or sparsemax or none or softmax for model.sparse_mode",
        ),
        ("[labels]\nseparation = 'best'", "for labels.separation, got 'best'"),
        # Values of the right type that cannot be: the section is named.
        ("steps = 0", "expected steps of at least 1, got 0"),
        ("seed = -1", "expected seed of at least 0, got -1"),
        ("precision = 'float16'", "expected precision float32 or bfloat16"),
        ("[optimiser]\nname = 'sgd'", "optimiser: expected name adamw or adam, got 'sgd'"),
        ("[optimiser]\nclip_norm = 0", "optimiser: expected clip_norm above 0"),
        ("[optimiser]\nema_decay = 1.5", "optimiser: expected ema_decay in [0, 1], got 1.5"),
        ("[model]\nbackbone = 'resnet'", "model: expected a backbone out of"),
        ("[labels]\nazimuths = 48", "labels: expected height whose double"),
        ("[crops]\npitch_deg = [3, 2, 1]", "crops: expected pitch_deg as lowest, most frequent and highest"),
        ("[camera]\nnoise = -1", "camera: expected noise of at least 0"),
        ("[loss]\ncamera = -1", "loss: expected camera of at least 0"),
        ("[model]\nanchors = 64", "same number of anchors in labels and model, got 128 and 64"),
    ],
)
def test_a_wrong_config_is_refused_by_its_dotted_key(tmp_path: Path, text: str, says: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(ValueError, match="config") as caught:
        read_config(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("overrides", "says"),
    [
        ({"optimiser.rate": 1}, "unknown key optimiser.rate"),
        ({"steps.more": 1}, "unknown key steps.more; steps is no table"),
        ({"optimiser": 3}, "expected a table for optimiser"),
        ({"a.b.c": 1}, "unknown key a"),
    ],
)
def test_a_wrong_override_is_refused_by_its_dotted_key(
    tmp_path: Path, overrides: dict[str, Any], says: str
) -> None:
    with pytest.raises(ValueError, match="config") as caught:
        read_config(write(tmp_path, "steps = 7\n"), overrides)
    assert says in str(caught.value)


def test_tables_are_asked_for(tmp_path: Path) -> None:
    for tables, says in (("", "missing key tables"), ("tables = []\n", "expected at least one CSV table")):
        with pytest.raises(ValueError, match=says):
            read_config(write(tmp_path, tables=tables))


def test_what_is_no_toml_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"gone\.toml: expected a TOML config"):
        read_config(tmp_path / "gone.toml")
    with pytest.raises(ValueError, match=r"config\.toml: expected TOML, .*line 2"):
        read_config(write(tmp_path, "steps = \n"))
    (tmp_path / "latin.toml").write_bytes("name = 'Hütte'".encode("latin-1"))
    with pytest.raises(ValueError, match=r"latin\.toml: expected TOML"):
        read_config(tmp_path / "latin.toml")


def test_a_config_is_plain_values_and_comes_back(tmp_path: Path) -> None:
    config = read_config(write(tmp_path, "steps = 7\n"))
    plain = json.loads(json.dumps(to_plain(config), allow_nan=False))
    assert plain["optimiser"]["name"] == "adamw"
    assert differences(plain, config) == []


def test_differences_name_keys_that_matter() -> None:
    saved = json.loads(json.dumps(to_plain(TrainingConfig(("a.csv",)))))
    saved["optimiser"]["learning_rate"] = 0.5
    saved["sampling"]["weights"] = {"room": 1.0}
    saved["retired"] = {"key": 3}
    del saved["model"]["dropout"]
    found = differences(saved, TrainingConfig(("a.csv",), workers=5, tensorboard=True, checkpoint_every=7))
    assert [line.split(":")[0] for line in found] == [
        "optimiser.learning_rate",
        "retired.key",
        "sampling.weights",
    ]
    rate = TrainingConfig(("a.csv",)).optimiser.learning_rate
    assert found[0] == f"optimiser.learning_rate: 0.5 -> {rate!r}"
    assert math.isfinite(rate)


def test_the_configs_of_the_experiments_are_read() -> None:
    folder = Path(__file__).parents[2] / "experiments"
    paths = sorted(folder.glob("*.toml"))
    assert paths or not folder.exists()  # a source archive holds no experiments
    for path in paths:
        assert read_config(path).tables
