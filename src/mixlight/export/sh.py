"""Harmonics as each engine stores them: its axes, signs, scale and layout, and back.

Ours are radiance coefficients L of the basis K poly(x, y, z), all plus (`mixlight.light.harmonics`). An
engine stores, for each index l*l + l + m in its own axes,

    cs * A_hat * K * L      with each of the three factors there or not:

cs the Condon-Shortley sign (1, -1, 1, -1, 1, -1, 1, -1, 1); A_hat = (1, 2/3, 1/4) by degree, the cosine
kernel over pi, so that the sum is what a white matte surface shows; K the basis's own constants, so that the
shader multiplies plain polynomials.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import harmonics
from mixlight.light.document import numbers
from mixlight.light.entries import entries, equal, keys, mapping, number
from mixlight.sphere.frames import FRAMES

__all__ = ["LAYOUTS", "HarmonicsLayout", "from_engine", "read_document", "to_document", "to_engine"]

CONDON_SHORTLEY = (1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0)
"""(-1)^m by index."""

_CONSTANTS = (
    0.28209479177387814,
    0.4886025119029199,
    1.0925484305920792,
    0.31539156525252005,
    0.5462742152960396,
)
"""1 / (2 sqrt pi), sqrt(3 / 4 pi), sqrt(15 / 4 pi), sqrt(5 / 16 pi), sqrt(15 / 16 pi)."""

BASIS_CONSTANTS = tuple(_CONSTANTS[i] for i in (0, 1, 1, 1, 2, 2, 3, 2, 4))
"""K by index: the factors before 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2."""


@dataclass(frozen=True)
class HarmonicsLayout:
    """How an engine stores nine radiance harmonics."""

    engine: str
    """Key in `LAYOUTS`."""
    frame: str
    """Name of the engine's axes in `mixlight.sphere.FRAMES`."""
    layout: Literal["interleaved", "planar"]
    """27 numbers as r g b r g b ... by index, or as 9 red, 9 green, 9 blue."""
    condon_shortley: bool = False
    """Whether the basis carries the sign (-1)^m."""
    prescaled: bool = False
    """Whether A_hat and K are multiplied in, so that the shader sums plain polynomials to E / pi."""

    @property
    def factors(self) -> Float[Tensor, "9"]:
        """What our coefficient in the engine's axes is multiplied by, in float64."""
        total = torch.ones(9, dtype=torch.float64)
        if self.condon_shortley:
            total = total * torch.tensor(CONDON_SHORTLEY, dtype=torch.float64)
        if self.prescaled:
            kernel = harmonics.cosine_kernel(2)[harmonics.degrees(2)] / torch.pi
            total = total * kernel * torch.tensor(BASIS_CONSTANTS, dtype=torch.float64)
        return total

    @property
    def words(self) -> dict[str, Any]:
        """The same in words, for files: never an anonymous list of 27 numbers."""
        return {
            "kind": "irradiance/pi" if self.prescaled else "radiance",
            "basis": (
                "plain polynomials 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2"
                if self.prescaled
                else "real-sh, Condon-Shortley"
                if self.condon_shortley
                else "real-sh"
            ),
            "order": "l*l+l+m",
            "degree": 2,
            "frame": self.frame,
            "layout": self.layout,
        }


LAYOUTS: Mapping[str, HarmonicsLayout] = MappingProxyType(
    {
        layout.engine: layout
        for layout in (
            HarmonicsLayout("mixlight", "mixlight", "interleaved"),
            HarmonicsLayout("three", "mixlight", "interleaved"),
            HarmonicsLayout("webxr", "mixlight", "interleaved"),
            HarmonicsLayout("arcore", "mixlight", "interleaved", condon_shortley=True),
            HarmonicsLayout("arkit", "mixlight", "planar"),
            HarmonicsLayout("filament", "mixlight", "interleaved", prescaled=True),
            HarmonicsLayout("unity", "unity", "planar", prescaled=True),
            HarmonicsLayout("unreal", "unreal", "planar", condon_shortley=True),
        )
    }
)
"""The engines' layouts. "three" is LightProbe, "webxr" XRLightEstimate, "arcore" LightEstimate, "filament"
IndirectLight (cmgen's --sh-shader), "unity" SphericalHarmonicsL2, "unreal" TSHVector<3>. ARKit documents
neither order nor sign nor scale: "arkit" is a guess that its files call one."""


def to_engine(coefficients: Float[Tensor, "*batch 9 3"], engine: str) -> Float[Tensor, "*batch 9 3"]:
    """Our radiance coefficients as the engine's numbers, indexed [index, channel]; exact.

    Args:
        coefficients: radiance harmonics of degree 2 in our frame.
        engine: a name in `LAYOUTS`.

    Convention: radiance 1 all around, L_0 = 3.544908, is 1 in Unity and in Filament, where a white matte
        surface shows what is stored; light from our +X has a negative index 3 in ARCore.

    Raises:
        ValueError: unknown engine, or not nine coefficients.

    >>> ambient = torch.zeros(9, 3)
    >>> ambient[0], ambient[2] = 3.544908, 1.0
    >>> to_engine(ambient, "unity")[:3, 0]
    tensor([ 1.0000,  0.0000, -0.3257])
    """
    layout = _layout(engine)
    _check_count(coefficients)
    turn = FRAMES[layout.frame].matrix(dtype=torch.float64, device=coefficients.device)
    turned = harmonics.rotate(coefficients.double(), turn)
    return (turned * layout.factors.to(turned.device)[:, None]).to(coefficients.dtype)


def from_engine(values: Float[Tensor, "*batch 9 3"], engine: str) -> Float[Tensor, "*batch 9 3"]:
    """Our radiance coefficients from an engine's numbers: the inverse of `to_engine`.

    Raises:
        ValueError: unknown engine, or not nine coefficients.

    >>> from_engine(to_engine(torch.ones(9, 3), "unreal"), "unreal")[:, 0]
    tensor([1., 1., 1., 1., 1., 1., 1., 1., 1.])
    """
    layout = _layout(engine)
    _check_count(values)
    back = FRAMES[layout.frame].matrix(dtype=torch.float64, device=values.device).mT
    plain = values.double() / layout.factors.to(values.device)[:, None]
    return harmonics.rotate(plain, back).to(values.dtype)


def to_document(coefficients: Float[Tensor, "9 3"], engine: str) -> dict[str, Any]:
    """The engine's 27 numbers, in its layout, with the words that say what they are.

    Raises:
        ValueError: unknown engine, or not nine coefficients.

    >>> document = to_document(torch.ones(9, 3), "arcore")
    >>> document["basis"], document["layout"], document["coefficients"][:4]
    ('real-sh, Condon-Shortley', 'interleaved', [1.0, 1.0, 1.0, -1.0])
    """
    values = to_engine(coefficients, engine).float()
    layout = _layout(engine)
    flat = (values.T if layout.layout == "planar" else values).flatten()
    return {**layout.words, "coefficients": numbers(flat)}


def read_document(document: object, engine: str) -> Float[Tensor, "9 3"]:
    """Our radiance coefficients from what `to_document` has made.

    Raises:
        ValueError: the document is none of that engine; the message names the entry.

    >>> read_document(to_document(torch.ones(9, 3), "unity"), "unity")[:3, 0]
    tensor([1., 1., 1.])
    """
    layout = _layout(engine)
    words = mapping(document, "harmonics")
    keys(words, "harmonics", (*layout.words, "coefficients"))
    for key, value in layout.words.items():
        equal(words[key], f"harmonics.{key}", value)
    flat = entries(words["coefficients"], "harmonics.coefficients", 27)
    values = torch.tensor([number(v, f"harmonics.coefficients[{i}]") for i, v in enumerate(flat)])
    shaped = values.view(3, 9).T if layout.layout == "planar" else values.view(9, 3)
    return from_engine(shaped, engine)


def _layout(engine: str) -> HarmonicsLayout:
    if engine not in LAYOUTS:
        raise ValueError(f"expected an engine out of {', '.join(LAYOUTS)}, received {engine!r}")
    return LAYOUTS[engine]


def _check_count(values: Tensor) -> None:
    if values.shape[-2:] != (9, 3):
        raise ValueError(f"expected nine rgb coefficients [..., 9, 3], received shape {tuple(values.shape)}")
