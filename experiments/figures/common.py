"""What the figures share: their look, pictures of radiance, spheres, and files of two kinds."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from torch import Tensor

from mixlight.evaluation.renderers import Renderer
from mixlight.image.tonemap import preview

mpl.use("Agg")

IMAGES = Path(__file__).parents[2] / "docs" / "images" / "evaluation"
COLOURS = {"SH": "#4878a8", "SG": "#d98032"}
INK = "#333333"


def parser(what: str | None, name: str) -> argparse.ArgumentParser:
    """Options that every figure has; it is written to `--out` with the suffixes .png and .pdf."""
    arguments = argparse.ArgumentParser(
        description=what, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--out", type=Path, default=IMAGES / name, help="path without suffix")
    return arguments


def save(figure: Figure, out: Path) -> None:
    """Both files; the same figure gives the same bytes."""
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out.with_suffix(".png"), dpi=150, metadata={"Software": None})
    figure.savefig(out.with_suffix(".pdf"), dpi=150, metadata={"CreationDate": None, "Producer": None})
    print(out.with_suffix(".png"), out.with_suffix(".pdf"), sep="\n")


def spheres(renderer: Renderer, light: Tensor) -> Tensor:
    """[height, 3 width, 3]: the three spheres side by side, linear; 1 around them, as paper is white."""
    pictures = renderer.render(light[None].float())[0]
    pictures = torch.where(renderer.mask[..., None], pictures, 1.0)
    return torch.cat(list(pictures), 1)


def picture(linear: Tensor) -> np.ndarray:
    """8-bit sRGB of radiance in the photo's exposure, one tone curve for all methods."""
    return preview(linear.clamp(min=0).numpy())


def show(axes: Axes, image: np.ndarray, title: str = "", note: str = "") -> None:
    """A picture without axes; `title` above, `note` below."""
    axes.imshow(image, interpolation="lanczos")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    if title:
        axes.set_title(title, fontsize=8, color=INK)
    if note:
        axes.set_xlabel(note, fontsize=6.5, color=INK, labelpad=2)


def grid(
    rows: int, columns: int, widths: Sequence[float], size: tuple[float, float]
) -> tuple[Figure, np.ndarray]:
    """A figure of pictures, close together."""
    engine = ConstrainedLayoutEngine(w_pad=0.01, h_pad=0.02, wspace=0.01, hspace=0.01)
    figure = Figure(figsize=size, layout=engine)
    return figure, figure.subplots(rows, columns, squeeze=False, gridspec_kw={"width_ratios": widths})
