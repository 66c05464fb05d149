"""The scanline codings against a literal reading of their description, and against what no encoder writes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mixlight.image import runlength
from mixlight.image.runlength import PADDING, decode, encode


def padded(data: bytes) -> np.ndarray:
    return np.frombuffer(data + bytes(PADDING), np.uint8)


def literal_new(data: bytes, lines: int, width: int) -> np.ndarray:
    """The new coding, byte by byte."""
    pixels, at = np.zeros((lines, width, 4), np.uint8), 0
    for line in range(lines):
        assert data[at : at + 4] == bytes([2, 2, width >> 8, width & 255])
        at += 4
        for component in range(4):
            x = 0
            while x < width:
                code = data[at]
                at += 1
                if code > 128:
                    pixels[line, x : x + code - 128, component] = data[at]
                    at, x = at + 1, x + code - 128
                else:
                    pixels[line, x : x + code, component] = list(data[at : at + code])
                    at, x = at + code, x + code
            assert x == width
    assert at == len(data)
    return pixels


def literal_old(data: bytes, lines: int, width: int) -> np.ndarray:
    """The old coding, pixel by pixel, scanline by scanline."""
    out, at = [], 0
    for _ in range(lines):
        row, shift = [], 0
        while len(row) < width:
            pixel = data[at : at + 4]
            at += 4
            if pixel[:3] == b"\1\1\1":
                row += [row[-1]] * (pixel[3] << shift)
                shift += 8
            else:
                row.append(list(pixel))
                shift = 0
        assert len(row) == width
        out.append(row)
    return np.array(out, np.uint8)


def old_coded(pixels: np.ndarray) -> bytes:
    """Runs as (1, 1, 1, n), with a second and third repeat where they are long."""
    out = b""
    for row in pixels:
        x = 0
        while x < len(row):
            run = 1
            while x + run < len(row) and (row[x + run] == row[x]).all():
                run += 1
            out += row[x].tobytes()
            rest = run - 1
            while rest:
                out += bytes([1, 1, 1, rest & 255])
                rest >>= 8
            x += run
    return out


def patchy(generator: np.random.Generator, lines: int, width: int, run: int) -> np.ndarray:
    """Pixels with runs of about the given length in each component."""
    values = generator.integers(0, 256, (lines, -(-width // run), 4), dtype=np.uint8)
    pixels = values.repeat(run, axis=1)[:, :width]
    noisy = generator.random((lines, width, 4)) < 0.1
    return np.where(noisy, generator.integers(0, 256, pixels.shape, dtype=np.uint8), pixels)


@settings(max_examples=40)
@given(
    st.integers(1, 7),
    st.one_of(st.integers(1, 40), st.sampled_from([127, 128, 129, 255, 256, 300, 514])),
    st.sampled_from([1, 2, 3, 5, 40, 1000]),
    st.integers(0, 2**31),
)
def test_encoding_and_decoding_are_inverse(lines: int, width: int, run: int, seed: int) -> None:
    pixels = patchy(np.random.default_rng(seed), lines, width, run)
    pixels[..., 0] |= 4  # neither a mark nor a repeat in flat lines
    data = encode(pixels)
    np.testing.assert_array_equal(decode(padded(data), 0, lines, width), pixels)
    if width >= 8:
        np.testing.assert_array_equal(literal_new(data, lines, width), pixels)


@settings(max_examples=40)
@given(
    st.integers(1, 6),
    st.sampled_from([1, 2, 7, 8, 30, 300, 700]),
    st.sampled_from([1, 3, 40, 1000]),
    st.integers(0, 2**31),
)
def test_old_coding_as_the_description_reads(lines: int, width: int, run: int, seed: int) -> None:
    pixels = patchy(np.random.default_rng(seed), lines, width, run)
    pixels[..., 1] |= 4
    data = old_coded(pixels)
    np.testing.assert_array_equal(literal_old(data, lines, width), pixels)
    np.testing.assert_array_equal(decode(padded(data), 0, lines, width), pixels)


def test_repeats_in_a_row_count_by_powers_of_256() -> None:
    data = bytes([9, 8, 7, 6]) + bytes([1, 1, 1, 43]) + bytes([1, 1, 1, 1])  # 1 + 43 + 256 = 300
    np.testing.assert_array_equal(decode(padded(data), 0, 1, 300), np.full((1, 300, 4), [9, 8, 7, 6]))
    data = bytes([9, 8, 7, 6]) + bytes([1, 1, 1, 0]) + bytes([1, 1, 1, 1])
    assert decode(padded(data), 0, 1, 257).shape == (1, 257, 4)


@pytest.mark.parametrize("width", [514, 600])
def test_pixels_that_look_like_a_beginning_are_no_beginning(width: int) -> None:
    # 514 = 2 2 in bytes, so a dark picture is full of marks; 600 = 2 88.
    generator = np.random.default_rng(5)
    pixels = generator.choice(np.array([2, 2, 2, 88], np.uint8), (9, width, 4))
    data = encode(pixels)
    np.testing.assert_array_equal(decode(padded(data), 0, 9, width), pixels)
    np.testing.assert_array_equal(literal_new(data, 9, width), pixels)


@settings(max_examples=30)
@given(
    st.integers(1, 9), st.sampled_from([8, 60, 514, 700]), st.sampled_from([1, 3, 40]), st.integers(0, 2**31)
)
def test_walking_abreast_and_in_turn_agree(lines: int, width: int, run: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    pixels = patchy(generator, lines, width, run)
    pixels[generator.random(pixels.shape) < 0.3] = 2
    data = bytearray(encode(pixels))
    if seed % 3 == 0:
        data = data[: int(generator.integers(4, len(data)))]
    if seed % 5 == 0:
        data[int(generator.integers(4, len(data) + 1)) - 1] ^= 255
    results = []
    for few in (0, 10**6):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(runlength, "_FEW_LINES", few)
            try:
                results.append(decode(padded(bytes(data)), 0, lines, width))
            except ValueError as error:
                results.append(str(error))
    np.testing.assert_array_equal(results[0], results[1])


def test_codes_of_other_encoders_are_read() -> None:
    # Runs of one and two, literals of one: legal, though ours writes none of them.
    row = bytes([2, 2, 0, 8])
    component = bytes([129, 5, 130, 6, 1, 7, 4, 1, 2, 3, 4])
    data = row + component * 4
    assert decode(padded(data), 0, 1, 8)[0, :, 2].tolist() == [5, 6, 6, 7, 1, 2, 3, 4]


def test_bytes_behind_the_picture_do_not_matter() -> None:
    pixels = patchy(np.random.default_rng(1), 3, 20, 4)
    np.testing.assert_array_equal(decode(padded(encode(pixels) + b"trailer"), 0, 3, 20), pixels)


@pytest.mark.parametrize("width", [20, 300])
def test_every_truncation_is_an_error(width: int) -> None:
    data = encode(patchy(np.random.default_rng(2), 4, width, 3))
    for length in {*range(0, len(data), max(1, len(data) // 60)), len(data) - 1}:
        with pytest.raises(ValueError, match=r"expected .* received"):
            decode(padded(data[:length]), 0, 4, width)


def test_every_truncation_of_the_old_coding_is_an_error() -> None:
    pixels = patchy(np.random.default_rng(3), 4, 30, 3)
    pixels[..., 1] |= 4
    data = old_coded(pixels)
    for length in range(len(data)):
        with pytest.raises(ValueError, match=r"expected 4 scanlines, received . and a part \(truncated\)"):
            decode(padded(data[:length]), 0, 4, 30)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (bytes([2, 2, 0, 8, 137, 1]) + bytes(60), "scanline 1 of 1, received codes that do not fit"),
        (bytes([2, 2, 0, 8, 0, 1]) + bytes(60), "scanline 1 of 1, received codes that do not fit"),
        (bytes([1, 1, 1, 8]) * 20, "scanline 1 of 1, received a repeat with no pixel before it"),
        (bytes([5, 5, 5, 8]) + bytes([1, 1, 1, 8]), "scanline 1 of 1, received a repeat beyond its end"),
    ],
)
def test_what_no_encoder_writes_is_an_error(data: bytes, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        decode(padded(data), 0, 1, 8)


def test_a_line_without_its_mark_is_named() -> None:
    pixels = patchy(np.random.default_rng(4), 3, 64, 8)
    first, second = (len(encode(pixels[:n])) for n in (1, 2))
    data = bytearray(encode(pixels) + bytes(200))
    data[second] = 3
    with pytest.raises(ValueError, match="scanline 3 of 3, received no mark of its beginning"):
        decode(padded(bytes(data)), 0, 3, 64)
    assert 0 < first < second


def test_any_bytes_give_pixels_or_an_error() -> None:
    generator = np.random.default_rng(6)
    for _ in range(200):
        lines, width = int(generator.integers(1, 4)), int(generator.integers(1, 24))
        noise = generator.integers(0, 256, int(generator.integers(0, 300)), dtype=np.uint8).tobytes()
        data = bytes([2, 2, 0, width]) + noise if generator.random() < 0.7 else noise
        try:
            assert decode(padded(data), 0, lines, width).shape == (lines, width, 4)
        except ValueError as error:
            assert "expected" in str(error)  # noqa: PT017


def test_wide_and_narrow_lines_are_flat() -> None:
    for width in (7, 32768):
        assert len(encode(np.zeros((1, width, 4), np.uint8))) == 4 * width
    assert len(encode(np.zeros((1, 32767, 4), np.uint8))) == 4 + 4 * 2 * 259
    assert runlength.MIN_WIDTH == 8
