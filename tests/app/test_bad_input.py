"""Every bad photo of the acceptance list in one call of the real command, in a process of its own."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.app.conftest import Run, picture


def _raw_exr(path: Path, value: float) -> None:
    import OpenEXR

    pixels = np.full((64, 96, 3), 0.5, np.float32)
    pixels[3, 4, 1] = value
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": pixels}).write(str(path))


def _make_bad_photos(folder: Path, good: Path) -> list[str]:
    (folder / "folder.jpg").mkdir()
    (folder / "empty.jpg").touch()
    (folder / "cut.jpg").write_bytes(good.read_bytes()[:1500])
    (folder / "text.jpg").write_text("this is no photo\n" * 40)
    Image.fromarray(picture(1, 1)).save(folder / "dot.png")
    Image.fromarray(np.zeros((2000, 3000), np.uint8)).save(folder / "bomb.png")
    Image.fromarray(np.zeros((80, 100, 3), np.uint8)).save(folder / "black.png")
    _raw_exr(folder / "nan.exr", np.nan)
    _raw_exr(folder / "inf.exr", np.inf)
    _raw_exr(folder / "negative.exr", -0.5)
    return [
        "missing.jpg", "folder.jpg", "empty.jpg", "cut.jpg", "text.jpg", "dot.png", "bomb.png", "black.png",
        "nan.exr", "inf.exr", "negative.exr",
    ]  # fmt: skip


def test_each_bad_photo_ends_in_one_line_and_the_good_ones_are_done(
    photo: Path, model: Path, tmp_path: Path
) -> None:
    bad = _make_bad_photos(tmp_path, photo)
    Image.fromarray(picture(70, 90)).save(tmp_path / "last.png")
    out = tmp_path / "out"
    done = subprocess.run(
        [
            sys.executable, "-m", "mixlight.app.cli", "estimate", photo, *(tmp_path / name for name in bad),
            tmp_path / "last.png", "--out", out, "--model", model, "--json", "--max-megapixels", "5",
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    said = done.stderr.splitlines()
    assert len(said) == len(bad) + 1, done.stderr
    for name, line in zip(bad, said, strict=False):
        assert line.startswith(f"mixlight: {tmp_path / name}: ")
        assert "Traceback" not in line
    assert said[-1] == f"mixlight: {len(bad)} of {len(bad) + 2} inputs failed"
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [line["ok"] for line in lines] == [True, *[False] * len(bad), True]
    assert sorted(p.name for p in out.iterdir()) == ["last", "room"]
    assert len(list((out / "last").iterdir())) == 4
    with Image.open(out / "room" / "preview.png") as shown:
        assert shown.width > 1500


def _foreign_weights(folder: Path) -> dict[str, Path]:
    import pickle

    import torch
    from safetensors.torch import save_file

    paths = {
        name: folder / name for name in ("pickle.pt", "corrupt.safetensors", "foreign.safetensors", "empty")
    }
    torch.save({"weight": torch.zeros(3)}, paths["pickle.pt"])
    (folder / "raw.pickle").write_bytes(pickle.dumps([1, 2]))
    paths["raw.pickle"] = folder / "raw.pickle"
    paths["corrupt.safetensors"].write_bytes(b"\x10\x00\x00\x00\x00\x00\x00\x00not a header at all")
    save_file({"weight": torch.zeros(3)}, paths["foreign.safetensors"])
    paths["empty"].touch()
    return paths


def test_a_model_that_cannot_be_is_said_once_and_before_any_photo(
    run: Run, photo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pickle

    def never(*_: object, **__: object) -> object:
        raise AssertionError("something was unpickled")

    paths = _foreign_weights(tmp_path)
    monkeypatch.setattr(pickle, "load", never)
    monkeypatch.setattr(pickle, "loads", never)
    for name in ("no-such-model", tmp_path / "missing.safetensors", tmp_path, *paths.values()):
        status, out, err = run("estimate", photo, photo, "--model", name, "--out", tmp_path / "out")
        assert (status, out) == (2, ""), err
        assert err.startswith("mixlight: --model: ")
        assert str(name) in err
        assert err.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_an_unwritable_output_folder_is_said_once_and_before_any_work(
    run: Run, photo: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("mine")
    for bad in (tmp_path / "file", tmp_path / "file" / "below"):
        for verb in ("estimate", "fit"):
            status, out, err = run(verb, photo, photo, "--out", bad)
            assert (status, out) == (2, "")
            assert err.startswith(f"mixlight: --out {bad}: expected a folder")
            assert err.count("\n") == 1
    assert (tmp_path / "file").read_text() == "mine"
