"""The plot of a comparison: the same picture every time, and a clear word where matplotlib is missing."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mixlight.data.rooms import stats_plot
from mixlight.data.rooms.stats import RoomStatistics, read_reference


def rooms(count: int, shift: float = 0.0) -> list[RoomStatistics]:
    generator = np.random.default_rng(1)
    spread = np.array([0.6, 0.15, 0.1, 15, 0.2, 0.2, 8])
    middle = np.array([2.9, 0.7, 0.7, 20, 1.1, 0.95 + shift, 33])
    return [RoomStatistics(*row) for row in middle + spread * generator.standard_normal((count, 7))]


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB")).astype(int)


def test_a_picture_that_differs_where_the_rooms_do(tmp_path: Path) -> None:
    reference = read_reference()
    paths = [tmp_path / f"{k}.png" for k in range(3)]
    for path, measured in zip(paths, (rooms(30), rooms(30), rooms(30, -0.5)), strict=True):
        stats_plot.draw(measured, reference, path)
    first, again, other = (pixels(path) for path in paths)
    assert first.shape[0] > 700
    assert first.shape[1] > 900
    assert (first == again).all()
    changed = np.flatnonzero((first != other).any((1, 2)))
    # Contrast is the sixth of seven strips, and nothing else was changed.
    assert changed.min() > 0.6 * len(first)
    assert changed.max() < 0.9 * len(first)
    assert not list(tmp_path.glob(".*"))


def test_one_room_and_no_spread_can_be_drawn(tmp_path: Path) -> None:
    one = RoomStatistics(2.0, 0.5, 0.5, 0.0, 1.0, 0.5, 10.0)
    stats_plot.draw([one], read_reference(), tmp_path / "one.png")
    assert (tmp_path / "one.png").stat().st_size > 5000


def test_without_matplotlib_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stats_plot, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r'pip install "mixlight\[figures\]"'):
        stats_plot.draw(rooms(3), read_reference(), tmp_path / "no.png")
    assert not list(tmp_path.iterdir())


def test_matplotlib_is_not_imported_before_something_is_drawn() -> None:
    code = "import sys, mixlight.data.rooms.stats_plot; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
