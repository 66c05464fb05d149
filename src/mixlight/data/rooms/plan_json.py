"""A plan as JSON and back: versioned, complete, and refused where anything is missing or unknown."""

from __future__ import annotations

import dataclasses
import json
import types
from collections.abc import Callable
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from mixlight.data.rooms.plan import VERSION, Plan, Surface

__all__ = [
    "from_document",
    "from_json",
    "plain",
    "read_surface",
    "surface_document",
    "to_document",
    "to_json",
]

FORMAT = "mixlight-room-plan"
_HINTS: dict[type, dict[str, Any]] = {}


def to_document(plan: Plan) -> dict[str, Any]:
    """The plan as plain values that JSON knows, with `format` and `version` in front.

    Raises:
        ValueError: a value that JSON cannot hold, with its place.
    """
    return {"format": FORMAT, **_encode(plan, "plan")}


def to_json(plan: Plan, *, indent: int | None = None) -> str:
    """The plan as JSON text; `from_json` gives the same plan back.

    Raises:
        ValueError: a value that JSON cannot hold (NaN among them), with its place.
    """
    return json.dumps(to_document(plan), indent=indent, allow_nan=False)


def from_document(document: Any) -> Plan:
    """The plan in what `to_document` wrote.

    Raises:
        ValueError: another format or version, a missing or unknown key, a value of another type.
    """
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        found = document.get("format") if isinstance(document, dict) else type(document).__name__
        raise ValueError(f"expected a document of format {FORMAT!r}, got {found!r}")
    if document.get("version") != VERSION:
        raise ValueError(f"expected version {VERSION} of {FORMAT}, got {document.get('version')!r}")
    plan = _decode(Plan, {key: value for key, value in document.items() if key != "format"}, "plan")
    assert isinstance(plan, Plan)
    return plan


def from_json(text: str) -> Plan:
    """The plan in JSON text.

    Raises:
        ValueError: no JSON, or what `from_document` refuses.
    """
    return from_document(json.loads(text))


def surface_document(surface: Surface) -> dict[str, Any]:
    """A surface as plain values, for `Opening.details` and the like.

    >>> surface_document(Surface("paint"))["colour"]
    [0.7, 0.7, 0.7]
    """
    result = _encode(surface, "surface")
    assert isinstance(result, dict)
    return result


def read_surface(document: Any) -> Surface:
    """The surface in what `surface_document` wrote.

    Raises:
        ValueError: a missing or unknown key, or a value of another type.
    """
    surface = _decode(Surface, document, "surface")
    assert isinstance(surface, Surface)
    return surface


def plain(plan: Plan) -> Plan:
    """The same plan with lists for the tuples inside `details` and `parameters`, as JSON gives them back."""
    return from_document(json.loads(json.dumps(to_document(plan), allow_nan=False)))


def _encode(value: Any, place: str) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _encode(getattr(value, field.name), f"{place}.{field.name}")
            for field in dataclasses.fields(value)
        }
    if isinstance(value, dict):
        for key in value:
            if not isinstance(key, str):
                raise ValueError(f"{place}: expected keys that are strings, got {key!r}")
        return {key: _encode(inner, f"{place}.{key}") for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_encode(inner, f"{place}[{i}]") for i, inner in enumerate(value)]
    # Exact types: NumPy's float64 is a float to isinstance, its other numbers are not, and neither is plain.
    if value is None or type(value) in (str, int, float, bool):
        return value
    raise ValueError(f"{place}: expected a plain value, got {value!r} of {type(value).__name__}")


def _decode(hint: Any, value: Any, place: str) -> Any:
    for test, decode in _DECODERS:
        if test(hint):
            return decode(hint, value, place)
    if hint is float and type(value) in (int, float):
        return float(value)
    if hint in (str, int, bool) and type(value) is hint:
        return value
    raise ValueError(f"{place}: expected {getattr(hint, '__name__', hint)}, got {value!r}")


def _decode_dataclass(hint: Any, value: Any, place: str) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"{place}: expected an object, got {type(value).__name__}")
    names = [field.name for field in dataclasses.fields(hint)]
    missing, unknown = [n for n in names if n not in value], [n for n in value if n not in names]
    if missing or unknown:
        raise ValueError(f"{place}: expected the keys {names}; missing {missing}, unknown {unknown}")
    if hint not in _HINTS:
        _HINTS[hint] = get_type_hints(hint)
    hints = _HINTS[hint]
    return hint(**{name: _decode(hints[name], value[name], f"{place}.{name}") for name in names})


def _decode_tuple(hint: Any, value: Any, place: str) -> Any:
    inner = get_args(hint)
    if not isinstance(value, list):
        raise ValueError(f"{place}: expected a list, got {type(value).__name__}")
    if inner[-1] is Ellipsis:
        inner = (inner[0],) * len(value)
    if len(inner) != len(value):
        raise ValueError(f"{place}: expected {len(inner)} values, got {len(value)}")
    return tuple(_decode(h, v, f"{place}[{i}]") for i, (h, v) in enumerate(zip(inner, value, strict=True)))


def _decode_union(hint: Any, value: Any, place: str) -> Any:
    if value is None and type(None) in get_args(hint):
        return None
    (inner,) = [h for h in get_args(hint) if h is not type(None)]
    return _decode(inner, value, place)


def _decode_literal(hint: Any, value: Any, place: str) -> Any:
    if value not in get_args(hint):
        raise ValueError(f"{place}: expected one of {list(get_args(hint))}, got {value!r}")
    return value


def _decode_plain(hint: Any, value: Any, place: str) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"{place}: expected an object, got {type(value).__name__}")
    return value


_DECODERS: tuple[tuple[Callable[[Any], bool], Callable[[Any, Any, str], Any]], ...] = (
    (dataclasses.is_dataclass, _decode_dataclass),
    (lambda hint: get_origin(hint) is tuple, _decode_tuple),
    (lambda hint: get_origin(hint) in (Union, types.UnionType), _decode_union),
    (lambda hint: get_origin(hint) is Literal, _decode_literal),
    (lambda hint: get_origin(hint) is dict, _decode_plain),
)
