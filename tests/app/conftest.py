"""Photos, panoramas and weights small enough to be made on the spot."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mixlight.app.cli import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A weights file that the estimator accepts: an untrained network, the same in every run."""
    import torch

    from mixlight.network import weights
    from mixlight.network.model import MixLightNet, ModelSettings

    settings = ModelSettings()
    with torch.random.fork_rng():
        torch.manual_seed(3)
        network = MixLightNet(settings)
        # A peak at four anchors, so that there are lights to merge, mark and list.
        distribution = torch.zeros(settings.anchors)
        distribution[torch.tensor([20, 28, 60, 61])] = torch.tensor([0.4, 0.3, 0.2, 0.1])
        ambient = torch.zeros(9, 3)
        ambient[0], ambient[1] = 1.5, 0.3
        network.heads.start_from(
            distribution, 0.5, torch.tensor([0.1, 0.0, -0.1]), ambient, torch.tensor([-0.14, 0.02])
        )
    path = tmp_path_factory.mktemp("weights") / "untrained.safetensors"
    card = {"kind": "mixlight", "name": "untrained", "settings": settings.to_card(), "frame": "mixlight"}
    weights.save(path, network.state_dict(), card)
    return path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `mixlight ...` in this process: (exit status, stdout, stderr)."""

    def call(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return call


@pytest.fixture
def small_previews(monkeypatch: pytest.MonkeyPatch) -> None:
    """Previews of a fifth of their size, for tests that look at other things."""
    from mixlight.app import preview

    for name, value in {"SPHERE": 44, "MAP_COLUMNS": 144, "MAP_ROWS": 72, "MARGIN": 8, "GAP": 6}.items():
        monkeypatch.setattr(preview, name, value)


def picture(height: int, width: int) -> np.ndarray:
    """An 8-bit gradient that is brighter at the top and redder at the right."""
    y, x = np.mgrid[0:height, 0:width]
    red, green = 80 + 150 * x / width, 210 - 120 * y / height
    return np.stack([red, green, 0 * x + 90], -1).astype(np.uint8)


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    path = tmp_path / "room.jpg"
    Image.fromarray(picture(120, 160)).save(path, quality=92)
    return path


@pytest.fixture
def panorama(tmp_path: Path) -> Path:
    """64 x 128: dim, warmer below, with a lamp of radiance 50 at the right, a little above the horizon."""
    from mixlight.image import radiance

    rgb = np.full((64, 128, 3), 0.2, np.float32)
    rgb[32:] *= np.array([1.2, 1.0, 0.8], np.float32)
    rgb[24:28, 94:98] = 50.0
    path = tmp_path / "studio.hdr"
    radiance.write(path, rgb)
    return path
