import json
import subprocess
import sys
from pathlib import Path

import pytest

from mixlight import __version__
from mixlight.app import cli
from tests.app.conftest import Run


@pytest.mark.parametrize("arguments", [["--help"], *([verb, "--help"] for verb in cli.VERBS)])
def test_help_explains_and_succeeds(run: Run, arguments: list[str]) -> None:
    status, out, err = run(*arguments)
    assert (status, err) == (0, "")
    assert out.startswith(f"usage: mixlight {arguments[0] if len(arguments) > 1 else ''}".rstrip())


def test_the_version_is_the_packages(run: Run) -> None:
    assert run("--version")[:2] == (0, f"mixlight {__version__}\n")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "required: VERB"),
        (("paint",), "invalid choice: 'paint'"),
        (("estimate",), "required: PHOTO"),
        (("estimate", "a.jpg", "--fov", "60"), "unrecognized arguments: --fov 60"),
        *(
            (
                ("estimate", "a.jpg", "--fov-deg", fov),
                f"expected an angle between 1 and 170 degrees, received '{fov}'",
            )
            for fov in ("1", "170", "0", "-20", "400", "nan", "inf", "wide", "")
        ),
        (("estimate", "a.jpg", "--height", "5"), "from 16 to 4096, received '5'"),
        (("estimate", "a.jpg", "--max-megapixels", "0"), "expected a number above 0, received '0'"),
        (("fit", "a.hdr", "--separation", "best"), "invalid choice: 'best'"),
        (("fit", "a.hdr", "--fraction", "1.5"), "between 0 and 1, received '1.5'"),
        (("fit", "a.hdr", "--degree", "7"), "from 0 to 6, received '7'"),
        (("fit", "a.hdr", "--anchors", "1e9"), "from 8 to 4096, received '1e9'"),
        (("render", "a.json", "--size", "4"), "from 16 to 1024, received '4'"),
        (("render", "a.json", "--exposure-ev", "nan"), "from -40 to 40, received 'nan'"),
        (("render", "a.json", "--out", "spheres.gif"), "ends in .png or .exr"),
    ],
)
def test_a_wrong_call_ends_in_one_line_before_any_work(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run(*arguments)
    assert (status, out) == (cli.EXIT_USAGE, "")
    assert err.startswith("mixlight: ")
    assert says in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_an_interrupt_ends_in_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli.VERBS["fit"], "run", interrupted)
    assert run("fit", "a.hdr") == (130, "", "mixlight: interrupted\n")


def test_the_command_comes_up_without_the_heavy_packages() -> None:
    code = (
        "import sys; from mixlight.app.cli import parser; parser();"
        "print([m for m in ('torch', 'numpy', 'PIL', 'OpenEXR', 'jaxtyping') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_reader_that_goes_away_is_no_traceback(tmp_path: Path) -> None:
    """`mixlight ... --json | head -1` with more output to come."""
    code = (
        "import sys, mixlight.app.cli as cli\n"
        "def run(_):\n"
        "    for _ in range(100000): print('a line of output', flush=True)\n"
        "    return 0\n"
        "cli.VERBS['fit'].run = run\n"
        "sys.exit(cli.main(['fit', 'a.hdr']))"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 1


def test_json_lines_are_ascii_whatever_the_file_is_called(run: Run, tmp_path: Path) -> None:
    status, out, err = run("fit", tmp_path / "gewölbe-\udcff.hdr", "--out", tmp_path / "out", "--json")
    assert status == 1
    assert json.loads(out)["ok"] is False
    assert out.isascii()
    assert err.count("\n") == 1
