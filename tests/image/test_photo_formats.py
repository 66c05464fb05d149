"""Every kind of photo that is read, against the samples it was made from and against other readers."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import OpenImageIO as oiio
import pytest
from PIL import Image

from mixlight.image import exr, radiance
from mixlight.image.color import srgb_to_linear
from mixlight.image.ldr import Photo, read_photo, write_png
from tests.image.build import (
    P3_COLORANTS,
    SRGB_COLORANTS,
    SRGB_CURVE,
    encoded,
    gamma_curve,
    icc_bytes,
    png_bytes,
    png_chunk,
    write_oiio,
)

H, W = 24, 40


@pytest.fixture
def samples() -> np.ndarray:
    """[H, W, 4] of 16 bits, smooth enough for JPEG, with a full range of alpha."""
    y, x = np.mgrid[0:H, 0:W] / np.array([H - 1, W - 1]).reshape(2, 1, 1)
    waves = np.stack([x, y, 0.5 + 0.4 * np.sin(4 * x + 3 * y), 1.0 - 0.5 * x], axis=-1)
    return np.rint(waves * 65535).astype(np.uint16)


def expected(samples: np.ndarray) -> np.ndarray:
    """Linear light over black of samples with 1 to 4 channels."""
    values = samples / (np.iinfo(samples.dtype).max if samples.dtype.kind == "u" else 1.0)
    colours = values.shape[-1] - (values.shape[-1] % 2 == 0)
    linear = srgb_to_linear(values[..., :colours]) if samples.dtype.kind == "u" else values[..., :colours]
    if colours < values.shape[-1]:
        linear = linear * values[..., -1:]
    return np.broadcast_to(linear, (*values.shape[:2], 3))


def read(path: Path, data: bytes) -> Photo:
    path.write_bytes(data)
    photo = read_photo(path)
    assert photo.linear.dtype == np.float32
    assert photo.linear.shape == (photo.size[1], photo.size[0], 3)
    return photo


def channels_of(samples: np.ndarray, count: int) -> np.ndarray:
    return samples[..., {1: [0], 2: [0, 3], 3: [0, 1, 2], 4: [0, 1, 2, 3]}[count]]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("depth", [8, 16])
def test_png(tmp_path: Path, samples: np.ndarray, count: int, depth: int) -> None:
    stored = channels_of(samples if depth == 16 else (samples >> 8).astype(np.uint8), count)
    photo = read(tmp_path / "a.png", png_bytes(stored))
    np.testing.assert_allclose(photo.linear, expected(stored), atol=1e-6)
    assert (photo.format, photo.source, photo.bit_depth) == ("PNG", "ldr", depth)
    assert photo.notes == (("alpha composited over black",) if count in (2, 4) else ())


@pytest.mark.parametrize("compression", ["none", "lzw", "zip", "packbits"])
@pytest.mark.parametrize("kind", ["uint8", "uint16", "half", "float", "double"])
@pytest.mark.parametrize("count", [1, 3, 4])
def test_tiff(tmp_path: Path, samples: np.ndarray, compression: str, kind: str, count: int) -> None:
    stored = channels_of(samples, count)
    if kind == "uint8":
        stored = (stored >> 8).astype(np.uint8)
    elif kind != "uint16":
        stored = (stored / 65535 * 3.0).astype(
            {"half": np.float16, "float": np.float32, "double": np.float64}[kind]
        )
        stored[..., 3:] /= 3.0
    written = stored.astype(np.float32) if kind in ("half", "double") else stored
    path = write_oiio(tmp_path / "a.tif", written, kind, compression=compression, oiio__UnassociatedAlpha=1)
    photo = read_photo(path)
    np.testing.assert_allclose(photo.linear, expected(stored), atol=1e-3 if kind == "half" else 1e-6)
    assert photo.format == "TIFF"
    assert (photo.source, photo.bit_depth) == {
        "uint8": ("ldr", 8),
        "uint16": ("ldr", 16),
    }.get(kind, ("hdr", 32))


@pytest.mark.parametrize("kind", ["uint16", "float"])
@pytest.mark.parametrize("predictor", [1, 2, 3])
@pytest.mark.parametrize("layout", ["strips", "tiles", "planes", "tiled planes", "big"])
def test_layouts_of_deep_tiff(
    tmp_path: Path, samples: np.ndarray, kind: str, predictor: int, layout: str
) -> None:
    if predictor == 3 and kind == "uint16":
        predictor = 1
    stored = channels_of(samples, 3)
    if kind == "float":
        stored = (stored / 65535).astype(np.float32)
    attributes = {"compression": "zip", "tiff:Predictor": predictor}
    if "planes" in layout:
        attributes["planarconfig"] = "separate"
    if layout == "strips":
        attributes["tiff:RowsPerStrip"] = 5
    if layout == "big":
        attributes["tiff:bigtiff"] = 1
    path = _write_tiled(tmp_path / "a.tif", stored, kind, 16 if "tile" in layout else 0, attributes)
    np.testing.assert_allclose(read_photo(path).linear, expected(stored), atol=1e-6)
    if kind == "uint16" and layout in ("strips", "tiles"):
        theirs = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., ::-1]
        np.testing.assert_allclose(read_photo(path).linear, expected(theirs), atol=1e-6)


def _write_tiled(
    path: Path, samples: np.ndarray, kind: str, tile: int, attributes: dict[str, object]
) -> Path:
    spec = oiio.ImageSpec(samples.shape[1], samples.shape[0], samples.shape[2], kind)
    spec.tile_width = spec.tile_height = tile
    spec.tile_depth = 1 if tile else 0
    for name, value in attributes.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(samples)), output.geterror()
    output.close()
    return path


def test_big_endian_tiff(tmp_path: Path, samples: np.ndarray) -> None:
    stored = samples[..., :3]
    pixels = stored.astype(">u2").tobytes()
    entries = [
        (256, 4, 1, W),
        (257, 4, 1, H),
        (258, 3, 1, 16 << 16),
        (259, 3, 1, 1 << 16),
        (262, 3, 1, 2 << 16),
        (273, 4, 1, 8),
        (277, 3, 1, 3 << 16),
        (278, 4, 1, H),
        (279, 4, 1, len(pixels)),
    ]
    table = struct.pack(">H", len(entries)) + b"".join(struct.pack(">HHII", *e) for e in entries) + bytes(4)
    data = b"MM\0*" + struct.pack(">I", 8 + len(pixels)) + pixels + table
    np.testing.assert_allclose(read(tmp_path / "a.tif", data).linear, expected(stored), atol=1e-6)


def test_white_is_zero_in_some_grey_tiff(tmp_path: Path, samples: np.ndarray) -> None:
    grey = samples[..., :1]
    path = write_oiio(tmp_path / "a.tif", grey, "uint16", compression="none")
    data = bytearray(path.read_bytes())
    at = data.index(b"\x06\x01\x03\x00\x01\x00\x00\x00\x01\x00")  # photometric interpretation 1
    data[at + 8] = 0
    np.testing.assert_allclose(read(path, bytes(data)).linear, expected(65535 - grey), atol=1e-6)


def test_multiplied_alpha_is_over_black_already(tmp_path: Path, samples: np.ndarray) -> None:
    stored = (samples / 65535).astype(np.float32)
    path = write_oiio(tmp_path / "a.tif", stored, "float")
    np.testing.assert_allclose(read_photo(path).linear, stored[..., :3], atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "mode"),
    [("JPEG", "RGB"), ("JPEG", "L"), ("JPEG", "CMYK"), ("WEBP", "RGB"), ("WEBP", "L"), ("WEBP", "RGBA")],
)
def test_lossy_kinds(tmp_path: Path, samples: np.ndarray, kind: str, mode: str) -> None:
    eight = (samples >> 8).astype(np.uint8)
    image = Image.fromarray(eight if mode == "RGBA" else eight[..., :3]).convert(mode)
    photo = read(tmp_path / "a", encoded(image, kind, quality=97))
    reference = expected(np.asarray(image.convert("RGBA" if mode == "RGBA" else "RGB")))
    assert np.abs(photo.linear - reference).mean() < 0.01
    assert photo.format == {"JPEG": "JPEG", "WEBP": "WebP"}[kind]


@pytest.mark.parametrize("options", [{"progressive": True}, {"subsampling": 0}, {"restart_marker_blocks": 1}])
def test_variants_of_jpeg_are_decoded_as_pillow_does(
    tmp_path: Path, samples: np.ndarray, options: dict[str, object]
) -> None:
    data = encoded((samples[..., :3] >> 8).astype(np.uint8), "JPEG", **options)
    photo = read(tmp_path / "a.jpg", data + b"a trailer, as phones append it")
    theirs = np.asarray(Image.open(tmp_path / "a.jpg"))
    np.testing.assert_allclose(photo.linear, expected(theirs), atol=1e-6)


def test_lossless_webp(tmp_path: Path, samples: np.ndarray) -> None:
    eight = (samples >> 8).astype(np.uint8)
    photo = read(tmp_path / "a.webp", encoded(eight, "WEBP", lossless=True, exact=True))
    np.testing.assert_allclose(photo.linear, expected(eight), atol=1e-6)


@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
@pytest.mark.parametrize("mode", ["1", "P"])
def test_palettes_and_bits(tmp_path: Path, samples: np.ndarray, kind: str, mode: str) -> None:
    image = Image.fromarray((samples[..., :3] >> 8).astype(np.uint8)).convert(mode)
    photo = read(tmp_path / "a", encoded(image, kind))
    np.testing.assert_allclose(photo.linear, expected(np.asarray(image.convert("RGB"))), atol=1e-6)


def test_transparent_colours_are_black(tmp_path: Path, samples: np.ndarray) -> None:
    image = Image.fromarray((samples[..., :3] >> 8).astype(np.uint8)).convert("P")
    index = image.getpixel((3, 3))
    photo = read(tmp_path / "a.png", encoded(image, "PNG", transparency=index))
    assert photo.linear[3, 3].tolist() == [0.0, 0.0, 0.0]
    assert photo.linear.max() > 0.5
    # The same for a colour of 16 bits.
    chunk = png_chunk(b"tRNS", samples[5, 5, :3].astype(">u2").tobytes())
    photo = read(tmp_path / "b.png", png_bytes(samples[..., :3], chunk))
    assert photo.linear[5, 5].tolist() == [0.0, 0.0, 0.0]


def test_linear_files(tmp_path: Path) -> None:
    values = np.exp(np.random.default_rng(0).normal(size=(H, W, 3))).astype(np.float32)
    exr.write(tmp_path / "a.exr", values)
    radiance.write(tmp_path / "a.hdr", values)
    for name, kind, tolerance in (("a.exr", "OpenEXR", 1e-3), ("a.hdr", "Radiance", 1 / 255)):
        photo = read_photo(tmp_path / name)
        error = np.abs(photo.linear - values) / values.max(axis=-1, keepdims=True)
        assert error.max() < tolerance
        assert (photo.format, photo.source, photo.bit_depth, photo.size) == (kind, "hdr", 32, (W, H))
        assert not photo.clipped.any()


def test_the_suffix_does_not_matter(tmp_path: Path, samples: np.ndarray) -> None:
    eight = (samples[..., :3] >> 8).astype(np.uint8)
    assert read(tmp_path / "photo.jpg", encoded(eight, "PNG")).format == "PNG"
    assert read(tmp_path / "no suffix ünïcode", encoded(eight, "JPEG")).format == "JPEG"


def test_several_pictures_in_a_file(tmp_path: Path, samples: np.ndarray) -> None:
    first = Image.fromarray((samples[..., :3] >> 8).astype(np.uint8))
    others = [first.rotate(180), first.rotate(180)]
    for kind in ("TIFF", "PNG", "MPO"):
        photo = read(tmp_path / "a", encoded(first, kind, save_all=True, append_images=others))
        assert np.abs(photo.linear - expected(np.asarray(first))).mean() < 0.02
        assert photo.notes == ("the first of 3 pictures in the file",)


def test_profiles_are_applied_to_8_and_16_bits(tmp_path: Path, samples: np.ndarray) -> None:
    p3 = icc_bytes(P3_COLORANTS, [SRGB_CURVE] * 3, name="Display P3")
    eight = (samples[..., :3] >> 8).astype(np.uint8)
    by_kind = [
        read(tmp_path / "a", encoded(eight, kind, icc_profile=p3, **options))
        for kind, options in (("PNG", {}), ("TIFF", {}), ("WEBP", {"lossless": True}))
    ]
    path = write_oiio(tmp_path / "a.tif", samples[..., :3], "uint16")
    plain = read_photo(path).linear
    deep = read(tmp_path / "b.png", png_bytes(samples[..., :3], _iccp(p3)))
    for photo in (*by_kind, deep):
        assert photo.notes == ("ICC profile Display P3 decoded",)
        np.testing.assert_allclose(photo.linear, deep.linear, atol=0.02)
        assert photo.linear.min() == 0.0
    # Between the spaces saturated colours differ, and greys do not.
    assert np.abs(deep.linear - plain).max() > 0.1
    grey = np.repeat(samples[..., :1], 3, axis=-1)
    np.testing.assert_allclose(
        read(tmp_path / "c.png", png_bytes(grey, _iccp(p3))).linear, expected(grey), atol=1e-3
    )


def _iccp(profile: bytes) -> bytes:
    return png_chunk(b"iCCP", b"profile\0\0" + zlib.compress(profile))


def test_an_srgb_profile_changes_nothing(tmp_path: Path, samples: np.ndarray) -> None:
    eight = (samples[..., :3] >> 8).astype(np.uint8)
    tagged = read(
        tmp_path / "a", encoded(eight, "PNG", icc_profile=icc_bytes(SRGB_COLORANTS, [SRGB_CURVE] * 3))
    )
    np.testing.assert_allclose(tagged.linear, expected(eight), atol=1e-6)


def test_grey_profiles_and_png_gamma(tmp_path: Path, samples: np.ndarray) -> None:
    eight = (samples[..., 0] >> 8).astype(np.uint8)
    profile = icc_bytes(np.eye(3), [gamma_curve(1.5)], space=b"GRAY")
    photo = read(tmp_path / "a", encoded(eight, "PNG", icc_profile=profile))
    np.testing.assert_allclose(photo.linear[..., 1], (eight / 255.0) ** 1.5, atol=1e-6)
    linear = read(
        tmp_path / "b", png_bytes(samples[..., :3], png_chunk(b"gAMA", (100000).to_bytes(4, "big")))
    )
    np.testing.assert_allclose(linear.linear, samples[..., :3] / 65535, atol=1e-6)
    assert linear.notes == ("PNG gamma 1 decoded",)
    usual = read(tmp_path / "c", png_bytes(samples[..., :3], png_chunk(b"gAMA", (45455).to_bytes(4, "big"))))
    np.testing.assert_allclose(usual.linear, expected(samples[..., :3]), atol=1e-6)


def test_tables_go_through_littlecms_and_broken_profiles_are_told(
    tmp_path: Path, samples: np.ndarray
) -> None:
    eight = (samples[..., :3] >> 8).astype(np.uint8)
    for profile in (b"nonsense", icc_bytes(SRGB_COLORANTS, [SRGB_CURVE] * 3, extra=(b"A2B0",))):
        photo = read(tmp_path / "a", encoded(eight, "PNG", icc_profile=profile))
        assert len(photo.notes) == 1
        assert "ICC profile" in photo.notes[0]
        np.testing.assert_allclose(photo.linear, expected(eight), atol=0.02)
    photo = read(
        tmp_path / "b", encoded(Image.fromarray(eight).convert("CMYK"), "JPEG", icc_profile=b"nonsense")
    )
    assert "sRGB assumed" in photo.notes[0]


def test_what_is_clipped(tmp_path: Path) -> None:
    pixels = np.full((20, 20, 3), 200, np.uint8)
    pixels[3, 4] = (10, 255, 10)
    pixels[5, 6] = (253, 253, 253)
    photo = read(tmp_path / "a", encoded(pixels, "PNG"))
    assert np.argwhere(photo.clipped).tolist() == [[3, 4]]


def test_previews_are_written_atomically(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    write_png(tmp_path / "a.png", pixels)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "a.png")), pixels)
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]
    with pytest.raises(FileNotFoundError):
        write_png(tmp_path / "none" / "a.png", pixels)
