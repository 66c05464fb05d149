"""Sets of rooms are rendered without losing anything, whatever Blender does; a script stands in for it."""

import csv
import dataclasses
import functools
import json
import shutil
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mixlight
from mixlight.data.panoramas import read_radiance, read_table
from mixlight.data.rooms import render
from mixlight.data.rooms.balance import render_gains
from mixlight.data.rooms.catalogue import Catalogue, Entry
from mixlight.data.rooms.job import Settings
from mixlight.data.rooms.plan import Item, Plan
from mixlight.data.rooms.render import Outcome, RenderError, Rooms, render_rooms
from mixlight.data.rooms.room_set import RoomSet, SetError
from mixlight.data.rooms.store import read_room
from tests.data.rooms.boxes import plain_plan

STAND_IN = Path(__file__).with_name("stand_in.py")
SMALL = Rooms(Settings(width=16, samples=1), cameras=2)

Run = Callable[..., list[Outcome]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Renders seeds into `tmp_path`/set with the stand-in; `troubles` go by the seed."""

    def plan(seed: int, *, cameras: int, **_: Any) -> Plan:
        return plain_plan(seed, cameras)

    monkeypatch.setattr(render, "make_plan", plan)
    monkeypatch.setattr(render, "build", functools.partial(render.build, sky_height=16))
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "scratch"))

    def call(seeds: Any, rooms: Rooms = SMALL, troubles: dict[int, str] | None = None, **more: Any) -> Any:
        named = {f"room-{seed:05d}": trouble for seed, trouble in (troubles or {}).items()}
        monkeypatch.setenv("TROUBLES", json.dumps(named))
        return render_rooms(
            list(seeds), tmp_path / "set", rooms, blender=sys.executable, script=STAND_IN, threads=1, **more
        )

    return call


def seeds_of(folder: Path) -> list[int]:
    return list(RoomSet(folder).rooms())


def test_a_set_is_what_training_reads(run: Run, tmp_path: Path) -> None:
    outcomes = run(range(8, 11))
    assert sorted(o.seed for o in outcomes) == [8, 9, 10]
    assert all(o.error is None and o.panoramas == 2 for o in outcomes)
    assert set(outcomes[0].seconds) == {"plan", "files", "build", "render", "denoise", "pack"}
    records = read_table(tmp_path / "set" / "rooms.csv")
    assert [r.split for r in records] == ["train"] * 2 + ["val"] * 2 + ["train"] * 2
    assert {r.group for r in records} == {"room-00008", "room-00009", "room-00010"}
    assert all(r.category == "room" for r in records)
    assert read_radiance(records[0].path).shape == (8, 16, 3)
    room = read_room(records[1].path)
    gains = render_gains(
        plain_plan(8, 2)
    )  # Blender renders faint lamps brighter; what is kept is their light
    raw = {"ceiling": 1.0, "off": 2.0, "sky": 3.0}
    means = {name: float(group.mean()) for name, group in room.groups.items()}
    assert means == pytest.approx(
        {name: value / gains.get(name, 1.0) for name, value in raw.items()}, rel=2e-2
    )
    assert means["ceiling"] != pytest.approx(1.0, rel=2e-2)
    assert room.camera == 1
    assert room.plan == plain_plan(8, 2)
    assert room.document["versions"] == {"mixlight": mixlight.__version__, "blender": "stand-in"}
    assert room.document["seconds"]["render"] == room.document["core_seconds"]["render"] == 1.0
    with (tmp_path / "set" / "rooms.csv").open() as lines:
        assert next(csv.reader(lines)) == ["scene", "file", "seed", "split", "category", "group"]


def test_what_is_there_is_not_made_again(run: Run, tmp_path: Path) -> None:
    run([1])
    before = (tmp_path / "set" / "room-00001" / "camera-0.exr").stat().st_mtime_ns
    assert [o.seed for o in run([0, 1, 2])] == [0, 2]
    assert (tmp_path / "set" / "room-00001" / "camera-0.exr").stat().st_mtime_ns == before
    assert run([0, 1, 2]) == []
    assert len(read_table(tmp_path / "set" / "rooms.csv")) == 6


def test_a_set_says_whose_work_is_in_it(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [
        Entry(name, "chair", (1.0, 1.0, 1.0), title=name.title(), creator="A. Maker", licence="CC-BY-3.0")
        for name in ("stool", "throne", "bench")
    ]
    library = Catalogue(tmp_path / "none.blend", tuple(entries), {"version": "1"})

    def plan(seed: int, *, cameras: int, **_: Any) -> Plan:
        item = Item("chair", f"library:{['stool', 'throne'][seed]}", (1.0, 1.0, 0.0), 0.0, (1.0, 1.0, 1.0))
        sky = dataclasses.replace(plain_plan().sky, file=f"field_{seed}")
        return dataclasses.replace(plain_plan(seed, cameras), items=(item,), sky=sky)

    monkeypatch.setattr(render, "make_plan", plan)
    build = render.build

    def grey(plan: Plan, **more: Any) -> Any:
        return build(dataclasses.replace(plan, sky=plain_plan().sky), **more)

    monkeypatch.setattr(render, "build", grey)
    rooms = dataclasses.replace(SMALL, catalogue=library)
    run([0], rooms)
    first = (tmp_path / "set" / "ATTRIBUTION.txt").read_text()
    assert "Stool, by A. Maker" in first
    assert "Throne" not in first
    run([1], rooms)
    second = (tmp_path / "set" / "ATTRIBUTION.txt").read_text()
    assert all(word in second for word in ("Stool", "Throne", "field_0", "field_1"))
    assert "Bench" not in second


def test_a_room_that_fails_is_left_out(run: Run, tmp_path: Path) -> None:
    told: list[Outcome] = []
    run(range(4), troubles={1: "error", 2: "garbage"}, report=told.append)
    assert {o.seed: o.error for o in told if o.error}.keys() == {1, 2}
    said = {o.seed: str(o.error) for o in told}
    assert "no such shader" in said[1]
    assert "expected Blender's panorama" in said[2]
    assert seeds_of(tmp_path / "set") == [0, 3]
    assert sorted(p.name for p in (tmp_path / "set").iterdir()) == [
        "ATTRIBUTION.txt", "room-00000", "room-00003", "rooms.csv", "rooms.json",
    ]  # fmt: skip


def test_a_plan_that_fails_is_left_out(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def plan(seed: int, *, cameras: int, **_: Any) -> Plan:
        if seed == 1:
            raise KeyError("sofa")
        return plain_plan(seed, cameras)

    monkeypatch.setattr(render, "make_plan", plan)
    assert {o.seed: o.error for o in run(range(3))} == {0: None, 1: "KeyError: 'sofa'", 2: None}


def test_a_killed_blender_is_started_again(run: Run, tmp_path: Path) -> None:
    outcomes = run(range(3), troubles={1: "die_once"})
    assert all(o.error is None for o in outcomes)
    assert seeds_of(tmp_path / "set") == [0, 1, 2]


def test_a_room_that_kills_blender_is_left_out(run: Run, tmp_path: Path) -> None:
    said = {o.seed: o.error for o in run(range(3), troubles={1: "die"})}
    assert "exit status 11" in str(said[1])
    assert "Segmentation fault (not really)" in str(said[1])
    assert seeds_of(tmp_path / "set") == [0, 2]


def test_a_room_that_takes_too_long_is_left_out(run: Run, tmp_path: Path) -> None:
    rooms = Rooms(SMALL.settings, cameras=1, timeout=15.0)
    said = {o.seed: o.error for o in run(range(2), rooms, troubles={0: "hang"})}
    assert "expected an end within 15 s" in str(said[0])
    assert said[1] is None


def test_several_blenders_at_a_time(run: Run, tmp_path: Path) -> None:
    outcomes = run(range(6), troubles={2: "die_once"}, jobs=3)
    assert sorted(o.seed for o in outcomes) == list(range(6))
    assert seeds_of(tmp_path / "set") == list(range(6))


def test_nothing_but_failures_ends_it(run: Run, tmp_path: Path) -> None:
    with pytest.raises(RenderError, match="6 rooms failed one after the other"):
        run(range(20), troubles=dict.fromkeys(range(1, 20), "error"))
    assert seeds_of(tmp_path / "set") == [0]
    assert len(read_table(tmp_path / "set" / "rooms.csv")) == 2


def test_a_full_disk_ends_it_and_keeps_what_is_done(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = render.write_camera

    def full(path: Path, *arguments: Any, **more: Any) -> None:
        if "room-00001" in str(path):
            usage = shutil.disk_usage(tmp_path)
            monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage._replace(free=0))
            raise OSError(28, "No space left on device", str(path))
        write(path, *arguments, **more)

    monkeypatch.setattr(render, "write_camera", full)
    with pytest.raises(
        RenderError, match="set: expected room on the disk, found none; the rooms that are done"
    ):
        run(range(9))
    assert seeds_of(tmp_path / "set") == [0]
    assert list((tmp_path / "set").glob(".*")) == []
    assert len(read_table(tmp_path / "set" / "rooms.csv")) == 2


def test_a_quota_ends_it_as_a_full_disk_does(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, *_: Any, **__: Any) -> None:
        raise OSError(122, "Disk quota exceeded", str(path))

    monkeypatch.setattr(render, "write_camera", full)
    with pytest.raises(RenderError, match=r"camera-0\.exr: expected room on the disk, found none"):
        run(range(9))
    assert seeds_of(tmp_path / "set") == []


def test_an_interrupt_leaves_nothing_half_done(run: Run, tmp_path: Path) -> None:
    def interrupt(outcome: Outcome) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(range(4), troubles={1: "hang", 2: "hang", 3: "hang"}, report=interrupt)
    assert seeds_of(tmp_path / "set") == [0]
    assert list((tmp_path / "set").glob(".*")) == []
    assert list((tmp_path / "scratch").iterdir()) == []
    assert threading.active_count() == 1 or all(t.daemon for t in threading.enumerate()[1:])


def test_no_blender(tmp_path: Path) -> None:
    with pytest.raises(RenderError, match="expected a program that runs"):
        render_rooms([0], tmp_path / "set", SMALL, blender=tmp_path / "none", script=STAND_IN)


def test_rooms_of_another_version_do_not_join_a_set(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run([0])
    monkeypatch.setattr(render, "__version__", "9.0.0")
    with pytest.raises(SetError, match=r"made with mixlight .*, expected 9\.0\.0; make them alike, or give"):
        run([1])
    assert seeds_of(tmp_path / "set") == [0]


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (Rooms(Settings(width=32, samples=1), cameras=2), "made with width 16, expected 32"),
        (Rooms(Settings(width=16, samples=1), cameras=3), "made with cameras 2, expected 3"),
    ],
)
def test_another_kind_of_room_does_not_join_a_set(run: Run, tmp_path: Path, other: Rooms, said: str) -> None:
    run([0])
    before = {p: p.read_bytes() for p in (tmp_path / "set").rglob("*") if p.is_file()}
    with pytest.raises(SetError, match=said):
        run([1], other)
    assert {p: p.read_bytes() for p in (tmp_path / "set").rglob("*") if p.is_file()} == before
