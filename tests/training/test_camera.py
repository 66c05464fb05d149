"""The camera's pose, fitted anew to a finished network."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.data.training_set import Batch
from mixlight.network import weights
from mixlight.network.methods import AnyNet, create
from mixlight.network.model import mean_linear_colour
from mixlight.network.settings import ModelSettings
from mixlight.training.camera import fit_camera
from mixlight.training.config import read_config
from mixlight.training.features import FeatureBatch
from mixlight.training.loop import MODEL_FILE, train
from tests.synthetic import CONFIG, write_dataset

pytestmark = pytest.mark.usefixtures("quick")

SOURCES = ("anchors", "lamps")


def network(sources: str = "anchors", seed: int = 0) -> AnyNet:
    torch.manual_seed(seed)
    settings = ModelSettings(
        backbone="tiny", height=64, width=64, hidden=16, grid_channels=4, sources=sources,
        ambient="constant" if sources == "lamps" else "sh2",
    )  # fmt: skip
    return create(settings, pretrained=False).eval()


def views(count: int, pose: Callable[[Tensor], Tensor], seed: int = 0) -> list[Batch]:
    """Random photos whose pose is a function of their mean brightness at the top and at the bottom."""
    generator = torch.Generator().manual_seed(seed)
    batches = []
    for _ in range(count):
        photo = torch.rand(8, 3, 64, 64, generator=generator) * torch.rand(8, 1, 1, 1, generator=generator)
        photo[:, :, :32] *= torch.rand(8, 1, 1, 1, generator=generator)
        levels = torch.stack([photo[:, :, :32].mean((1, 2, 3)), photo[:, :, 32:].mean((1, 2, 3))], 1)
        energy, ambient, small_map = torch.zeros(8, 1, 3), torch.zeros(8, 9, 3), torch.zeros(8, 1, 2, 3)
        batches.append(Batch(photo, energy, ambient, small_map, pose(levels)))
    return batches


def hidden_of(model: AnyNet, batches: list[Batch]) -> np.ndarray:
    with torch.no_grad():
        parts = [model.heads.hidden(model.backbone(b.photo), mean_linear_colour(b.photo)) for b in batches]
    return torch.cat(parts).double().numpy()


@pytest.mark.parametrize("sources", SOURCES)
def test_light_stays_to_the_bit_and_the_pose_gets_better(sources: str) -> None:
    model = network(sources)
    known, new = (views(30, lambda levels: levels - 0.2, seed) for seed in (0, 1))

    def error() -> float:
        with torch.no_grad():
            return float(torch.cat([(model(b.photo).camera - b.camera).abs() for b in new]).mean())

    before, state = error(), {k: v.clone() for k, v in model.state_dict().items()}
    fit_camera(model, known)
    assert error() < 0.6 * before
    after = model.state_dict()
    for name, value in state.items():
        if name.startswith("heads.outputs."):
            assert torch.equal(after[name][:-2], value[:-2])
            assert not torch.equal(after[name][-2:], value[-2:])
        else:
            assert torch.equal(after[name], value), name


def test_against_a_plain_least_squares_solution() -> None:
    """Ridge as ordinary least squares with the penalty as more rows, in NumPy."""
    model, known = network(), views(6, lambda levels: levels.roll(1, 1))
    hidden = hidden_of(model, known)
    pose = torch.cat([batch.camera for batch in known]).double().numpy()
    spread = hidden - hidden.mean(0)
    penalty = np.sqrt(0.1 * (spread**2).sum(0).mean()) * np.eye(hidden.shape[1])
    rows = np.concatenate([spread, penalty])
    expected = np.linalg.lstsq(rows, np.concatenate([pose - pose.mean(0), np.zeros((len(penalty), 2))]))[0]
    fit_camera(model, known)
    last = model.heads.outputs
    np.testing.assert_allclose(last.weight[-2:].detach().numpy().T, expected, atol=2e-6)
    offset = pose.mean(0) - hidden.mean(0) @ expected
    np.testing.assert_allclose(last.bias[-2:].detach().numpy(), offset, atol=2e-6)


def test_a_pose_that_never_changes_is_said_of_every_photo() -> None:
    model, known = network(), views(4, lambda levels: torch.tensor([[0.25, -0.5]]).expand(len(levels), 2))
    fit_camera(model, known)
    camera = model(torch.rand(3, 3, 64, 64)).camera.detach()
    torch.testing.assert_close(camera, torch.tensor([[0.25, -0.5]]).expand(3, 2), rtol=0, atol=1e-5)


def test_features_do_as_well_as_photos_and_one_view_is_enough() -> None:
    known = views(4, lambda levels: levels)
    one, other = network(), network()
    with torch.no_grad():
        banks = [
            FeatureBatch(one.backbone(b.photo), mean_linear_colour(b.photo), b.anchor_energy, b.ambient,
                         b.small_map, b.camera)
            for b in known
        ]  # fmt: skip
    fit_camera(one, known)
    fit_camera(other, banks)
    torch.testing.assert_close(one.heads.outputs.weight, other.heads.outputs.weight)
    single = Batch(*(getattr(known[0], f.name)[:1] for f in dataclasses.fields(Batch)))
    fit_camera(one, [single])
    torch.testing.assert_close(one(single.photo).camera, single.camera, rtol=0, atol=1e-5)


def test_no_view_is_refused() -> None:
    with pytest.raises(ValueError, match="expected views to fit the camera's pose to, got none"):
        fit_camera(network(), [])


def test_a_run_with_camera_views_has_the_light_of_one_without(tmp_path: Path) -> None:
    tiny = CONFIG.replace("[model]", '[model]\nbackbone = "tiny"').replace(
        "workers", 'backbone_weights = "none"\nworkers'
    )
    config = read_config(write_dataset(tmp_path, tiny))
    found = []
    for count in (0, 5):
        out = tmp_path / str(count)
        train(dataclasses.replace(config, camera_views=count), out, cache=tmp_path / "cache")
        found.append(weights.load(out / MODEL_FILE)[0])
    plain, fitted = found
    assert [name for name in plain if not torch.equal(plain[name], fitted[name])] == [
        "heads.outputs.bias", "heads.outputs.weight",
    ]  # fmt: skip
    assert torch.equal(plain["heads.outputs.weight"][:-2], fitted["heads.outputs.weight"][:-2])
