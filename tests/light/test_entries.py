"""Checks of JSON entries that documents and export targets share."""

from pathlib import Path
from typing import Any

import pytest

from mixlight.light import entries


@pytest.mark.parametrize("value", [True, "1", None, float("nan"), float("inf"), 10**400, [1.0]])
def test_what_is_no_finite_number_is_refused(value: Any) -> None:
    with pytest.raises(ValueError, match="intensity: expected a finite number, received"):
        entries.number(value, "intensity")


@pytest.mark.parametrize(
    ("limits", "good", "bad"),
    [
        ({"minimum": 0}, 0, -1e-9),
        ({"above": 0}, 1e-9, 0),
        ({"maximum": 1}, 1, 1.001),
        ({"below": 1}, 0.999, 1),
        ({"above": 0, "below": 2}, 1, 2),
    ],
)
def test_limits(limits: dict[str, float], good: float, bad: float) -> None:
    assert entries.number(good, "x", **limits) == good
    with pytest.raises(ValueError, match=r"x: expected a finite number (of at|above|below).*, received"):
        entries.number(bad, "x", **limits)


def test_a_colour_has_three_parts() -> None:
    assert entries.rgb([1, 2.5, 0], "colour", minimum=0) == [1, 2.5, 0]
    with pytest.raises(ValueError, match="colour: expected a list of 3 entries, received 4"):
        entries.rgb([1, 2, 3, 4], "colour")
    with pytest.raises(ValueError, match=r"colour\[1\]: expected a finite number of at least 0, received -2"):
        entries.rgb([1, -2, 3], "colour", minimum=0)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "Expecting value"),
        (b'{"a": NaN}', "expected finite numbers, received NaN"),
        (b'{"a": -Infinity}', "expected finite numbers, received -Infinity"),
        (b"[" * 100_000, "expected JSON, received endless nesting"),
        (b"\xff\xfe\x00", "expected JSON, received no text"),
    ],
)
def test_what_is_no_json_is_refused_with_the_files_name(
    tmp_path: Path, content: bytes, complaint: str
) -> None:
    path = tmp_path / "light.json"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=f"light.json: .*{complaint}"):
        entries.load(path)


def test_long_values_are_cut_in_complaints() -> None:
    with pytest.raises(ValueError, match=r"^name: expected a text, received \[.{1,60}\.\.\.$"):
        entries.text(list(range(100)), "name")
