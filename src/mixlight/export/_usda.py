"""The little of USD's text format that our own files use, read without USD.

Not a USD reader: no composition, no time samples, no variants. What it does not know it refuses.
"""

import re
from dataclasses import dataclass, field
from typing import Any, NoReturn

__all__ = ["Layer", "Prim", "identifier", "parse", "quoted"]

_TOKEN = re.compile(
    r"""
    (?P<space>[ \t\r\n;]+|\#[^\n]*)
  | (?P<text>\"\"\"(?:[^\\]|\\.)*?\"\"\"|"(?:[^"\\\n]|\\.)*")
  | (?P<asset>@[^@\n]*@)
  | (?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)
  | (?P<word>[A-Za-z_][A-Za-z0-9_:]*(?:\[\])?)
  | (?P<mark>[(){}\[\]=,])
  | (?P<path><[^>\n]*>)
    """,
    re.VERBOSE | re.DOTALL,
)
_DEPTH = 32


@dataclass
class Prim:
    """One prim: its type and name, its attributes and metadata, and the prims below it."""

    kind: str
    name: str
    metadata: dict[str, Any] = field(default_factory=dict)
    attributes: dict[str, Any] = field(default_factory=dict)
    children: list["Prim"] = field(default_factory=list)


@dataclass
class Layer:
    """A file: its metadata and its root prims."""

    metadata: dict[str, Any]
    prims: list[Prim]


def identifier(name: str) -> str:
    """The nearest name that USD allows for a prim.

    >>> identifier("light 1"), identifier("1")
    ('light_1', '_1')
    """
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"


def quoted(text: str) -> str:
    r"""A text as USD writes it.

    >>> print(quoted('a "b"\n'))
    "a \"b\"\n"
    """
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\r", "\\r")
    return f'"{escaped}"'


def parse(text: str) -> Layer:
    r"""Read a layer.

    Values become str (texts, tokens, assets without their @), float, bool ("true" or "false") or tuples of
    them; dictionaries become dict.

    Raises:
        ValueError: no text of USD, or a part of it that our files do not use; with its line.

    >>> layer = parse('#usda 1.0\n(\n upAxis = "Y"\n)\ndef Xform "a"\n{\n float b = 2\n}\n')
    >>> layer.metadata, layer.prims[0].name, layer.prims[0].attributes
    ({'upAxis': 'Y'}, 'a', {'b': 2.0})
    """
    if not text.startswith("#usda 1.0"):
        raise ValueError(f"expected a file that begins with #usda 1.0, received {text[:12]!r}")
    reader = _Reader(text)
    metadata = reader.metadata()
    prims = []
    while not reader.done():
        prims.append(reader.prim(0))
    return Layer(metadata, prims)


class _Reader:
    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens: list[tuple[str, str, int]] = []
        position = 0
        while position < len(text):
            found = _TOKEN.match(text, position)
            if found is None or found.lastgroup is None:
                line = text.count("\n", 0, position) + 1
                raise ValueError(
                    f"line {line}: expected USD text, received {text[position : position + 12]!r}"
                )
            if found.lastgroup != "space":
                self._tokens.append((found.lastgroup, found.group(), position))
            position = found.end()
        self._next = 0

    def done(self) -> bool:
        return self._next >= len(self._tokens)

    def prim(self, depth: int) -> Prim:
        if depth > _DEPTH:
            self._fail("fewer levels of prims")
        self._take("def")
        kind = self._take() if self._kind() == "word" else ""
        if self._kind() != "text":
            self._fail("the name of a prim")
        found = Prim(kind, self._value(0), self.metadata())
        self._take("{")
        while self._peek() != "}":
            if self._peek() == "def":
                found.children.append(self.prim(depth + 1))
            else:
                name, value = self._assignment(0)
                found.attributes[name] = value
        self._take("}")
        return found

    def metadata(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        if self._peek() != "(":
            return found
        self._take("(")
        while self._peek() != ")":
            if self._kind() == "text":
                found["comment"] = self._value(0)
                continue
            name, value = self._assignment(0)
            found[name] = value
        self._take(")")
        return found

    def _assignment(self, depth: int) -> tuple[str, Any]:
        """[custom] [uniform] [type] name = value [(metadata)]: the last word before "=" is the name."""
        name = ""
        while self._kind() in ("word", "text") and self._peek() != "=":
            text = self._value(0) if self._kind() == "text" else self._take()
            name = text
        if not name:
            self._fail("a name")
        self._take("=")
        value = self._value(depth)
        if depth == 0:
            self.metadata()  # of the attribute
        return name, value

    def _value(self, depth: int) -> Any:
        if depth > _DEPTH:
            self._fail("fewer levels of values")
        kind, text = self._kind(), self._take()
        if kind == "number":
            return float(text)
        if kind == "text":
            width = 3 if text.startswith('"""') else 1
            return re.sub(r"\\(.)", _unescaped, text[width:-width], flags=re.DOTALL)
        if kind == "asset":
            return text[1:-1]
        if kind == "word" and text in ("true", "false"):
            return text == "true"
        if text in ("(", "["):
            close = ")" if text == "(" else "]"
            values = []
            while self._peek() != close:
                values.append(self._value(depth + 1))
                if self._peek() == ",":
                    self._take(",")
            self._take(close)
            return tuple(values)
        if text == "{":
            entries = {}
            while self._peek() != "}":
                name, value = self._assignment(depth + 1)
                entries[name] = value
            self._take("}")
            return entries
        self._next -= 1
        return self._fail("a value")

    def _kind(self) -> str:
        return "" if self.done() else self._tokens[self._next][0]

    def _peek(self) -> str:
        return "" if self.done() else self._tokens[self._next][1]

    def _take(self, expected: str | None = None) -> str:
        if self.done() or (expected is not None and self._peek() != expected):
            self._fail(repr(expected) if expected else "more")
        self._next += 1
        return self._tokens[self._next - 1][1]

    def _fail(self, expected: str) -> NoReturn:
        if self.done():
            raise ValueError(f"expected {expected}, received the end of the file")
        _, text, position = self._tokens[self._next]
        line = self._text.count("\n", 0, position) + 1
        raise ValueError(f"line {line}: expected {expected}, received {text[:40]!r}")


def _unescaped(found: re.Match[str]) -> str:
    return {"n": "\n", "r": "\r", "t": "\t"}.get(found.group(1), found.group(1))
