"""The reader of our own USD text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.export import _usda

LAYER = """#usda 1.0
# a comment
(
    "a note"
    customLayerData = {
        dictionary outer = {
            int one = 1
            string text = "a \\"b\\" \\\\ c"
            float3[] rows = [(1, 2.5, -3e2), (.5, 0, 1)]
        }
    }
    defaultPrim = "root"
    doc = \"\"\"two
lines\"\"\"
)

def Xform "root" (
    kind = "group"
)
{
    float a = -1.5
    custom uniform token[] names = ["x", "y",]
    asset file = @./a b.exr@ (
        doc = "of the attribute"
    )
    bool on = true
    def Scope "child"
    {
    }
}
def "untyped"
{
}
"""


def test_golden() -> None:
    layer = _usda.parse(LAYER)
    assert layer.metadata["customLayerData"] == {
        "outer": {"one": 1.0, "text": 'a "b" \\ c', "rows": ((1.0, 2.5, -300.0), (0.5, 0.0, 1.0))}
    }
    assert layer.metadata["doc"] == "two\nlines"
    root, other = layer.prims
    assert (root.kind, root.name, root.metadata) == ("Xform", "root", {"kind": "group"})
    assert root.attributes == {"a": -1.5, "names": ("x", "y"), "file": "./a b.exr", "on": True}
    assert [(child.kind, child.name) for child in root.children] == [("Scope", "child")]
    assert (other.kind, other.name) == ("", "untyped")


@given(st.text())
def test_any_text_comes_back(text: str) -> None:
    layer = _usda.parse(f"#usda 1.0\n(\n    doc = {_usda.quoted(text)}\n)\n")
    assert layer.metadata["doc"] == text


@given(st.text())
def test_identifiers_are_ascii_words(name: str) -> None:
    assert _usda.identifier(name).isidentifier()
    assert _usda.identifier(name).isascii()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "expected a file that begins with #usda 1.0"),
        ("PXR-USDC", "expected a file that begins with #usda 1.0"),
        ('#usda 1.0\ndef Xform "a" {', "received the end of the file"),
        ('#usda 1.0\n\nover "a" {}', "line 3: expected 'def', received 'over'"),
        ("#usda 1.0\n(\n a = $\n)", "line 3: expected USD text"),
        ("#usda 1.0\n(\n a = )\n", "line 3: expected a value"),
        ("#usda 1.0\n(\n = 1\n)", "line 3: expected a name"),
        ("#usda 1.0\n(\n a = " + "(" * 60, "fewer levels of values"),
        ("#usda 1.0\n" + 'def "a" {' * 60, "fewer levels of prims"),
        ("#usda 1.0\ndef Xform a {}", "the name of a prim"),
        ('#usda 1.0\n( doc = "open', "expected USD text"),
    ],
)
def test_what_is_refused(text: str, expected: str) -> None:
    with pytest.raises(ValueError) as raised:
        _usda.parse(text)
    assert expected in str(raised.value)


@given(st.text(alphabet='#usda 1.0\n(){}[]=,"@<>defabc', max_size=60))
def test_nothing_but_value_errors(tail: str) -> None:
    try:
        _usda.parse("#usda 1.0\n" + tail)
    except ValueError as error:
        assert "expected" in str(error)  # noqa: PT017
