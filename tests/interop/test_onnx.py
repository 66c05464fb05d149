"""The exported network in onnxruntime and in onnxruntime-web: the same light as from PyTorch."""

import json
import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.app.photos import field_of_view, linear_tensor
from mixlight.export.onnx import OUTPUTS, to_onnx, write
from mixlight.export.onnx_precision import PRECISIONS, store
from mixlight.image.color import linear_to_srgb
from mixlight.image.ldr import read_photo
from mixlight.light.lighting import Lighting
from mixlight.network import srgb
from mixlight.network.estimator import Estimator, kept_energy
from mixlight.network.sparsemax import MODES
from tests.export.small_network import small_estimator
from tests.interop.images import hold
from tests.interop.web import FOLDER as WEB
from tests.interop.web import Web

pytestmark = [pytest.mark.interop, pytest.mark.slow]

PARITY = 1e-4
"""Largest difference from PyTorch, relative to the largest value of that output for that photo."""

STORED = {"float16": 0.01, "int8": 0.05}
"""For narrowed weights: largest difference of the irradiance on surfaces facing six ways, relative to its
largest value. What they mean for pictures is in experiments/results/onnx.json."""

EXAMPLES = sorted((Path(__file__).parents[2] / "src/mixlight/assets/examples").glob("*.jpg"))

Outputs = dict[str, Tensor]


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator.load()


@pytest.fixture(scope="module")
def exported(estimator: Estimator, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that `mixlight export --for onnx` makes."""
    folder = tmp_path_factory.mktemp("onnx")
    write(estimator, folder)
    return folder


def batches(estimator: Estimator) -> dict[str, Tensor]:
    """Encoded views: example photos and noise, in batches of 1, 2 and 7."""
    views = []
    for path in EXAMPLES:
        photo = read_photo(path)
        views.append(estimator.view(linear_tensor(photo), field_of_view(photo).radians))
    photos = srgb.encode(torch.stack(views)).permute(0, 3, 1, 2)
    noise = torch.rand(8, *photos.shape[1:], generator=torch.Generator().manual_seed(5))
    dark = noise[:1] * 0.02
    return {
        "photo": photos[:1],
        "photos": photos[1:3],
        "photos and noise": torch.cat([photos, noise[:3]]),
        "noise": noise[3:4],
        "dark and noise": torch.cat([dark, noise[4:5]]),
        "only noise": noise[1:],
    }


def by_torch(estimator: Estimator, photos: Tensor) -> Outputs:
    with torch.inference_mode():
        prediction = estimator.model(photos)
    values = (prediction.ambient, kept_energy(prediction), prediction.camera)
    return dict(zip(OUTPUTS, values, strict=True))


def by_onnxruntime(model: bytes | Path, photos: Tensor) -> Outputs:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    source = model if isinstance(model, bytes) else str(model)
    session = onnxruntime.InferenceSession(source, options, providers=["CPUExecutionProvider"])
    found = session.run(list(OUTPUTS), {"photo": photos.contiguous().numpy()})
    return {name: torch.from_numpy(value) for name, value in zip(OUTPUTS, found, strict=True)}


def by_node(model: Path, photos: Tensor, folder: Path) -> Outputs:
    node = shutil.which("node")
    if node is None:
        pytest.fail("expected Node on the PATH, found none: apt-get install nodejs npm")
    raw = folder / "photos.f32"
    raw.write_bytes(photos.contiguous().numpy().astype("<f4").tobytes())
    options = json.dumps({"shape": list(photos.shape), "rounds": 1})
    done = subprocess.run(
        [node, WEB / "onnx_run.mjs", model, raw, options], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    outputs = json.loads(done.stdout.splitlines()[-1])["outputs"]
    return {name: torch.tensor(value["data"]).reshape(value["dims"]) for name, value in outputs.items()}


def difference(found: Outputs, expected: Outputs) -> float:
    """The largest over outputs and photos, relative to that output's largest value for that photo."""
    worst = 0.0
    for name, value in expected.items():
        assert found[name].shape == value.shape
        # Angles near 0 have no scale of their own: a radian's thousandth is one.
        scale = value.abs().flatten(1).amax(1).clamp(min=1e-3)
        worst = max(worst, float(((found[name] - value).abs().flatten(1).amax(1) / scale).max()))
    return worst


def irradiance(found: Outputs) -> Tensor:
    """[batch, 6, 3]: on surfaces that face +X, +Y, +Z, -X, -Y and -Z."""
    light = Lighting(found["ambient"], found["anchor_energy"])
    return light.irradiance(torch.cat([torch.eye(3), -torch.eye(3)]))


def test_onnxruntime_gives_pytorchs_light(estimator: Estimator, exported: Path) -> None:
    for name, photos in batches(estimator).items():
        assert (
            difference(by_onnxruntime(exported / "mixlight.onnx", photos), by_torch(estimator, photos))
            <= PARITY
        ), name


def test_onnxruntime_web_gives_pytorchs_light(estimator: Estimator, exported: Path, tmp_path: Path) -> None:
    chosen = batches(estimator)
    for name in ("photo", "dark and noise", "photos and noise"):
        found = by_node(exported / "mixlight.onnx", chosen[name], tmp_path)
        assert difference(found, by_torch(estimator, chosen[name])) <= PARITY, name


@pytest.mark.parametrize("precision", [name for name in PRECISIONS if name != "float32"])
def test_narrowed_weights_run_everywhere_and_change_little(
    precision: Any, estimator: Estimator, exported: Path, tmp_path: Path
) -> None:
    import onnx

    proto = onnx.load(exported / "mixlight.onnx")
    store(proto, precision)
    model = tmp_path / "narrow.onnx"
    model.write_bytes(proto.SerializeToString())
    assert model.stat().st_size < {"float16": 0.52, "int8": 0.3}[precision] * (
        (exported / "mixlight.onnx").stat().st_size
    )
    photos = batches(estimator)["photos and noise"][:2]
    native = by_onnxruntime(model, photos)
    expected = irradiance(by_torch(estimator, photos))
    change = (irradiance(native) - expected).abs().amax((1, 2)) / expected.amax((1, 2))
    assert (change > 0).all()
    assert (change <= STORED[precision]).all()
    assert difference(by_node(model, photos, tmp_path), native) <= PARITY


@pytest.mark.parametrize(("mode", "glow"), [*((mode, 0.0) for mode in MODES), ("masked", 4.0)])
def test_every_sparse_layer_is_exported(mode: Any, glow: float) -> None:
    estimator = small_estimator(mode, gain=1.0 if glow else 3.0, glow=glow)
    proto = to_onnx(estimator).SerializeToString()
    for count in (1, 2, 7):
        photos = torch.rand(count, 3, 24, 32, generator=torch.Generator().manual_seed(count))
        expected = by_torch(estimator, photos)
        lit = (expected["anchor_energy"] > 0).any(-1).sum(-1)
        assert int(lit.min()) >= 1
        assert int(lit.max()) < 128
        assert difference(by_onnxruntime(proto, photos), expected) <= PARITY


PAGE = """
import * as ort from 'onnxruntime-web';
import { pack } from 'harness';

export default async ({ files, fov, height }) => {
  const mixlight = await import(files + 'mixlight.mjs');
  ort.env.wasm.numThreads = 1;
  const bitmap = await createImageBitmap(await (await fetch(files + 'photo.png')).blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const image = context.getImageData(0, 0, bitmap.width, bitmap.height);
  const view = mixlight.canonicalView(image.data, image.width, image.height, fov);
  const session = await ort.InferenceSession.create(files + 'mixlight.onnx');
  const outputs = await session.run({ photo: new ort.Tensor('float32', view.data, view.dims) });
  const light = mixlight.decode(outputs.ambient.data, outputs.anchor_energy.data, outputs.camera.data);
  return {
    view: pack(view.data, view.dims),
    photo: pack(image.data, [image.height, image.width, 4]),
    map: pack(mixlight.environment(light, height), [height, 2 * height, 3]),
    pitch: light.pitch,
    roll: light.roll,
    sources: light.sources.length,
    strongest: light.sources[0].direction,
    model: mixlight.MODEL,
  };
};
"""


@pytest.mark.parametrize("example", EXAMPLES[:2], ids=lambda path: path.stem)
def test_a_browser_makes_a_photos_map_by_itself(
    example: Path, estimator: Estimator, exported: Path, tmp_path: Path, web: Web
) -> None:
    """Photo, view, network, light and map, all in Chromium, against the library."""
    from PIL import Image

    folder = tmp_path / "files"
    shutil.copytree(exported, folder)
    photo = read_photo(example)
    with Image.open(example) as image:  # PNG: two JPEG decoders need not agree in the last bit
        image.convert("RGB").save(folder / "photo.png")
    fov = field_of_view(photo).radians
    found = web.run(PAGE, files=folder, fov=fov, height=64)

    expected = estimator.estimate(linear_tensor(photo), fov)
    view = srgb.encode(expected.view).permute(2, 0, 1)[None]
    assert np.abs(found["view"] - view.numpy()).max() < 1e-4
    environment = expected.lighting.environment(64).numpy()
    assert np.abs(found["map"] - environment).max() < 1e-3 * environment.max()
    assert (found["pitch"], found["roll"]) == pytest.approx((expected.pitch, expected.roll), abs=1e-4)
    energy = expected.lighting.energy
    strongest = expected.lighting.axes[int((energy @ torch.tensor([0.2126, 0.7152, 0.0722])).argmax())]
    assert found["strongest"] == pytest.approx(strongest.tolist(), abs=1e-6)
    assert found["sources"] == int((energy > 0).any(-1).sum())
    assert found["model"]["height"] == estimator.model.settings.height
    if example == EXAMPLES[0]:
        hold("onnx", _picture(found["photo"], found["map"]), tolerance=3.0)


DOCS = Path(__file__).parents[2] / "docs/consumers/onnx.md"


def docs_code(language: str) -> list[str]:
    return re.findall(
        rf"^```{language}\n(.*?)^```$", DOCS.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def test_the_docs_python_runs(
    estimator: Estimator, exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(exported, tmp_path / "light/onnx")
    monkeypatch.chdir(tmp_path)
    (block,) = docs_code("python")
    names: dict[str, Any] = {}
    exec(compile(block, DOCS.name, "exec"), names)
    expected = by_torch(
        estimator, torch.full((1, 3, *estimator.view(torch.ones(9, 12, 3), 1.0).shape[:2]), 0.5)
    )
    assert np.abs(names["energy"] - expected["anchor_energy"].numpy()).max() < 1e-4 * names["energy"].max()
    light = Lighting(torch.tensor(names["ambient"][0]), torch.tensor(names["energy"][0]))
    assert np.abs(names["direction"] - light.axes.numpy()).max() < 1e-6


def test_the_docs_javascript_runs(estimator: Estimator, exported: Path, tmp_path: Path, web: Web) -> None:
    """Both blocks of the page in turn, with the URLs of the files put in; three.js adds up the light."""
    from PIL import Image

    folder = tmp_path / "files"
    shutil.copytree(exported, folder)
    with Image.open(EXAMPLES[0]) as image:
        image.convert("RGB").save(folder / "photo.png")
    first, second = docs_code("js")
    head = [line for line in (first + second).splitlines() if re.match(r"import \* as", line)]
    body = [line for line in (first + second).splitlines() if line not in head]
    text = "\n".join(body)
    text = re.sub(
        r'import (\{.*\}) from "\./mixlight\.mjs";', r'const \1 = await import(files + "mixlight.mjs");', text
    )
    text = text.replace('create("mixlight.onnx")', 'create(files + "mixlight.onnx")')
    script = "\n".join(
        [
            *head,
            "export default async ({ files }) => {",
            "ort.env.wasm.numThreads = 1;",
            "const image = await createImageBitmap(await (await fetch(files + 'photo.png')).blob());",
            "const scene = new THREE.Scene();",
            text,
            "const up = new THREE.Vector3(0, 1, 0);",
            "const [probe, ...suns] = scene.children;",
            "const total = probe.sh.getIrradianceAt(up, new THREE.Vector3()).toArray();",
            "for (const { position, color, intensity } of suns) {",
            "  const cosine = Math.max(0, up.dot(position.normalize())) * intensity;",
            "  ['r', 'g', 'b'].forEach((c, k) => { total[k] += cosine * color[c]; });",
            "}",
            "return { total, suns: suns.length };",
            "};",
        ]
    )
    found = web.run(script, files=folder)
    photo = read_photo(EXAMPLES[0])
    light = estimator.estimate(
        linear_tensor(photo), math.radians(60)
    ).lighting  # the field of view it assumes
    assert found["suns"] == int((light.energy > 0).any(-1).sum())
    # A sun is a point here and a lobe of 8 degrees there.
    expected = light.irradiance(torch.tensor([0.0, 1.0, 0.0]))
    assert found["total"] == pytest.approx(expected.tolist(), rel=0.01)


def _picture(photo: np.ndarray, environment: np.ndarray) -> np.ndarray:
    """The photo as the browser decoded it, and the map that it made of it, both as sRGB."""
    from PIL import Image

    height = 192
    width = round(height * photo.shape[1] / photo.shape[0])
    left = np.asarray(Image.fromarray(photo[..., :3]).resize((width, height)))
    shown = np.rint(255 * linear_to_srgb(environment.clip(0, 1))).astype(np.uint8)
    right = np.asarray(Image.fromarray(shown).resize((2 * height, height), Image.Resampling.NEAREST))
    return np.concatenate([left, right], axis=1)
