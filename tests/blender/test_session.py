"""One Blender for many folders; a Python that answers without bpy stands in for it."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

from mixlight.blender.program import BlenderError, BlenderMissing
from mixlight.blender.session import Session

SCRIPT = """
import json, os, sys, time
print("started with", sys.argv[sys.argv.index("--") + 1 :])
sys.stdout.flush()
while line := sys.stdin.readline():
    folder = line.rstrip("\\n")
    name = os.path.basename(folder)
    if name == "die":
        print("last words", flush=True)
        os._exit(7)
    if name == "hang":
        time.sleep(60)
    part = os.path.join(folder, "part")
    with open(part, "w") as file:
        json.dump({"ok": True, "pid": os.getpid(), "arguments": sys.argv[sys.argv.index("--") + 1 :]}, file)
    os.replace(part, os.path.join(folder, "answer.json"))
"""


@pytest.fixture
def script(tmp_path: Path) -> Path:
    path = tmp_path / "script.py"
    path.write_text(SCRIPT)
    return path


def folder(tmp_path: Path, name: str) -> Path:
    made = tmp_path / name
    made.mkdir()
    return made


def test_one_process_for_many_folders(script: Path, tmp_path: Path) -> None:
    with Session(script, ["2"], blender=sys.executable) as session:
        answers = [session.ask(folder(tmp_path, name), 30) for name in "abc"]
    assert len({answer["pid"] for answer in answers}) == 1
    assert answers[0]["arguments"] == ["2"]


def test_another_process_takes_over_in_time(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable, renew_after=2) as session:
        pids = [session.ask(folder(tmp_path, name), 30)["pid"] for name in "abcde"]
    assert pids[0] == pids[1] != pids[2] == pids[3] != pids[4]


def test_names_with_blanks(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        assert session.ask(folder(tmp_path, "a room with blanks é"), 30)["ok"]


def test_after_a_death_there_is_another(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        first = session.ask(folder(tmp_path, "a"), 30)
        with pytest.raises(BlenderError, match=r"script\.py in Blender: exit status 7\n.*\n  last words"):
            session.ask(folder(tmp_path, "die"), 30)
        assert session.ask(folder(tmp_path, "b"), 30)["pid"] != first["pid"]


def test_a_deadline(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        start = time.monotonic()
        with pytest.raises(BlenderError, match="expected an end within 1 s"):
            session.ask(folder(tmp_path, "hang"), 1)
        assert time.monotonic() - start < 20
        assert session.ask(folder(tmp_path, "a"), 30)["ok"]


def test_stopped_from_another_thread(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        session.ask(folder(tmp_path, "a"), 30)
        timer = threading.Timer(0.3, session.stop)
        timer.start()
        with pytest.raises(BlenderError, match="ended by SIGKILL"):
            session.ask(folder(tmp_path, "hang"), 50)
        timer.join()
        with pytest.raises(BlenderError, match="the session is over"):
            session.ask(folder(tmp_path, "b"), 30)


def test_killed_between_folders(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        first = session.ask(folder(tmp_path, "a"), 30)
        os.kill(first["pid"], signal.SIGKILL)
        time.sleep(0.3)
        assert session.ask(folder(tmp_path, "b"), 30)["pid"] != first["pid"]


def test_no_program_and_no_script(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=tmp_path / "none") as session, pytest.raises(BlenderMissing):
        session.ask(tmp_path, 30)
    with Session(tmp_path / "none.py", blender=sys.executable) as session, pytest.raises(FileNotFoundError):
        session.ask(tmp_path, 30)


def test_closing_ends_it(script: Path, tmp_path: Path) -> None:
    with Session(script, blender=sys.executable) as session:
        pid = session.ask(folder(tmp_path, "a"), 30)["pid"]
    assert not Path(f"/proc/{pid}").exists()
