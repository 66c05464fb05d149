"""`mixlight estimate --for ...` and `--detail photo`."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.app import cli
from mixlight.export.maps import read_map
from mixlight.export.registry import TARGETS
from mixlight.image import exr, radiance
from mixlight.light import document
from mixlight.light.detail import Detail
from mixlight.light.lighting import Lighting
from mixlight.network.estimator import Estimate, Estimator
from mixlight.sphere import equirect
from tests.app.conftest import Run
from tests.tolerances import HALF_FILE

pytestmark = pytest.mark.usefixtures("small_previews")


class FakeEstimator:
    """Two lamps and a little ambient light, whatever the photo."""

    card: dict[str, Any] = {"name": "fake"}  # noqa: RUF012 (never written to)

    def estimate(self, photo: torch.Tensor, fov_x: float) -> Estimate:
        ambient, energy = torch.zeros(9, 3), torch.zeros(128, 3)
        ambient[0] = 0.9
        energy[64], energy[20] = torch.tensor([2.0, 1.5, 1.0]), 0.5
        return Estimate(Lighting(ambient, energy), pitch=-0.1, roll=0.02, view=torch.zeros(96, 128, 3))


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Estimator, "load", lambda _: FakeEstimator())


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def energy_of(path: Path) -> torch.Tensor:
    return equirect.integrate(read_map(path)[0].double())


@pytest.mark.parametrize("detail", [[], ["--detail", "photo"]])
@pytest.mark.parametrize(
    ("options", "kind", "lights"),
    [([], "residual", 2), (["--lights", "1"], "residual", 1), (["--no-residual"], "full", 2),
     (["--lights", "0"], "full", 0)],
)  # fmt: skip
def test_each_unit_of_light_is_in_the_map_or_in_a_light(
    run: Run, photo: Path, fake: None, out: Path,
    options: list[str], kind: str, lights: int, detail: list[str],
) -> None:  # fmt: skip
    status, said, err = run("estimate", photo, "--out", out, "--for", "unity", "--json", *options, *detail)
    assert (status, err) == (0, "")
    line = json.loads(said)
    assert (line["targets"], line["map"]) == (["unity"], kind)
    folder = out / "room"
    assert {p.name for p in folder.iterdir()} == {
        "environment.exr", "environment.hdr", "lighting.json", "preview.png", "unity",
    }  # fmt: skip
    lighting = document.load(folder / "lighting.json")
    (written,) = (folder / "unity").glob("*.exr")
    taken = {0: [], 1: [64], 2: [64, 20]}[lights] if kind == "residual" else []
    expected = equirect.integrate(lighting.environment(256).double()) - lighting.energy[taken].double().sum(0)
    torch.testing.assert_close(energy_of(written), expected, rtol=2e-3, atol=1e-3)


def test_several_targets_by_comma_and_by_repetition(run: Run, photo: Path, fake: None, out: Path) -> None:
    status, said, _ = run("estimate", photo, "--out", out, "--for", "arcore,arkit", "--for", "unity")
    assert status == 0
    assert "for arcore, arkit, unity" in said
    for name in ("arcore", "arkit", "unity"):
        lines = (out / "room" / name / "README.txt").read_text().splitlines()
        assert len(lines) == 3


def test_what_export_writes_of_the_result_is_the_same(
    run: Run, photo: Path, fake: None, out: Path, tmp_path: Path
) -> None:
    assert run("estimate", photo, "--out", out, "--for", "unity")[0] == 0
    exported = tmp_path / "exported"
    assert run("export", out / "room" / "lighting.json", "--for", "unity", "--out", exported)[0] == 0
    first, second = (
        {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
        for folder in (out / "room" / "unity", exported / "unity")
    )
    assert first == second


@pytest.mark.parametrize(
    "failure", [ValueError("no"), OSError(28, "No space left"), ImportError("pip install")]
)
def test_a_target_that_fails_leaves_nothing_of_its_photo(
    run: Run, photo: Path, fake: None, out: Path, monkeypatch: pytest.MonkeyPatch, failure: Exception
) -> None:
    import mixlight.export.arkit

    def fail(*_: object) -> None:
        raise failure

    assert run("estimate", photo, "--out", out)[0] == 0
    before = {p: p.read_bytes() for p in (out / "room").iterdir()}
    monkeypatch.setattr(mixlight.export.arkit, "write", fail)
    status, _, err = run("estimate", photo, "--out", out, "--for", "unity,arkit", "--fov-deg", "50")
    assert status == 1
    assert err.startswith("mixlight: ")
    assert err.count("\n") == 1
    assert {p: p.read_bytes() for p in (out / "room").iterdir()} == before
    assert [p.name for p in out.iterdir()] == ["room"]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--for", "maya"], f"out of {', '.join(TARGETS)} or all, received 'maya'"),
        (["--for", ""], "received ''"),
        (["--for", "onnx"], "expected a target of light, received one of the model"),
        (["--lights", "-1"], "received '-1'"),
        (["--detail", "none"], "invalid choice: 'none'"),
    ],
)
def test_a_wrong_call(run: Run, photo: Path, out: Path, options: list[str], says: str) -> None:
    status, said, err = run("estimate", photo, "--out", out, *options)
    assert (status, said) == (cli.EXIT_USAGE, "")
    assert says in err
    assert err.count("\n") == 1
    assert not out.exists()


def test_an_export_that_is_not_renewed_is_named(run: Run, photo: Path, fake: None, out: Path) -> None:
    assert run("estimate", photo, "--out", out, "--for", "unity,arkit")[0] == 0
    status, _, err = run("estimate", photo, "--out", out, "--for", "arkit")
    assert status == 0
    assert err.startswith(f"mixlight: {out / 'room' / 'unity'}: left as an earlier run made it")
    assert err.count("\n") == 1


def laid_photo(photo: Path, height: int) -> Detail:
    from mixlight.app.photos import linear_tensor
    from mixlight.image.ldr import read_photo

    return Detail.of_photo(linear_tensor(read_photo(photo)), math.radians(60), height, pitch=-0.1, roll=0.02)


def test_the_photo_is_in_the_map_and_the_files_say_so(run: Run, photo: Path, fake: None, out: Path) -> None:
    assert run("estimate", photo, "--out", out, "--detail", "photo", "--height", "64")[0] == 0
    half, attributes = exr.read(out / "room" / "environment.exr")
    text = document.read(out / "room" / "lighting.json")
    lighting = document.from_document(text)
    detail = laid_photo(photo, 64)
    np.testing.assert_allclose(half, detail.environment(lighting).numpy(), **HALF_FILE)
    assert attributes["detail"] == "photo"
    assert radiance.read(out / "room" / "environment.hdr")[1]["DETAIL"] == "photo"
    assert text["photo"]["detail"] == {
        "source": "photo", "share_of_sphere": pytest.approx(detail.share, abs=1e-4), "opacity": 1.0,
    }  # fmt: skip
    # lighting.json alone does not make this map, but one of the same energy.
    rebuilt = lighting.environment(64)
    assert float((torch.from_numpy(half) - rebuilt).abs().max()) > 0.1
    torch.testing.assert_close(
        equirect.integrate(torch.from_numpy(half)), equirect.integrate(rebuilt), rtol=1e-3, atol=0
    )


def test_without_the_option_nothing_says_detail(run: Run, photo: Path, fake: None, out: Path) -> None:
    assert run("estimate", photo, "--out", out)[0] == 0
    assert "detail" not in exr.read(out / "room" / "environment.exr")[1]
    assert "detail" not in document.read(out / "room" / "lighting.json")["photo"]


def test_estimate_stays_light_without_targets() -> None:
    """A plain estimate imports nothing of export but the list of targets."""
    import subprocess
    import sys

    code = (
        "import sys; from mixlight.app import cli; cli.parser();"
        "print([m for m in sys.modules if m.startswith('mixlight.export.') and 'registry' not in m])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
