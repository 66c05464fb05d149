"""`mixlight rooms`: the set on disk, what is said about it, and calls that cannot be; without Blender."""

import functools
import json
import sys
from pathlib import Path
from typing import Any

import pytest

from mixlight.blender import program
from mixlight.data.panoramas import read_table
from mixlight.data.rooms import render
from mixlight.data.rooms.plan import Plan
from tests.app.conftest import Run
from tests.data.rooms.boxes import plain_plan

STAND_IN = Path(__file__).parents[1] / "data" / "rooms" / "stand_in.py"
SMALL = ("--width", 64, "--samples", 1, "--cameras", 1, "--no-library")


@pytest.fixture(autouse=True)
def _stand_in(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Plain rooms, and a script in Blender's place."""

    def plan(seed: int, *, cameras: int = 1, **_: Any) -> Plan:
        return plain_plan(seed, cameras)

    monkeypatch.setattr(render, "make_plan", plan)
    monkeypatch.setattr(render, "build", functools.partial(render.build, sky_height=16))
    stand_in = functools.partial(render.render_rooms, script=STAND_IN, threads=1)
    monkeypatch.setattr(render, "render_rooms", stand_in)
    monkeypatch.setenv(program.VARIABLE, sys.executable)
    monkeypatch.setenv("TROUBLES", json.dumps({"room-00002": "error"}))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def test_a_set(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "deep" / "set"
    status, said, err = run("rooms", "--count", 2, "--out", out, *SMALL)
    assert (status, err) == (0, "")
    assert said.startswith(f"2 rooms -> {out}/, ")
    assert said.rstrip().endswith("an hour")
    assert [r.scene for r in read_table(out / "rooms.csv")] == ["room-00000-camera-0", "room-00001-camera-0"]
    assert (out / "ATTRIBUTION.txt").is_file()
    status, said, _ = run("rooms", "--count", 2, "--out", out, *SMALL)
    assert (status, said) == (0, f"0 rooms -> {out}/, 2 were there already\n")


def test_a_bad_room_is_named_and_left_out(run: Run, tmp_path: Path) -> None:
    status, said, err = run("rooms", "--count", 3, "--seed", 1, "--out", tmp_path / "set", *SMALL)
    assert status == 1
    assert said.startswith("2 rooms -> ")
    assert err.splitlines() == [
        "mixlight: room 2: ValueError: no such shader",
        "mixlight: 1 of 3 rooms failed and are left out: 2",
    ]


def test_json_has_a_line_for_every_room(run: Run, tmp_path: Path) -> None:
    status, said, _ = run("rooms", "--count", 2, "--seed", 1, "--out", tmp_path / "set", "--json", *SMALL)
    lines = {line["seed"]: line for line in map(json.loads, said.splitlines())}
    assert status == 1
    assert lines[1]["ok"] is True
    assert lines[1]["panoramas"] == 1
    assert {"plan", "files", "build", "render", "denoise", "pack"} == lines[1]["seconds"].keys()
    assert lines[2] == {"seed": 2, "ok": False, "error": "ValueError: no such shader"}


def test_a_set_of_another_kind(run: Run, tmp_path: Path) -> None:
    run("rooms", "--count", 1, "--out", tmp_path / "set", *SMALL)
    status, said, err = run("rooms", "--count", 2, "--out", tmp_path / "set", *SMALL, "--samples", 2)
    assert (status, said) == (1, "")
    assert "holds rooms made with samples 1, expected 2; make them alike, or give another --out" in err
    assert len(err.splitlines()) == 1


def test_a_lossless_set(run: Run, tmp_path: Path) -> None:
    import OpenEXR

    found = {}
    for name, options in {"lossy": (), "whole": ("--lossless",)}.items():
        assert run("rooms", "--count", 1, "--out", tmp_path / name, *SMALL, *options)[0] == 0
        with OpenEXR.File(str(tmp_path / name / "room-00000" / "camera-0.exr")) as file:
            found[name] = {part.header["compression"] for part in file.parts if part.name() != "depth"}
    assert found == {"lossy": {OpenEXR.DWAB_COMPRESSION}, "whole": {OpenEXR.ZIP_COMPRESSION}}
    for name, options in {"lossy": ("--lossless",), "whole": ()}.items():
        status, _, err = run("rooms", "--count", 2, "--out", tmp_path / name, *SMALL, *options)
        assert status == 1
        assert "holds rooms made with lossless" in err


def test_without_blender_nothing_is_begun(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(program.VARIABLE, str(tmp_path / "none"))
    status, said, err = run("rooms", "--count", 1, "--out", tmp_path / "set", *SMALL)
    assert (status, said) == (1, "")
    assert "expected Blender, received none" in err
    assert "python3.11 -m venv" in err
    assert not (tmp_path / "set").exists()


def test_without_the_library_that_was_named(run: Run, tmp_path: Path) -> None:
    status, _, err = run("rooms", "--count", 1, "--out", tmp_path / "set", "--library", tmp_path / "none")
    assert status == 1
    assert "run `mixlight rooms assets`" in err
    assert not (tmp_path / "set").exists()


def test_without_the_skies_that_were_named(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "skies.csv"
    status, _, err = run("rooms", "--count", 1, "--out", tmp_path / "set", "--skies", table, *SMALL)
    assert status == 1
    assert str(table) in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "rooms: expected --count, or an action: assets, preview, sheet, stats"),
        (("--count", 3), "rooms: expected --out"),
        (("--count", 0, "--out", "x"), "argument --count: expected a whole number from 1 to 1000000"),
        (("--count", 1, "--out", "x", "--jobs", "two"), "argument --jobs: expected a whole number"),
        (("--count", 1, "--out", "x", "--library", "y", "--no-library"), "received both"),
        (("--cuont",), "unrecognized arguments: --cuont"),
        (("tidy",), "invalid choice: 'tidy'"),
        (("preview", 1, "room.jpg"), "expected a name that ends in .png"),
        (("preview", "x", "room.png"), "expected a whole number from 0 to 1000000000"),
        (("preview", 1, "room.png", "--width", 8), "expected a whole number from 16 to 8192"),
        (("preview", 1, "room.png", "--library", "y", "--no-library"), "received both"),
    ],
)
def test_calls_that_cannot_be(run: Run, arguments: tuple[object, ...], said: str) -> None:
    status, out, err = run("rooms", *arguments)
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_a_width_that_cannot_be(run: Run, tmp_path: Path) -> None:
    status, _, err = run("rooms", "--count", 1, "--out", tmp_path / "set", "--width", 66)
    assert status == 1
    assert "width: expected a multiple of 4 from 16 on, received 66" in err
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    ("options", "passed"), [(("--no-library",), None), (("--library", "here"), "here"), ((), "found")]
)
def test_furniture_of_the_preview(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    passed: str | None,
) -> None:
    from mixlight.data.rooms import make_plan
    from mixlight.data.rooms.catalogue import Catalogue

    asked: list[object] = []

    def no_plan(seed: int, *, library: object, **_: object) -> None:
        asked.append(library)
        raise ValueError("no plan")

    monkeypatch.setattr(make_plan, "make_plan", no_plan)
    monkeypatch.setattr(Catalogue, "find", lambda: "found")
    monkeypatch.setattr(Catalogue, "load", str)
    status, _, err = run("rooms", "preview", 5, tmp_path / "a.png", *options)
    assert (status, err) == (1, "mixlight: no plan\n")
    assert asked == [passed]


def test_a_preview_without_the_library_that_was_named(run: Run, tmp_path: Path) -> None:
    status, _, err = run("rooms", "preview", 5, tmp_path / "a.png", "--library", tmp_path / "none")
    assert status == 1
    assert "run `mixlight rooms assets`" in err
    assert not (tmp_path / "a.png").exists()


def test_preview(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mixlight.data.rooms import make_plan, scene

    monkeypatch.setattr(make_plan, "make_plan", lambda seed, **_: plain_plan(seed))
    monkeypatch.setattr(scene, "build", functools.partial(scene.build, sky_height=16))
    monkeypatch.setattr(render, "SCRIPT", STAND_IN)
    status, said, err = run("rooms", "preview", 5, tmp_path / "a.png", "--width", 16)
    assert (status, err) == (0, "")
    assert said == f"room 5 -> {tmp_path / 'a.png'}  (empty; light: ceiling, sky)\n"
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    status, _, err = run("rooms", "preview", 2, tmp_path / "b.png", "--width", 16)
    assert (status, err) == (1, "mixlight: ValueError: no such shader\n")
    assert not (tmp_path / "b.png").exists()
