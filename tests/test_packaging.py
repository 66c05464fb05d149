"""What a fresh clone relies on: pins, versions that agree, files that ship."""

import os
import re
import tomllib
from importlib import resources
from pathlib import Path

import mixlight

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def _name(requirement: str) -> str:
    """The normalised name of a requirement: what stands before brackets and comparisons."""
    return re.sub(r"[-_.]+", "-", re.split(r"[\[<>=!~; ]", requirement)[0]).lower()


def _pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pairs = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {_name(name): version for name, version in pairs}


def test_everything_that_make_installs_is_pinned() -> None:
    extras = PROJECT["optional-dependencies"]
    wanted = {
        _name(requirement)
        for requirement in [
            *PROJECT["dependencies"],
            *(wanted for name in ("test", "dev", "insert", "onnx", "interop") for wanted in extras[name]),
        ]
    }
    assert wanted - {"mixlight"} <= set(_pins())
    assert _pins()["torch"] == "2.13.0", "exactly, so that pip takes the CPU build where one is offered"


def test_pins_name_versions_and_no_hosts() -> None:
    assert all(re.fullmatch(r"[0-9][0-9a-z.]*", version) for version in _pins().values())


def test_an_unconstrained_install_stays_on_tested_torch_releases() -> None:
    (torch,) = (requirement for requirement in PROJECT["dependencies"] if _name(requirement) == "torch")
    assert torch == "torch>=2.11,<2.14"


def test_the_version_is_the_same_everywhere() -> None:
    assert PROJECT["dynamic"] == ["version"]
    assert f"version: {mixlight.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## [{mixlight.__version__}]" in (ROOT / "CHANGELOG.md").read_text()


def test_package_data_is_where_the_package_looks_for_it() -> None:
    package = resources.files("mixlight")
    assert package.joinpath("py.typed").is_file()
    assert package.joinpath("light/lighting.schema.json").is_file()
    names = {entry.name for entry in package.joinpath("assets").iterdir()}
    weights = {name for name in names if name.endswith(".safetensors")}
    assert weights
    assert sum((Path(str(package)) / "assets" / name).stat().st_size for name in weights) <= 20e6
    assert any(entry.name.endswith(".jpg") for entry in package.joinpath("assets/examples").iterdir())


def test_ci_runs_what_a_developer_runs() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert "make test\n" in script.read_text()
    assert "make test-interop\n" in script.read_text()


def test_what_runs_in_other_programs_ships() -> None:
    export = resources.files("mixlight").joinpath("export")
    for name in (
        "unity_files/MixLightImport.cs",
        "unreal_files/open_in_unreal.py",
        "webxr_files/light_estimate.js",
    ):
        assert export.joinpath(name).is_file()
