from pathlib import Path

import numpy as np
import pytest

from mixlight.image import exr, exr_layers

RNG = np.random.default_rng(0)


def test_another_library_finds_the_layers_in_their_window(tmp_path: Path) -> None:
    import OpenImageIO as oiio

    beauty = RNG.uniform(size=(4, 6, 4)).astype(np.float32)
    shadow = -RNG.uniform(size=(4, 6, 3)).astype(np.float32)
    layers = {"beauty": beauty, "shadow": shadow, "mask": beauty[..., 3:]}
    exr_layers.write(
        tmp_path / "a.exr", layers, size=(20, 10), offset=(3, 5), attributes={"comment": "hello"}
    )
    file = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    spec = file.spec()
    assert (spec.full_width, spec.full_height, spec.x, spec.y, spec.width, spec.height) == (
        20,
        10,
        3,
        5,
        6,
        4,
    )
    names = list(spec.channelnames)
    pixels = file.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    for layer, values in layers.items():
        letters = {1: "Y", 3: "RGB", 4: "RGBA"}[values.shape[2]]
        picked = pixels[..., [names.index(f"{layer}.{letter}") for letter in letters]]
        np.testing.assert_array_equal(picked, values)
    assert spec.getattribute("comment") == "hello"


def test_the_nameless_layer_is_the_picture(tmp_path: Path) -> None:
    picture = RNG.uniform(size=(5, 7, 3)).astype(np.float32)
    exr_layers.write(tmp_path / "a.exr", {"": picture})
    np.testing.assert_array_equal(exr.read(tmp_path / "a.exr")[0], picture)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    "layers",
    [
        {},
        {"a": np.zeros((2, 2))},
        {"a": np.zeros((2, 2, 2))},
        {"a": np.zeros((2, 2, 3)), "b": np.zeros((3, 2, 3))},
        {"a": np.full((2, 2, 3), np.nan)},
        {"a": np.zeros((0, 2, 3))},
    ],
)
def test_what_are_no_layers_is_refused(tmp_path: Path, layers: dict[str, np.ndarray]) -> None:
    with pytest.raises(ValueError, match="expected"):
        exr_layers.write(tmp_path / "a.exr", layers)
    assert list(tmp_path.iterdir()) == []
