"""Ablations: each piece is run once, numbers are protocol M's, and what a file may not say."""

import dataclasses
import json
from pathlib import Path

import pytest
import torch

from mixlight.data.panoramas import read_table
from mixlight.evaluation import ablation
from mixlight.evaluation.ablation import ablate, pieces
from mixlight.evaluation.ablation_report import decided, markdown
from mixlight.evaluation.bench import CELLS, Bench, columns
from mixlight.evaluation.experiment import Experiment, read_experiment
from mixlight.evaluation.protocols import find
from mixlight.evaluation.renderers import matrix
from mixlight.evaluation.representations import Representation
from mixlight.evaluation.scoring import score
from mixlight.network.canonical import CanonicalView
from mixlight.render.spheres import SphereRenderer
from tests.synthetic import CONFIG, write_dataset

REPRESENTATION = """
question = "Which?"
level = "representation"
tables = ["table.csv"]
splits = ["train", "val"]
azimuths = 2
parts = ["whole", "ambient"]
reference = "ours"
[[variant]]
name = "ours"
[[variant]]
name = "constant"
ambient = "constant"
"""

NETWORK = """
question = "Which?"
level = "network"
tables = ["table.csv"]
splits = ["val"]
azimuths = 2
config = "config.toml"
seeds = [0, 1]
reference = "ours"
[[variant]]
name = "ours"
[[variant]]
name = "smooth"
set.model.ambient = "sg9"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    config = CONFIG.replace("[model]", 'backbone_weights = "none"\nfrozen_views = 4\n[model]\nhidden = 8')
    made = write_dataset(tmp_path_factory.mktemp("data"), config).parent
    (made / "a.toml").write_text(REPRESENTATION)
    (made / "b.toml").write_text(NETWORK)
    return made


@pytest.fixture(autouse=True)
def small_spheres(monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = SphereRenderer(resolution=16, height=128)
    monkeypatch.setattr("mixlight.evaluation.bench.SphereRenderer", lambda resolution: renderer)
    monkeypatch.setattr("mixlight.training.validation.SphereRenderer", lambda resolution: renderer)


def test_numbers_are_those_of_protocol_m(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    records = read_table(folder / "table.csv")[:1]
    bench = Bench(records, CanonicalView(), 1)
    true = bench.samples[0].environment
    wrong = 0.5 * true.flip(1)
    (expected,) = score(find("M"), [wrong], true, matrix("M"))
    found = columns(bench.score(wrong[None]))
    for cell in CELLS:
        assert found[cell][0] == pytest.approx(expected[cell], rel=1e-4), cell


def test_a_representation_is_scored_once_and_kept(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = read_experiment(folder / "a.toml")
    seen = []
    result = ablate(experiment, tmp_path / "a.json", progress=lambda piece: seen.append(piece.variant.name))
    assert seen == ["ours", "constant"]
    assert json.loads((tmp_path / "a.json").read_text()) == json.loads(json.dumps(result))
    assert (result["panoramas"], result["views"]) == (3, 6)
    row = result["variants"]["constant"]["parts"]["ambient"]["ratio_to_reference"]["diffuse_rmse"]
    assert row["ratio"] > 1  # nine harmonics hold more than one
    assert result["variants"]["ours"]["parts"]["whole"]["ratio_to_reference"]["diffuse_rmse"]["ratio"] == 1

    def never(*arguments: object) -> None:
        raise AssertionError("run again")

    monkeypatch.setattr(ablation, "_represented", never)
    again = ablate(experiment, tmp_path / "again.json", store=tmp_path / "pieces")
    assert again["variants"] == result["variants"]
    with pytest.raises(AssertionError, match="run again"):
        ablate(
            dataclasses.replace(experiment, parts=("sources",)),
            tmp_path / "c.json",
            store=tmp_path / "pieces",
        )
    with pytest.raises(AssertionError, match="run again"):
        ablate(dataclasses.replace(experiment, azimuths=1), tmp_path / "c.json", store=tmp_path / "pieces")


@pytest.mark.slow
def test_networks_are_trained_by_seed_and_a_stopped_run_goes_on(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = read_experiment(folder / "b.toml")
    cache = folder / "cache" / "labels"

    def stop(piece: ablation.Piece) -> None:
        if piece.seed == 0 and piece.variant.name == "smooth":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ablate(experiment, tmp_path / "b.json", cache=cache, progress=stop)
    kept = sorted((tmp_path / "pieces").glob("*.json"))
    assert len(kept) == 2
    times = [path.stat().st_mtime_ns for path in kept]
    result = ablate(experiment, tmp_path / "b.json", cache=cache)
    assert [path.stat().st_mtime_ns for path in kept] == times
    row = result["variants"]["smooth"]
    assert row["seeds"] == [0, 1]
    assert len(row["parts"]["whole"]["medians_by_seed"]["diffuse_rmse"]) == 2
    assert "frozen" in result["training"]["backbone"]
    assert "±" in markdown(result)


def test_every_seed_comes_after_all_variants_of_the_one_before(folder: Path) -> None:
    order = [(p.seed, p.variant.name) for p in pieces(read_experiment(folder / "b.toml"))]
    assert order == [(0, "ours"), (0, "smooth"), (1, "ours"), (1, "smooth")]


def test_a_decision_wants_interval_and_seeds() -> None:
    def cells(ratio: float, low: float, high: float, seeds: list[float]) -> dict[str, object]:
        found = {"ratio": ratio, "interval_95": [low, high]}
        return {"ratio_to_reference": {"x": found}, "ratios_by_seed": {"x": seeds}}

    assert decided(cells(1.2, 1.1, 1.3, [1.1, 1.3]), "x") == 1
    assert decided(cells(0.8, 0.7, 0.9, [0.7, 0.9]), "x") == -1
    assert decided(cells(1.2, 1.1, 1.3, [0.9, 1.4]), "x") == 0
    assert decided(cells(1.2, 0.9, 1.3, [1.1, 1.3]), "x") == 0
    assert decided(cells(1.002, 1.001, 1.003, []), "x") == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("level = ", "levle = "), "unknown key levle"),
        (('reference = "ours"', ""), "missing key reference"),
        (
            ('reference = "ours"', 'reference = "them"'),
            "expected a reference out of ours, constant, got 'them'",
        ),
        (('ambient = "constant"', 'ambient = "sh3"'), "sh3"),
        (('ambient = "constant"', "colour = 1"), "unknown key colour of constant"),
        (('splits = ["train", "val"]', 'splits = "val"'), "expected a list for splits"),
        (('splits = ["train", "val"]', 'splits = ["all"]'), "expected splits out of train, val, test"),
        (('name = "constant"', 'name = "ours"'), "expected variants of different names"),
        (("azimuths = 2", "azimuths = 0"), "expected azimuths of at least 1"),
        (("question", "question ="), "expected TOML"),
    ],
)
def test_what_a_file_may_not_say(folder: Path, tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(REPRESENTATION.replace(*change))
    with pytest.raises(ValueError, match=message) as caught:
        read_experiment(path)
    assert str(path) in str(caught.value)


def test_no_panorama_to_score_is_said(folder: Path, tmp_path: Path) -> None:
    experiment: Experiment = read_experiment(folder / "a.toml")
    with pytest.raises(ValueError, match="expected panoramas of the splits test"):
        ablate(dataclasses.replace(experiment, splits=("test",)), tmp_path / "x.json")
    with pytest.raises(FileNotFoundError, match="expected a TOML experiment"):
        read_experiment(tmp_path / "none.toml")


def test_representations_hold_what_they_can() -> None:
    """A light that each holds exactly comes back, and numbers are counted as the paper counts."""
    even = torch.full((32, 64, 3), 0.5)
    for representation in (Representation(), Representation("constant"), Representation("sh2", "sh6")):
        torch.testing.assert_close(representation.environment(even), even, rtol=1e-3, atol=1e-3)
    pairs = (("sh2", "anchors"), ("sg9", "anchors"), ("sh2", "sh6"), ("sg9", "sh6"))
    assert [Representation(*pair).numbers for pair in pairs] == [27 + 132, 27 + 132, 27 + 147, 27 + 147]
    with pytest.raises(ValueError, match="constant ambient light around lamps"):
        Representation("sh2", "lamps")
