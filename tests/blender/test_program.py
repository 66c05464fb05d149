"""The runner, with a plain Python in Blender's place; tests/interop/test_blender.py runs the real one."""

import os
import stat
import sys
import time
from pathlib import Path

import pytest

from mixlight.blender import program

STAND_IN = Path(sys.executable)


def script(folder: Path, text: str) -> Path:
    path = folder / "script.py"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def nothing_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv(program.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path / "mixlight" / "blender" / "bin" / "python"


class TestFind:
    def test_the_variable_comes_first(self, nothing_installed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        nothing_installed.parent.mkdir(parents=True)
        nothing_installed.symlink_to(sys.executable)
        assert program.find_blender() == nothing_installed
        monkeypatch.setenv(program.VARIABLE, sys.executable)
        assert program.find_blender() == STAND_IN

    def test_a_link_of_a_virtual_environment_is_not_followed(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        link = tmp_path / "python"
        link.symlink_to(sys.executable)
        monkeypatch.setenv(program.VARIABLE, str(link))
        assert program.find_blender() == link

    @pytest.mark.usefixtures("nothing_installed")
    def test_missing_says_the_exact_command(self, tmp_path: Path) -> None:
        with pytest.raises(program.BlenderMissing) as raised:
            program.find_blender()
        home = tmp_path / "mixlight" / "blender"
        assert f"python3.11 -m venv {home} && " in str(raised.value)
        assert f'{home}/bin/python -m pip install "bpy==5.0.1" "numpy<2"' in str(raised.value)

    def test_a_variable_that_names_nothing_is_an_error_and_not_passed_over(
        self, nothing_installed: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        nothing_installed.parent.mkdir(parents=True)
        nothing_installed.symlink_to(sys.executable)
        monkeypatch.setenv(program.VARIABLE, "/nowhere/python")
        with pytest.raises(program.BlenderMissing, match="MIXLIGHT_BLENDER_PYTHON names /nowhere/python"):
            program.find_blender()

    @pytest.mark.usefixtures("nothing_installed")
    def test_a_relative_data_home_is_ignored(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("XDG_DATA_HOME", "relative")
        assert str(Path.home() / ".local/share/mixlight/blender") in program.install_command()


class TestRun:
    def test_arguments_stand_behind_two_dashes_and_output_comes_back(self, tmp_path: Path) -> None:
        text = "import sys\nprint(sys.argv[sys.argv.index('--') + 1 :])\nprint('err', file=sys.stderr)"
        output = program.run(script(tmp_path, text), ["a b", Path("c")], timeout=60, blender=STAND_IN)
        assert output.splitlines() == ["['a b', 'c']", "err"] or output.splitlines()[::-1] == [
            "['a b', 'c']",
            "err",
        ]

    def test_a_blender_program_gets_its_own_options(self, tmp_path: Path) -> None:
        installed = tmp_path / "blender-4.5"
        installed.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
        installed.chmod(installed.stat().st_mode | stat.S_IXUSR)
        path = script(tmp_path, "")
        given = program.run(path, ["x"], timeout=60, blender=installed).split()
        assert given == [
            *(
                "--background",
                "--factory-startup",
                "--python-exit-code",
                "1",
                "--python",
                str(path),
                "--",
                "x",
            )
        ]

    def test_neither_the_callers_folder_nor_pythonpath_reach_it(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "numpy.py").write_text("raise SystemExit('the wrong numpy')")
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        text = "import sys\nassert not [p for p in sys.path if p.startswith(sys.argv[-1])], sys.path"
        program.run(script(tmp_path, text), [tmp_path], timeout=60, blender=STAND_IN, cwd=tmp_path)

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("for i in range(99): print(i)\nraise ValueError('no light')", "ValueError: no light"),
            ("import sys\nsys.exit(3)", "exit status 3"),
            ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", "ended by SIGSEGV"),
        ],
    )
    def test_a_failure_carries_the_last_lines(self, tmp_path: Path, text: str, expected: str) -> None:
        with pytest.raises(program.BlenderError) as raised:
            program.run(script(tmp_path, text), timeout=60, blender=STAND_IN)
        message = str(raised.value)
        assert message.startswith("script.py in Blender: ")
        assert expected in message
        assert len(message.splitlines()) <= 13

    def test_a_python_without_bpy_is_no_blender(self, tmp_path: Path) -> None:
        with pytest.raises(program.BlenderMissing, match="expected a Python that can import bpy"):
            program.run(script(tmp_path, "import bpy"), timeout=60, blender=STAND_IN)

    def test_a_file_that_is_no_program(self, tmp_path: Path) -> None:
        with pytest.raises(program.BlenderMissing, match="expected a program that runs"):
            program.run(script(tmp_path, ""), timeout=60, blender=tmp_path / "script.py")

    def test_a_script_that_is_missing(self, tmp_path: Path) -> None:
        with pytest.raises(FileNotFoundError):
            program.run(tmp_path / "none.py", timeout=60, blender=STAND_IN)

    def test_a_timeout_ends_the_children_too(self, tmp_path: Path) -> None:
        text = (
            "import subprocess, sys, time\n"
            "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])\n"
            "open(sys.argv[-1], 'w').write(str(child.pid))\n"
            "print('rendering', flush=True)\n"
            "time.sleep(60)\n"
        )
        begun = time.monotonic()
        with pytest.raises(
            program.BlenderError, match="expected an end within 3 s, received none\n  rendering"
        ):
            program.run(script(tmp_path, text), [tmp_path / "pid"], timeout=3, blender=STAND_IN)
        assert time.monotonic() - begun < 30
        child = int((tmp_path / "pid").read_text())
        for _ in range(50):
            state = Path(f"/proc/{child}/stat")
            if not state.exists() or state.read_text().rpartition(")")[2].split()[0] == "Z":
                break
            time.sleep(0.1)
        else:
            os.kill(child, 9)
            pytest.fail("the child of a killed script lives on")

    def test_bytes_that_are_no_text_do_not_stop_the_report(self, tmp_path: Path) -> None:
        text = "import sys\nsys.stdout.buffer.write(b'\\xff light')"
        assert (
            program.run(script(tmp_path, text), timeout=60, blender=STAND_IN)
            == "\N{REPLACEMENT CHARACTER} light"
        )
