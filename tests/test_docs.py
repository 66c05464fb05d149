"""The documentation holds: links lead somewhere, commands and names exist, code runs, tables are right."""

import importlib
import math
import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mixlight.app import cli

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "src/mixlight/assets/examples/comfy_cafe.jpg"
PAGES = sorted(
    [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "benchmarks/README.md")]
    + list((ROOT / "docs").rglob("*.md"))
)
FOLDERS = {path.name for path in (ROOT / "src/mixlight").iterdir() if (path / "__init__.py").is_file()}

page = pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))


def prose(path: Path) -> str:
    """A page without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def fenced(path: Path, language: str) -> list[str]:
    text = path.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)


def code(path: Path) -> Iterator[str]:
    """What stands between backticks in running text."""
    yield from re.findall(r"`([^`\n]+)`", prose(path))


def anchors(path: Path) -> set[str]:
    """Names of a page's headings as web pages of repositories make them."""
    headings = re.findall(r"^#+ (.+)$", prose(path), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def table(path: Path, first: str) -> list[list[str]]:
    """Rows of the table whose header begins with the given cell."""
    lines = path.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {first} |"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


@page
def test_links_lead_somewhere(page: Path) -> None:
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"https?://|mailto:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.is_file() or (anchor and anchor not in anchors(file)):
            broken.append(target)
    assert not broken, f"{page.name}: expected files and headings, found none at {broken}"


@page
def test_the_tests_that_a_page_names_exist(page: Path) -> None:
    missing = []
    for reference in code(page):
        if not re.fullmatch(r"tests/[\w/]+\.py(::\w+)*", reference):
            continue
        file, *names = reference.split("::")
        text = (ROOT / file).read_text(encoding="utf-8") if (ROOT / file).is_file() else ""
        if not text or not all(re.search(rf"^\s*(def|class) {name}\b", text, re.MULTILINE) for name in names):
            missing.append(reference)
    assert not missing, f"{page.name} names tests that are not there: {missing}"


def resolve(dotted: str) -> Any:
    """The module, or the attribute of one, of that name."""
    parts = dotted.split(".")
    for length in range(len(parts), 0, -1):
        try:
            value: Any = importlib.import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for name in parts[length:]:
            value = getattr(value, name)
        return value
    raise ModuleNotFoundError(dotted)


@page
def test_the_names_that_a_page_uses_exist(page: Path) -> None:
    missing = []
    for reference in code(page):
        match = re.match(r"(mixlight\.)?([a-zA-Z_]\w*(\.[a-zA-Z_]\w*)*)(?=$|\()", reference)
        if not match or not (match[1] or match[2].partition(".")[0] in FOLDERS) or "/" in reference:
            continue
        if match[2].endswith((".py", ".toml", ".json", ".csv", ".js")) or match[2] in ("onnx", "mjs"):
            continue
        try:
            resolve(f"mixlight.{match[2]}")
        except (AttributeError, ModuleNotFoundError):
            missing.append(reference)
    assert not missing, f"{page.name} uses names that are not there: {missing}"


@page
def test_the_files_that_a_page_names_exist(page: Path) -> None:
    missing = []
    for reference in code(page):
        if not re.fullmatch(r"[\w.-]+(/[\w.-]+)+\.(py|toml|json|csv)", reference):
            continue
        if reference.startswith(("light/photo/", "for/", "data/", "runs/")):
            continue  # what a user has
        if not any((root / reference).is_file() for root in (ROOT, ROOT / "src/mixlight")):
            missing.append(reference)
    assert not missing, f"{page.name} names files that are not there: {missing}"


def commands(path: Path) -> list[str]:
    shown = [line[2:] for block in fenced(path, "console") for line in block.splitlines() if line[:2] == "$ "]
    return [line for line in [*shown, *code(path)] if line.startswith("mixlight ")]


@page
def test_commands_can_be_parsed(page: Path) -> None:
    for command in commands(page):
        words = shlex.split(command)[1:]
        if "VERB" in words:
            continue
        assert words[0] in cli.VERBS or words[0].startswith("--"), command
        if len(words) == 1 or "..." in command:
            continue
        if "--help" in words:
            words.remove("--help")
            words.append("input")  # what every verb wants
        cli.parser().parse_args(words)  # exits where it is no command


@page
def test_options_exist(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known = ""
    actions = [
        [verb, action] for verb, module in cli.VERBS.items() for action in getattr(module, "ACTIONS", ())
    ]
    for words in ([], *([verb] for verb in cli.VERBS), *actions):
        with pytest.raises(SystemExit):
            cli.parser().parse_args([*words, "--help"])
        known += capsys.readouterr().out
    if page.name == "CONTRIBUTING.md":
        return  # speaks of other programs' options
    options = {option for text in code(page) for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", text)}
    assert not {option for option in options if not re.search(rf"{option}\b(?!-)", known)}


@pytest.mark.slow
def test_the_readmes_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(EXAMPLE, tmp_path / "photo.jpg")
    monkeypatch.chdir(tmp_path)
    (block,) = fenced(ROOT / "README.md", "python")
    names: dict[str, Any] = {}
    exec(compile(block, "README.md", "exec"), names)
    assert names["environment"].shape == (256, 512, 3)
    assert names["spheres"].shape == (3, 128, 128, 3)
    assert bool((names["again"].energy == names["light"].energy).all())


@pytest.mark.slow
def test_the_readmes_commands_print_what_it_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where the README shows output, it is the program's; the example photo stands for photo.jpg."""
    from mixlight.image import radiance
    from mixlight.light.document import load

    shutil.copy(EXAMPLE, tmp_path / "photo.jpg")
    monkeypatch.chdir(tmp_path)
    shown = fenced(ROOT / "README.md", "console")[0].splitlines()
    starts = [i for i, line in enumerate(shown) if line.startswith("$ mixlight ")]
    for start, stop in zip(starts, [*starts[1:], len(shown)], strict=True):
        words = shlex.split(shown[start])[2:]
        if words[0] == "fit":  # the light just estimated is a panorama too
            environment = load("light/photo/lighting.json").environment(64)
            radiance.write("panorama.hdr", environment.numpy())
        assert cli.main(words) == 0
        printed, expected = capsys.readouterr().out.splitlines(), shown[start + 1 : stop]
        if expected:  # … stands for a number that depends on the panorama
            pattern = re.escape("\n".join(expected)).replace("…", r"[\d.]+")
            assert re.fullmatch(pattern, "\n".join(printed))


@page
def test_no_block_is_left_to_be_filled_in(page: Path) -> None:
    blocks = re.findall(
        r"<!-- table ([\w-]+) -->\n(.*?)<!-- /table -->", page.read_text(encoding="utf-8"), re.DOTALL
    )
    assert not [name for name, body in blocks if not body.strip()]


@page
def test_measured_tables_are_those_of_the_results(page: Path) -> None:
    from experiments.tables.pages import filled

    text = page.read_text(encoding="utf-8")
    assert filled(text) == text, "run `python -m experiments.tables`"


@page
def test_no_machine_is_named(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r"(?<![\w.])/(?:work|tmp|home|root|usr)/", text)


@pytest.mark.parametrize("row", table(ROOT / "docs/photos.md", "photo"), ids=lambda row: row[0])
def test_parts_of_photo_and_view_are_as_computed(row: list[str]) -> None:
    from mixlight.network.model import ModelSettings
    from mixlight.sphere.camera import fov_from_focal_length_35mm, vertical_fov

    canonical = ModelSettings().canonical
    width, height = (int(side) for side in re.findall(r"(\d+):(\d+)", row[0])[0])
    focal = re.search(r"(\d+) mm", row[0])
    fov = fov_from_focal_length_35mm(float(focal[1]), width, height) if focal else math.radians(60)
    across = math.tan(canonical.fov / 2) / math.tan(fov / 2)
    down = math.tan(vertical_fov(canonical.fov, canonical.height, canonical.width) / 2)
    down /= math.tan(vertical_fov(fov, height, width) / 2)
    used = min(1, across) * min(1, down)
    filled = 1 - min(1, 1 / across) * min(1, 1 / down)
    computed = [f"{math.degrees(fov):.1f}°", f"{100 * used:.0f} %", f"{100 * filled:.0f} %"]
    assert row[1:] == computed


def test_the_table_of_frames_is_the_librarys() -> None:
    import torch

    from mixlight.sphere import FRAMES, convert_directions

    rolls = {"": 0, "right W/4": 1, "W/2": 2, "left W/4": 3}
    rows = table(ROOT / "docs/conventions.md", "name")
    assert [row[0].strip("`") for row in rows] == list(FRAMES)
    for name, hand, _, centre, roll, axes in rows:
        frame = FRAMES[name.strip("`")]
        assert frame.quarter_turns == rolls[roll]
        assert frame.right_handed == ("right" in hand)
        values = {"x": 1.0, "y": 2.0, "z": 3.0}
        written = [values[word[-1]] * (-1 if word[0] == "−" else 1) for word in re.findall(r"−?[xyz]", axes)]
        assert convert_directions(torch.tensor([1.0, 2.0, 3.0]), "mixlight", frame.name).tolist() == written
        up = convert_directions(torch.tensor([0.0, 1.0, 0.0]), "mixlight", frame.name).tolist()
        assert up["XYZ".index(hand[1])] == 1.0
        # What lies at the centre of the rolled image is our direction at -Z turned by the roll.
        angle = -frame.quarter_turns * math.pi / 2
        ours = torch.tensor([math.sin(angle), 0.0, -math.cos(angle)])
        theirs = [round(v) for v in convert_directions(ours, "mixlight", frame.name).tolist()]
        expected = [0, 0, 0]
        expected["XYZ".index(centre[-1])] = 1 if centre[0] == "+" else -1
        assert theirs == expected


def test_the_table_of_harmonics_is_the_librarys() -> None:
    import torch

    from mixlight.light.harmonics import basis

    ((_, *polynomials), (_, *factors)) = table(ROOT / "docs/conventions.md", "index")
    x, y, z = (direction := torch.tensor([0.48, -0.6, 0.64], dtype=torch.float64)).tolist()
    values = {"1": 1.0, "x": x, "y": y, "z": z, "xy": x * y, "yz": y * z, "xz": x * z}
    values |= {"3z² − 1": 3 * z * z - 1, "x² − y²": x * x - y * y}
    written = [float(factor) * values[name] for factor, name in zip(factors, polynomials, strict=True)]
    assert basis(direction).tolist() == pytest.approx(written, abs=1e-6)


def test_the_table_of_materials_is_the_librarys() -> None:
    from mixlight.light.transport import MATERIALS

    rows = table(ROOT / "docs/conventions.md", "sphere")
    for (name, text), material in zip(rows, MATERIALS, strict=True):
        assert name.startswith(material.name)
        assert material.reflectance == float(re.findall(r"(?:albedo|reflectance) (\.\d+)", text)[0])
        assert round(material.alpha, 3) == float((re.findall(r"= (\.\d+),", text) or ["0"])[0])
