"""The one table of tolerances: `torch.testing.assert_close(actual, expected, **TOLERANCE[torch.float32])`.

float16 and bfloat16 hold 11 and 8 significant bits, float32 24, float64 53. The entries leave room for sums
over a map of about 10^4 texels. A test that needs more room than this says why beside its number.
"""

from typing import TypedDict

import torch


class Tolerance(TypedDict):
    rtol: float
    atol: float


TOLERANCE: dict[torch.dtype, Tolerance] = {
    torch.float16: {"rtol": 2e-3, "atol": 2e-3},
    torch.bfloat16: {"rtol": 2e-2, "atol": 2e-2},
    torch.float32: {"rtol": 2e-5, "atol": 2e-6},
    torch.float64: {"rtol": 1e-10, "atol": 1e-12},
}
"""Relative and absolute tolerance by dtype."""

HALF_FILE: Tolerance = {"rtol": 1e-3, "atol": 1e-6}
"""What a file of half floats keeps (2^-11 relative, and the smallest subnormals)."""

RGBE_FILE: Tolerance = {"rtol": 1.0 / 128.0, "atol": 1e-6}
"""What a Radiance file keeps of its brightest channel (8 mantissa bits, the top one always set)."""
