"""What is installed, and what is told of what is not."""

import json
import os
import stat
from importlib import metadata
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given
from packaging.requirements import Requirement as Reference
from packaging.specifiers import SpecifierSet
from packaging.version import Version

from mixlight.app import health
from mixlight.app.health import Check, Requirement, extras, packages, parse, programs, satisfies


@pytest.mark.parametrize(
    "line",
    [
        "torch<2.14,>=2.11",
        'onnx>=1.18; extra == "onnx"',
        "mixlight[insert,onnx]; extra == 'interop'",
        "tqdm",
        'types-jsonschema>=4.23 ; extra == "dev"',
        "OpenEXR (>=3.3)",
    ],
)
def test_requirements_are_read_as_packaging_reads_them(line: str) -> None:
    ours, theirs = parse(line), Reference(line)
    assert (ours.name, set(ours.wants)) == (theirs.name, theirs.extras)
    assert SpecifierSet(ours.specifier) == theirs.specifier
    assert (ours.extra is None) == (theirs.marker is None)
    if ours.extra is not None:
        assert theirs.marker is not None
        assert theirs.marker.evaluate({"extra": ours.extra})


def test_every_requirement_of_ours_is_understood() -> None:
    for need in health.requirements():
        assert satisfies("1.0", need.specifier) in (True, False)


releases = st.lists(st.integers(0, 30), min_size=1, max_size=4).map(lambda parts: ".".join(map(str, parts)))


@given(version=releases, bound=releases, sign=st.sampled_from([">=", ">", "<=", "<", "==", "!="]))
def test_comparisons_agree_with_packaging(version: str, bound: str, sign: str) -> None:
    assert satisfies(version, sign + bound) == SpecifierSet(sign + bound).contains(Version(version))


@given(version=releases, bound=releases.filter(lambda text: "." in text))
def test_compatible_and_prefix_comparisons_agree_with_packaging(version: str, bound: str) -> None:
    for text in (f"~={bound}", f"=={bound}.*"):
        assert satisfies(version, text) == SpecifierSet(text).contains(Version(version))


def test_a_local_build_counts_as_its_release() -> None:
    assert satisfies("2.13.0+cpu", "==2.13.0")


def test_other_texts_are_no_requirements() -> None:
    with pytest.raises(ValueError, match="expected a comparison"):
        satisfies("1.0", "newer than 2")
    with pytest.raises(ValueError, match="expected a requirement"):
        parse("two words")


def test_missing_old_and_broken_packages_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = [
        Requirement("mixlight-no-such-package", ">=1"),
        Requirement("numpy", ">=99"),
        Requirement("pillow", ""),
        Requirement("safetensors", ">=0.5"),
        Requirement("not-looked-at", "", extra="later"),
    ]

    def load(name: str) -> object:
        if name == "PIL":
            raise OSError("libjpeg.so: cannot open\nsecond line")
        return __import__(name)

    monkeypatch.setattr(health.importlib, "import_module", load)
    missing, old, broken, good = packages(wanted)
    assert (missing.state, missing.command) == ("missing", 'pip install "mixlight-no-such-package>=1"')
    assert old.state == "broken"
    assert old.detail.endswith("expected >=99")
    assert old.command == 'pip install "numpy>=99"'
    assert broken.detail.endswith("which cannot be imported: OSError: libjpeg.so: cannot open")
    assert broken.command == f'pip install --force-reinstall "pillow=={metadata.version("pillow")}"'
    assert (good.state, good.command) == ("ok", None)
    assert [check.fatal for check in (missing, old, broken, good)] == [True, True, True, False]


def test_extras_hold_those_that_they_name() -> None:
    wanted = [
        Requirement("numpy", ">=2", extra="small"),
        Requirement("mixlight", "", ("small", "large"), extra="large"),  # a circle does no harm
        Requirement("mixlight-no-such-package", "", extra="large"),
        Requirement("torch", "", extra=None),
    ]
    large, small = extras(wanted)
    assert (large.name, large.state, large.command) == ("large", "missing", 'pip install "mixlight[large]"')
    assert large.detail == "without mixlight-no-such-package"
    assert (small.state, small.detail) == ("ok", f"numpy {metadata.version('numpy')}")
    assert not large.fatal


@pytest.fixture
def empty_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A PATH with nothing on it but what the test puts there."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    for name in ("MIXLIGHT_CHROMIUM", "MIXLIGHT_BLENDER_PYTHON"):
        monkeypatch.delenv(name, raising=False)
    return tmp_path


def program(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_missing_programs_come_with_commands(empty_path: Path) -> None:
    blender, node, chromium = programs()
    assert {check.state for check in (blender, node, chromium)} == {"missing"}
    assert blender.command is not None
    assert "bpy==" in blender.command
    assert "\n" not in blender.command
    assert (node.command, chromium.command) == ("apt-get install nodejs npm", "apt-get install chromium")
    assert not any(check.fatal for check in (blender, node, chromium))


def test_programs_are_found_by_every_name_and_tell_their_version(empty_path: Path) -> None:
    program(empty_path / "node", "echo v22.1.0")
    program(empty_path / "google-chrome", "echo Google Chrome 140.0.7339.80 stable")
    _, node, chromium = programs()
    assert (node.state, node.detail) == ("ok", f"22.1.0, {empty_path / 'node'}")
    assert chromium.detail == f"140.0.7339.80, {empty_path / 'google-chrome'}"


def test_a_variable_goes_first_and_must_name_a_program(
    empty_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program(empty_path / "chromium", "echo 1.0")
    monkeypatch.setenv("MIXLIGHT_CHROMIUM", str(empty_path / "elsewhere"))
    *_, chromium = programs()
    assert chromium.state == "missing"
    assert chromium.detail.startswith("MIXLIGHT_CHROMIUM names")


def test_programs_that_do_not_run_are_broken(empty_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(empty_path / "node", "exit 3")
    program(empty_path / "chromium", "exec /bin/sleep 30")
    program(empty_path / "python", "echo 'ImportError: libX11.so' >&2; exit 1")
    monkeypatch.setenv("MIXLIGHT_BLENDER_PYTHON", str(empty_path / "python"))
    monkeypatch.setattr(health, "_PATIENCE", 1.0)
    blender, node, chromium = programs()
    assert (node.state, node.detail) == ("broken", f"{empty_path / 'node'} --version: ends with status 3")
    assert chromium.state == "broken"
    assert "timed out" in chromium.detail
    assert blender.state == "broken"


def test_checks_are_json() -> None:
    check = Check("extra", "onnx", "missing", "without onnx", 'pip install "mixlight[onnx]"')
    assert json.loads(json.dumps(check.as_json())) == check.as_json()
    assert "command" not in Check("core", "numpy", "ok", "2.0").as_json()
    assert os.linesep not in check.detail
