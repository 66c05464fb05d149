import pytest

from mixlight.app.report import complain, describe


def test_the_file_is_named_once() -> None:
    assert describe(ValueError("a.jpg: expected b"), "a.jpg") == "a.jpg: expected b"
    assert describe(ValueError("expected b"), "a.jpg") == "a.jpg: expected b"
    assert describe(PermissionError(13, "Permission denied", "x/.a.part"), "a.jpg") == (
        "a.jpg: x/.a.part: Permission denied"
    )
    assert describe(OSError(28, "No space left on device"), "a.jpg") == "a.jpg: No space left on device"
    assert describe(MemoryError(), "a.jpg") == "a.jpg: expected enough memory to hold it, received none"
    assert describe(ValueError(), "a.jpg") == "a.jpg: ValueError"


def test_a_complaint_is_one_line_of_bounded_length(capsys: pytest.CaptureFixture[str]) -> None:
    complain("two\nlines")
    complain(ValueError("x" * 5000))
    first, second = capsys.readouterr().err.splitlines()
    assert first == "mixlight: two lines"
    assert len(second) < 500
