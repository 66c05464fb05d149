"""Network weights on disk: safetensors with a JSON card, read without ever unpickling anything.

A weights file is an ordinary safetensors file whose metadata holds one key, `mixlight`, with the JSON text
`{"format": "mixlight/weights", "version": 1, "card": {...}}`. The card says what the weights are: name, data,
configuration, metrics, frame, licence. One key and sorted JSON: equal weights and cards give equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor, nn

from mixlight.image.atomic import atomic_path

__all__ = ["ASSETS", "FORMAT", "VERSION", "WeightsError", "find", "load", "load_into", "names", "save"]

FORMAT = "mixlight/weights"
VERSION = 1

ASSETS = Path(__file__).resolve().parent.parent / "assets"
"""Where the weights lie that ship with the package."""

_KEY = "mixlight"
_SUFFIX = ".safetensors"
_PICKLES = (b"PK\x03\x04", b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05")
"""How pickles begin: in torch's zip, and bare with their protocol."""


class WeightsError(ValueError):
    """A weights file is missing, corrupt or foreign, or does not fit the network; the message names it."""


def names() -> tuple[str, ...]:
    """Names of the weights that ship with the package, sorted.

    >>> "efficientnet_lite0_imagenet" in names()
    True
    """
    return tuple(sorted(path.stem for path in ASSETS.glob(f"*{_SUFFIX}")))


def find(name_or_path: str | Path) -> Path:
    """Path of shipped weights by their name, or of a weights file by its path.

    A plain word is a shipped name (`"default"` is the model in the box); what has a folder or a suffix in it
    is a path, and so is every `Path`. To name a file without a suffix in the current folder, write `./word`.

    Raises:
        WeightsError: unknown name, missing file, or a path that is not a file.

    >>> find("efficientnet_lite0_imagenet").name
    'efficientnet_lite0_imagenet.safetensors'
    """
    text, path = str(name_or_path), Path(name_or_path)
    if isinstance(name_or_path, str) and text == path.name and not path.suffix:
        if text in names():
            return ASSETS / f"{text}{_SUFFIX}"
        raise WeightsError(
            f"unknown model {text!r}: expected the path of a {_SUFFIX} file, or a name out of "
            f"{', '.join(names()) or '(none ships)'}"
        )
    if not path.exists():
        raise WeightsError(f"{text}: expected a weights file, found nothing there")
    if not path.is_file():
        raise WeightsError(f"{text}: expected a weights file, received a folder or a special file")
    return path


def save(
    path: str | Path, state: Mapping[str, Tensor], card: Mapping[str, Any], *, half: bool = False
) -> None:
    """Write tensors and their card to a safetensors file, all or nothing.

    Args:
        path: The file to write; an existing one is replaced only by a complete new one.
        state: Name to tensor, of any shapes, as `module.state_dict()` gives it.
        card: What the weights are. It must be JSON: finite numbers, text for keys.
        half: Store floating-point tensors of two or more axes (kernels, matrices) as float16. Vectors
            (biases, normalisation statistics) keep their precision: they are few, and a variance may leave
            float16's range.

    Raises:
        ValueError: a tensor is not finite or leaves float16's range with `half`, or the card is not JSON.
        OSError: the folder is missing or not writable.
    """
    tensors: dict[str, Tensor] = {}
    for name, tensor in state.items():
        value = tensor.detach().cpu()
        if half and value.is_floating_point() and value.ndim >= 2:
            value = value.to(torch.float16)
        if value.is_floating_point() and not torch.isfinite(value).all():
            raise ValueError(f"{name}: expected finite values in the range of {value.dtype}, received others")
        # safetensors refuses tensors that share memory or have gaps; a clone has neither.
        tensors[name] = value.clone(memory_format=torch.contiguous_format)
    document = {"format": FORMAT, "version": VERSION, "card": dict(card)}
    try:
        text = json.dumps(document, sort_keys=True, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"expected a card that JSON can hold, received one that it cannot: {error}"
        ) from error
    with atomic_path(path) as temporary:
        temporary.write_bytes(to_bytes(tensors, metadata={_KEY: text}))


def load(path: str | Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Read a weights file: its tensors, on the CPU and in their stored dtype, and its card.

    Nothing is unpickled: a pickled checkpoint is refused and told so. `load_into` converts the dtype.

    Raises:
        WeightsError: the file is missing, unreadable, corrupt or not safetensors, has no card or one of
            another format or version, or holds a tensor that is not finite.

    >>> state, card = load(find("efficientnet_lite0_imagenet"))
    >>> card["licence"], tuple(state["stem.conv.weight"].shape)
    ('Apache-2.0', (32, 3, 3, 3))
    """
    source = find(Path(path))
    try:
        with source.open("rb") as file:
            start = file.read(4)
    except OSError as error:
        raise WeightsError(f"{source}: expected a readable weights file: {error.strerror}") from error
    if not start:
        raise WeightsError(f"{source}: expected a safetensors file, received an empty one")
    if start.startswith(_PICKLES):
        raise WeightsError(
            f"{source}: expected a safetensors file, received what looks like a pickled checkpoint, which "
            "could run code and is therefore never opened"
        )
    try:
        with safe_open(str(source), framework="pt", device="cpu") as handle:
            card = _card(source, handle.metadata() or {})
            state = {name: handle.get_tensor(name) for name in sorted(handle.keys())}
    except SafetensorError as error:
        raise WeightsError(
            f"{source}: expected a safetensors file, received a corrupt one: {error}"
        ) from error
    for name, tensor in state.items():
        if tensor.is_floating_point() and not torch.isfinite(tensor).all():
            raise WeightsError(f"{source}: expected finite weights, received NaN or Inf in {name}")
    return state, card


def load_into(module: nn.Module, state: Mapping[str, Tensor], source: str | Path = "weights") -> None:
    """Copy weights into a module that has exactly these names and shapes; its dtypes and devices stay.

    Raises:
        WeightsError: names are missing or left over, or a shape differs; the module is then unchanged. The
            message begins with `source`.
    """
    own = module.state_dict()
    problems = []
    if missing := sorted(own.keys() - state.keys()):
        problems.append(f"{len(missing)} missing (first: {missing[0]})")
    if unknown := sorted(state.keys() - own.keys()):
        problems.append(f"{len(unknown)} unknown (first: {unknown[0]})")
    if misshapen := sorted(k for k in own.keys() & state.keys() if own[k].shape != state[k].shape):
        name = misshapen[0]
        problems.append(
            f"{len(misshapen)} of another shape (first: {name}, expected {list(own[name].shape)}, "
            f"received {list(state[name].shape)})"
        )
    if problems:
        raise WeightsError(
            f"{source}: expected the weights of {type(module).__name__}, received tensors of which "
            + ", ".join(problems)
        )
    module.load_state_dict(dict(state))


def _card(source: Path, metadata: Mapping[str, str]) -> dict[str, Any]:
    if _KEY not in metadata:
        raise WeightsError(f"{source}: expected weights with a MixLight card, received none in this file")
    try:
        document = json.loads(metadata[_KEY])
    except json.JSONDecodeError as error:
        raise WeightsError(f"{source}: expected a card in JSON, received other text: {error}") from error
    found = (document.get("format"), document.get("version")) if isinstance(document, dict) else (None, None)
    if found != (FORMAT, VERSION):
        raise WeightsError(
            f"{source}: expected a card of format {FORMAT!r} version {VERSION}, received format {found[0]!r} "
            f"version {found[1]!r}"
        )
    card = document.get("card")
    if not isinstance(card, dict):
        raise WeightsError(f"{source}: expected a card that is a JSON object, received {type(card).__name__}")
    return card
