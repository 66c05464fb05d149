"""Rooms made on the spot, and a training run small enough for a test."""

from pathlib import Path

import torch
from torch import Tensor

from mixlight.image import radiance
from mixlight.sphere import equirect

CONFIG = """
tables = ["table.csv"]
name = "tiny"
steps = 6
batch_size = 2
validate_every = 3
checkpoint_every = 2
workers = 0
[model]
height = 64
width = 64
[labels]
height = 32
map_height = 16
azimuths = 32
"""


def room(height: int = 64, seed: int = 0) -> Tensor:
    """[height, 2 height, 3]: an uneven surround, a window, a lamp and a candle; radiance to about 200."""
    generator = torch.Generator().manual_seed(seed)
    x, y, z = equirect.pixel_directions(height).unbind(-1)
    warm, cold, lamp = torch.rand(3, 3, generator=generator)
    surround = 0.3 + 0.15 * y[..., None] + 0.1 * x[..., None] * warm - 0.1 * z[..., None] * cold
    panorama = surround * (0.8 + 0.4 * torch.rand(height, 2 * height, 3, generator=generator))
    turn = int(torch.randint(2 * height, (1,), generator=generator))
    panorama[height // 3 : height // 2, height // 2 : height * 3 // 4] += 8 * (0.5 + cold)
    panorama[height // 8 : height // 8 + 2, height : height + 3] += 200 * (0.5 + lamp)
    panorama[height * 5 // 8, height * 7 // 4] += 40 * (0.5 + warm)
    return panorama.roll(turn, 1)


def write_dataset(folder: Path, config: str = CONFIG) -> Path:
    """Two training rooms, one for validation, their table and a config; returns the config's path."""
    rows = ["scene,file,split,category,group"]
    for k, split in enumerate(("train", "train", "val")):
        radiance.write(folder / f"room{k}.hdr", room(seed=k).numpy())
        rows.append(f"room{k},room{k}.hdr,{split},indoor,group{k}")
    (folder / "table.csv").write_text("\n".join(rows) + "\n")
    (folder / "config.toml").write_text(config)
    return folder / "config.toml"
