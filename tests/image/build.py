"""Files for the tests of image/, built byte by byte where no library writes what is needed."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from PIL import Image

Array = np.ndarray


def radiance_bytes(pixels: Array, axes: str = "-Y +X", header: str = "FORMAT=32-bit_rle_rgbe\n") -> bytes:
    """A flat Radiance file of stored scanlines [lines, width, 4]."""
    first, second = axes.split()
    lines, width = pixels.shape[:2]
    return f"#?RADIANCE\n{header}\n{first} {lines} {second} {width}\n".encode() + pixels.tobytes()


def random_rgbe(generator: np.random.Generator, height: int, width: int) -> Array:
    """Normalised pixels: the largest mantissa has its top bit set."""
    pixels = generator.integers(0, 256, (height, width, 4), dtype=np.uint8)
    pixels[..., 0] |= 128
    pixels[..., 3] = generator.integers(110, 150, (height, width))
    return pixels


def exif_bytes(order: str = "<", orientation: int | None = None, **details: object) -> bytes:
    """EXIF data; details are the tags below, as (numerator, denominator) where they are rationals."""
    tags = {
        "focal_length": 37386,
        "focal_length_35mm": 41989,
        "width": 40962,
        "height": 40963,
        "plane_x": 41486,
        "plane_y": 41487,
        "plane_unit": 41488,
    }
    main = [] if orientation is None else [(274, 3, orientation)]
    sub = []
    for name, value in details.items():
        sub.append((tags[name], 5 if isinstance(value, tuple) else 3, value))
    start = 8 + 2 + 12 * (len(main) + 1) + 4
    main.append((34665, 4, start))
    return (
        b"Exif\0\0"
        + (b"II*\0" if order == "<" else b"MM\0*")
        + struct.pack(order + "I", 8)
        + _directory(order, main, 8)
        + _directory(order, sub, start)
    )


def _directory(order: str, entries: list[tuple[int, int, object]], at: int) -> bytes:
    tail_at = at + 2 + 12 * len(entries) + 4
    table, tail = struct.pack(order + "H", len(entries)), b""
    for tag, kind, value in sorted(entries):
        if kind == 5:
            place = struct.pack(order + "I", tail_at + len(tail))
            tail += struct.pack(order + "II", *value)
        else:
            place = struct.pack(order + {3: "HH", 4: "I"}[kind], *((value, 0) if kind == 3 else (value,)))
        table += struct.pack(order + "HHI", tag, kind, 1) + place
    return table + bytes(4) + tail


def icc_bytes(
    colorants: Array,
    curves: list[bytes],
    name: str = "test",
    space: bytes = b"RGB ",
    extra: tuple[bytes, ...] = (),
) -> bytes:
    """A matrix profile, or a grey one if there is one curve."""
    text = name.encode()
    tags = {b"desc": b"desc\0\0\0\0" + struct.pack(">I", len(text) + 1) + text + b"\0" + bytes(79)}
    tags[b"wtpt"] = _xyz(np.array([0.9642, 1.0, 0.8249]))
    if len(curves) == 1:
        tags[b"kTRC"] = curves[0]
    else:
        for channel, column, curve in zip(b"rgb", colorants.T, curves, strict=True):
            tags[bytes([channel]) + b"XYZ"] = _xyz(column)
            tags[bytes([channel]) + b"TRC"] = curve
    for tag in extra:
        tags[tag] = b"mft2" + bytes(60)
    table, body = struct.pack(">I", len(tags)), b""
    for tag, value in tags.items():
        table += struct.pack(">4sII", tag, 132 + 12 * len(tags) + len(body), len(value))
        body += value + bytes(-len(value) % 4)
    head = bytearray(128)
    struct.pack_into(">I", head, 0, 128 + len(table) + len(body))
    struct.pack_into(">I4s4s4s", head, 8, 0x02400000, b"mntr", space, b"XYZ ")
    head[36:40] = b"acsp"
    head[68:80] = struct.pack(">3i", *(round(v * 65536) for v in (0.9642, 1.0, 0.8249)))
    return bytes(head) + table + body


def _xyz(values: Array) -> bytes:
    return b"XYZ \0\0\0\0" + struct.pack(">3i", *(round(float(v) * 65536) for v in values))


def gamma_curve(gamma: float) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(gamma * 256)) + bytes(2)


def parametric_curve(kind: int, *parameters: float) -> bytes:
    numbers = (round(p * 65536) for p in parameters)
    return b"para\0\0\0\0" + struct.pack(f">HH{len(parameters)}i", kind, 0, *numbers)


def table_curve(values: Array) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(
        f">I{len(values)}H", len(values), *np.rint(values * 65535).astype(int).tolist()
    )


SRGB_CURVE = parametric_curve(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
SRGB_COLORANTS = np.array(
    [[0.43607, 0.38515, 0.14307], [0.22249, 0.71687, 0.06061], [0.01392, 0.09708, 0.71410]]
)
P3_COLORANTS = np.array(
    [[0.51512, 0.29198, 0.15710], [0.24120, 0.69225, 0.06657], [-0.00105, 0.04189, 0.78407]]
)
ADOBE_COLORANTS = np.array(
    [[0.60974, 0.20528, 0.14919], [0.31111, 0.62567, 0.06322], [0.01947, 0.06087, 0.74457]]
)


def png_chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png_header(width: int, height: int, depth: int = 8, colour: int = 2) -> bytes:
    return b"\x89PNG\r\n\x1a\n" + png_chunk(
        b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    )


def png_bytes(samples: Array, *chunks: bytes) -> bytes:
    """An unfiltered PNG of uint8 or uint16 samples [h, w, 1 to 4], with chunks before the pixels."""
    height, width, channels = samples.shape
    rows = b"".join(b"\0" + row.astype(samples.dtype.newbyteorder(">")).tobytes() for row in samples)
    head = png_header(width, height, 8 * samples.dtype.itemsize, {1: 0, 2: 4, 3: 2, 4: 6}[channels])
    return head + b"".join(chunks) + png_chunk(b"IDAT", zlib.compress(rows)) + png_chunk(b"IEND", b"")


def encoded(image: Array | Image.Image, kind: str, **options: object) -> bytes:
    """A picture in a file format, by Pillow."""
    buffer = io.BytesIO()
    (image if isinstance(image, Image.Image) else Image.fromarray(image)).save(buffer, format=kind, **options)
    return buffer.getvalue()


def write_oiio(path: Path, samples: Array, kind: str, **attributes: object) -> Path:
    """A picture of samples [h, w, c] by OpenImageIO; `kind` is its name for the type, `__` stands for ':'."""
    height, width, channels = samples.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    if channels in (2, 4):
        spec.alpha_channel = channels - 1
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    buffer = oiio.ImageBuf(spec)
    buffer.set_pixels(oiio.ROI(), np.ascontiguousarray(samples))
    assert buffer.write(str(path)), buffer.geterror()
    return path
