"""Methods by name: what they see, what they answer, and what they refuse."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.floors import photo_mean_light, training_mean_light
from mixlight.evaluation.methods import FLOORS, STANDARD, Methods
from mixlight.evaluation.oracles import ORACLES
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.image import exr
from mixlight.light.lighting import Lighting
from mixlight.network import weights
from mixlight.network.estimator import Estimator
from mixlight.network.model import MixLightNet, ModelSettings
from mixlight.sphere import equirect
from tests.synthetic import room

SMALL = replace(PROTOCOLS["M"], azimuths=2, photo_height=96, photo_width=128)


@pytest.fixture
def records(tmp_path: Path) -> list[PanoramaRecord]:
    made = []
    for k, (split, category) in enumerate(
        [("train", "indoor"), ("train", "outdoor"), ("train", "indoor"), ("test", "indoor")]
    ):
        path = tmp_path / f"room{k}.exr"
        exr.write(path, room(32, k).numpy(), {})
        made.append(PanoramaRecord(f"room{k}", path, split, category, f"room{k}"))
    return made


@pytest.fixture
def sample(records: list[PanoramaRecord]) -> EvaluationSample:
    return next(SMALL.samples(records[3]))


def as_map(answer: Tensor | Lighting) -> Tensor:
    return answer.environment(128) if isinstance(answer, Lighting) else answer


def save(path: Path, settings: ModelSettings, **card: object) -> Path:
    with torch.random.fork_rng():
        torch.manual_seed(1)
        network = MixLightNet(settings)
    weights.save(path, network.state_dict(), {"settings": settings.to_card(), "name": "x", **card})
    return path


def test_floors_and_ceilings_answer_with_maps_in_the_photos_exposure(
    records: list[PanoramaRecord], sample: EvaluationSample
) -> None:
    methods = Methods(SMALL, records)
    assert methods.standard == STANDARD
    for name in (*STANDARD, *(f"oracle:{oracle}" for oracle in ORACLES)):
        method = methods.open(name)
        light = as_map(method.answer(sample))
        equirect.check(light)
        assert (method.name, method.kind) == (name, "oracle" if name.startswith("oracle") else "floor")
        assert method.about["is"]
        energy = equirect.integrate(light).sum() / equirect.integrate(sample.environment).sum()
        # Expansions of degree 6 ring, and are clamped at 0, which adds light.
        if method.kind == "oracle" and not name.endswith(("sh6", "shh", "sgh")):
            assert 0.8 < float(energy) < 1.25, name
    torch.testing.assert_close(methods.open("photo-mean").answer(sample), photo_mean_light(sample))


def test_the_training_mean_is_over_indoor_training_panoramas(
    records: list[PanoramaRecord], sample: EvaluationSample
) -> None:
    found = Methods(SMALL, records).open("training-mean").answer(sample)
    expected = training_mean_light(s for k in (0, 2) for s in SMALL.samples(records[k], 8))
    torch.testing.assert_close(found, expected)
    everything = Methods(SMALL, records[1:2]).open("training-mean-geometric").answer(sample)
    expected = training_mean_light(SMALL.samples(records[1], 8), geometric=True)
    torch.testing.assert_close(everything, expected)


def test_without_training_panoramas_there_is_no_training_mean(records: list[PanoramaRecord]) -> None:
    methods = Methods(SMALL, records[3:])
    assert set(STANDARD) - set(methods.standard) == {"training-mean", "training-mean-geometric"}
    with pytest.raises(FileNotFoundError, match="expected panoramas of the split train"):
        methods.open("training-mean")


def test_a_network_answers_as_the_estimator_does(
    records: list[PanoramaRecord], sample: EvaluationSample, tmp_path: Path
) -> None:
    path = save(tmp_path / "ours.safetensors", ModelSettings(), kind="mixlight")
    method = Methods(SMALL, records).open(f"mine={path}")
    assert (method.name, method.kind) == ("mine", "network")
    answer = method.answer(sample)
    assert isinstance(answer, Lighting)
    estimator = Estimator.load(path)
    prediction = estimator.model(sample.photo[None])
    torch.testing.assert_close(answer.ambient, prediction.ambient[0], rtol=1e-3, atol=1e-4)
    assert Methods(SMALL, records).open(str(path)).name == "ours"
    assert method.version("a") == Methods(SMALL, records).open(str(path)).version("b")
    save(path, ModelSettings(hidden=128), kind="mixlight")
    assert method.version("a") != Methods(SMALL, records).open(str(path)).version("a")


def test_a_network_of_another_view_sees_the_photo_through_its_own(
    records: list[PanoramaRecord], tmp_path: Path
) -> None:
    """Protocol S shows 75 degrees: a network for 60 sees the middle of it."""
    wide = next(PROTOCOLS["S"].samples(records[3]))
    path = save(tmp_path / "ours.safetensors", ModelSettings(), kind="mixlight")
    answer = as_map(Methods(PROTOCOLS["S"], records).open(str(path)).answer(wide))
    rim = wide.photo.clone()
    rim[:, :, :20] = 0.0
    assert torch.equal(
        as_map(Methods(PROTOCOLS["S"], records).open(str(path)).answer(replace(wide, photo=rim))), answer
    )


def test_networks_of_other_methods_are_opened_by_their_settings(
    records: list[PanoramaRecord], sample: EvaluationSample, tmp_path: Path
) -> None:
    from mixlight.network.methods import create

    settings = ModelSettings(ambient="constant", sources="lamps")
    network = create(settings)
    path = tmp_path / "few.safetensors"
    weights.save(path, network.state_dict(), {"settings": settings.to_card(), "kind": "variant"})
    light = as_map(Methods(SMALL, records).open(str(path)).answer(sample))
    equirect.check(light)
    assert light.shape == (128, 256, 3)


def test_detail_puts_the_photos_pixels_into_the_map(
    records: list[PanoramaRecord], sample: EvaluationSample
) -> None:
    """With the model in the box: the photo's middle shows in the map's, the energy stays."""
    methods = Methods(SMALL, records)
    plain, detailed = (as_map(methods.open(name).answer(sample)) for name in ("mixlight", "mixlight+detail"))
    difference = (plain - detailed).abs().sum(-1)
    assert float(difference[60:70, 120:136].mean()) > 0
    torch.testing.assert_close(equirect.integrate(plain), equirect.integrate(detailed), rtol=0.02, atol=0)
    names = [methods.open(name).version("a") for name in ("mixlight", "mixlight+detail")]
    assert names[0] != names[1]


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("nonsense", ValueError, "expected a method out of mixlight, .*got 'nonsense'"),
        ("oracle:none", ValueError, "expected an oracle out of top_fraction, .*got 'none'"),
        ("predictions:", ValueError, "expected a method out of"),
        ("predictions:/no/such/folder", FileNotFoundError, "expected a folder of predicted maps"),
        ("none.safetensors", OSError, "none.safetensors"),
        ("mixlight:none", ValueError, "none"),
    ],
)
def test_unknown_methods_are_refused(
    records: list[PanoramaRecord], name: str, error: type[Exception], message: str
) -> None:
    with pytest.raises((error, weights.WeightsError), match=message):
        Methods(SMALL, records).open(name)


def test_weights_without_settings_are_refused(records: list[PanoramaRecord], tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    weights.save(path, {"x": torch.zeros(1)}, {"kind": "other"})
    with pytest.raises(weights.WeightsError, match="expected weights with their settings on the card"):
        Methods(SMALL, records).open(str(path))


def test_every_floor_is_described() -> None:
    assert all(FLOORS.values())
