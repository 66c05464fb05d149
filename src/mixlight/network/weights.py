"""Network weights on disk: safetensors with a JSON card, read without ever unpickling anything.

A weights file is an ordinary safetensors file whose metadata holds one key, ``mixlight``, with the JSON text
``{"format": "mixlight/weights", "version": 1, "card": {...}}``. The card says what the weights are: name, data,
configuration, metrics, frame, licence. One key, sorted JSON: the same weights and card give the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Shaped
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

FORMAT = "mixlight/weights"
VERSION = 1
ASSETS = Path(__file__).resolve().parent.parent / "assets"

_METADATA_KEY = "mixlight"
_SUFFIX = ".safetensors"
_ZIP, _PICKLE = b"PK\x03\x04", b"\x80"


class WeightsError(ValueError):
    """A weights file is missing, corrupt, foreign, or does not fit the network; the message names the file."""


def names() -> tuple[str, ...]:
    """Names of the weights that ship with the package, sorted.

    >>> "efficientnet_lite0_imagenet" in names()
    True
    """
    return tuple(sorted(path.stem for path in ASSETS.glob(f"*{_SUFFIX}")))


def find(name_or_path: str | Path) -> Path:
    """Path of shipped weights by their name, or of a weights file by its path.

    A plain word is a shipped name (``"default"`` is the model in the box); anything with a folder or a suffix in it
    is a path. To name a file without a suffix in the current folder, write ``./word``.

    Raises:
        WeightsError: unknown name, missing file, or a path that is not a file.

    >>> find("efficientnet_lite0_imagenet").name
    'efficientnet_lite0_imagenet.safetensors'
    """
    text = str(name_or_path)
    path = Path(name_or_path)
    is_name = not isinstance(name_or_path, Path) and text not in ("", ".", "..") and Path(text).name == text
    if is_name and not path.suffix:
        if text in names():
            return ASSETS / f"{text}{_SUFFIX}"
        raise WeightsError(
            f"unknown model {text!r}: expected one of {', '.join(names()) or '(none ships)'}, "
            f"or the path of a {_SUFFIX} file"
        )
    if not path.exists():
        raise WeightsError(f"{text}: expected a weights file, found nothing there")
    if not path.is_file():
        raise WeightsError(f"{text}: expected a weights file, received a directory or special file")
    return path


def save(
    path: str | Path, state: Mapping[str, Shaped[Tensor, "..."]], card: Mapping[str, Any], *, half: bool = False
) -> None:
    """Write tensors and their card to a safetensors file, all or nothing.

    Args:
        path: the file to write; an existing one is replaced only by a complete new one.
        state: name -> tensor, any shapes, as ``module.state_dict()`` gives it.
        card: what the weights are; must be JSON (finite numbers, text keys).
        half: store floating tensors of two or more axes (kernels, matrices) as float16. Vectors, that is biases and
            normalisation statistics, keep their precision: they are few, and a variance may leave float16's range.

    Raises:
        ValueError: a tensor is not finite, or leaves float16's range with ``half``; the card is not JSON.
    """
    tensors: dict[str, Tensor] = {}
    for name, tensor in state.items():
        value = tensor.detach().cpu()
        if half and value.is_floating_point() and value.ndim >= 2:
            value = value.to(torch.float16)
        if value.is_floating_point() and not torch.isfinite(value).all():
            raise ValueError(f"{name}: expected finite values within the range of {value.dtype}, received others")
        # safetensors refuses tensors that share memory or have holes; a clone has neither.
        tensors[name] = value.clone(memory_format=torch.contiguous_format)
    try:
        document = json.dumps(
            {"format": FORMAT, "version": VERSION, "card": dict(card)}, sort_keys=True, allow_nan=False
        )
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected a card that JSON can hold, received one that it cannot: {error}") from error
    from mixlight.image.atomic import atomic_path

    with atomic_path(path) as temporary:
        save_file(tensors, str(temporary), metadata={_METADATA_KEY: document})


def load(path: str | Path) -> tuple[dict[str, Shaped[Tensor, "..."]], dict[str, Any]]:
    """Read a weights file: its tensors on the CPU in their stored dtype, and its card.

    Nothing is unpickled: a pickled checkpoint is refused by name. ``load_into`` converts the dtype as it copies.

    Raises:
        WeightsError: the file is missing, unreadable, corrupt, not safetensors, has no card or one of another
            format or version, or holds a tensor that is not finite.

    >>> state, card = load(find("efficientnet_lite0_imagenet"))
    >>> card["licence"], tuple(state["stem.conv.weight"].shape)
    ('Apache-2.0', (32, 3, 3, 3))
    """
    source = find(Path(path))
    try:
        with source.open("rb") as file:
            start = file.read(4)
    except OSError as error:
        raise WeightsError(f"{source}: expected a readable weights file, received: {error.strerror}") from error
    if not start:
        raise WeightsError(f"{source}: expected a safetensors file, received an empty one")
    if start == _ZIP or (start[:1] == _PICKLE and start[1:2] in b"\x02\x03\x04\x05"):
        raise WeightsError(
            f"{source}: expected a safetensors file, received what looks like a pickled checkpoint, "
            "which could run code and is therefore never opened"
        )
    try:
        with safe_open(str(source), framework="pt", device="cpu") as handle:
            card = _card(source, handle.metadata() or {})
            state = {name: handle.get_tensor(name) for name in handle.keys()}  # noqa: SIM118 (no mapping)
    except SafetensorError as error:
        raise WeightsError(f"{source}: expected a safetensors file, received a corrupt or other one: {error}") from error
    for name, tensor in state.items():
        if tensor.is_floating_point() and not torch.isfinite(tensor).all():
            raise WeightsError(f"{source}: expected finite weights, received NaN or Inf in {name}")
    return state, card


def load_into(module: nn.Module, state: Mapping[str, Shaped[Tensor, "..."]], source: str | Path = "weights") -> None:
    """Copy weights into a module, which must have exactly these names and shapes; dtype and device stay the module's.

    Raises:
        WeightsError: names are missing or left over, or a shape differs; the module is then unchanged.
    """
    own = module.state_dict()
    problems = []
    if missing := sorted(own.keys() - state.keys()):
        problems.append(f"{len(missing)} tensors are missing (first: {missing[0]})")
    if unexpected := sorted(state.keys() - own.keys()):
        problems.append(f"{len(unexpected)} are unknown (first: {unexpected[0]})")
    for name in sorted(own.keys() & state.keys()):
        if own[name].shape != state[name].shape:
            problems.append(f"{name} should be {tuple(own[name].shape)} but is {tuple(state[name].shape)}")
            break
    if problems:
        raise WeightsError(f"{source}: expected the weights of {type(module).__name__}; " + "; ".join(problems))
    module.load_state_dict(dict(state))


def _card(source: Path, metadata: Mapping[str, str]) -> dict[str, Any]:
    if _METADATA_KEY not in metadata:
        raise WeightsError(f"{source}: expected weights with a MixLight card, received a safetensors file without one")
    try:
        document = json.loads(metadata[_METADATA_KEY])
    except json.JSONDecodeError as error:
        raise WeightsError(f"{source}: expected a card in JSON, received text that is not: {error}") from error
    found = (document.get("format"), document.get("version")) if isinstance(document, dict) else (None, None)
    if found != (FORMAT, VERSION) or not isinstance(document.get("card"), dict):
        raise WeightsError(
            f"{source}: expected a card of format {FORMAT!r} version {VERSION}, received format {found[0]!r} "
            f"version {found[1]!r}"
        )
    card: dict[str, Any] = document["card"]
    return card
