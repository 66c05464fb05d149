"""Writes the measured tables of the documentation, so that no number in them is typed by hand.

    python experiments/tables.py

Fills each block between `<!-- table NAME -->` and `<!-- /table -->` of README.md and of the pages below docs
from the JSON files of experiments/results. A block whose file is not there yet is left empty.
`tests/test_docs.py` fails when a block is not what this would write.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results"
SPHERES = ("diffuse", "matte", "mirror")
CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
CELL_NAMES = tuple(f"{sphere} {kind}" for kind in ("RMSE", "si-RMSE") for sphere in SPHERES)
BLOCK = re.compile(r"(<!-- table ([\w-]+) -->\n).*?(<!-- /table -->)", re.DOTALL)

Json = Mapping[str, Any]


def filled(text: str) -> str:
    """The text with every block made anew."""
    return BLOCK.sub(lambda match: match[1] + TABLES[match[2]]() + match[3], text)


def main() -> None:
    """Rewrite the blocks of all pages."""
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))):
        text = page.read_text(encoding="utf-8")
        if BLOCK.search(text):
            page.write_text(filled(text), encoding="utf-8")
            print(page.relative_to(ROOT))


def _representation() -> Json:
    found: Json = json.loads((RESULTS / "representation.json").read_text(encoding="utf-8"))
    return found


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    names = list(head)
    lines = ["| " + " | ".join(row) + " |" for row in (names, ["---"] * len(names), *rows)]
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """Three significant digits; an exponent only where nobody would count the zeros."""
    if value == 0:
        return "0"
    return _plain(value, 3) if abs(value) >= 1e-4 else f"{value:.2g}"


def _percent(value: float) -> str:
    """One decimal, or two significant digits below 1 %."""
    if not value:
        return "0 %"
    return f"{100 * value:.1f} %" if abs(value) >= 0.01 else f"{_plain(100 * value, 2)} %"


def _plain(value: float, digits: int) -> str:
    """That many significant digits, without an exponent."""
    return f"{value:.{max(0, digits - 1 - math.floor(math.log10(abs(value))))}f}"


def _medians(spheres: Json) -> list[str]:
    return [f"{spheres[cell]['median']:.3f}" for cell in CELLS]


def _ratios(cells: Json) -> list[str]:
    """Ratio of errors with its interval; in bold where it is not 1.00 and the interval leaves out 1."""
    entries = []
    for cell in CELLS:
        low, high = cells[cell]["interval_95"]
        text = f"{cells[cell]['ratio']:.2f} ({low:.2f}–{high:.2f})"
        sure = (high < 1 or low > 1) and abs(cells[cell]["ratio"] - 1) >= 0.005
        entries.append(f"**{text}**" if sure else text)
    return entries


def basis() -> str:
    """What was measured on what."""
    found = _representation()
    count, made = found["panoramas"], found["provenance"]
    by_split = ", ".join(f"{len(scenes)} {split}" for split, scenes in count["scenes"].items())
    return (
        f"N = {count['views']} views of {count['count']} panoramas ({by_split}); "
        f"commit `{made['commit'][:10]}`; {made['machine']}; "
        f"Python {made['python']}, torch {made['torch']}.\n"
    )


def separation() -> str:
    """Share, anchors and lights of each rule."""
    rows = []
    for name, entry in _representation()["separation"].items():
        if "spheres" in entry:
            rows.append(
                [
                    f"`{name.split()[0]}` {float(name.split()[1]):.0%}".replace("%", " %"),
                    _spread(entry["share of the sphere"], _percent),
                    _percent(entry["share of the energy"]["median"]),
                    f"{entry['active anchors']['median']:.0f}",
                    f"{entry['lights']['median']:.0f}",
                    *_medians(entry["spheres"]),
                ]
            )
    return _table(("rule", "of the sphere", "of the energy", "anchors", "lights", *CELL_NAMES), rows)


def decision() -> str:
    """The two rules against each other, on the same views."""
    found = _representation()["separation"]
    key = "error ratio of top_fraction 0.05 to max_fraction 0.05"
    rows = [
        ["a colour for each anchor (`mixlight fit`)", *_ratios(found[key])],
        ["one colour for all (as the network predicts)", *_ratios(found["one colour"][key])],
    ]
    return _table(("error of `top_fraction` / error of `max_fraction`", *CELL_NAMES), rows)


def ratios() -> str:
    """What each simplification does to the spheres."""
    found = _representation()
    rows = [
        [
            "ambient light summed without solid angle",
            found["projection"]["error ratio, ambient without to with"],
        ],
        ["nothing weighted by solid angle", found["projection"]["error ratio, nothing with to all with"]],
        ["one colour for all anchors", found["colour"]["error ratio of one colour to per anchor"]],
        ["negative ambient lobes clamped", found["clamping"]["error ratio, clamped to negative kept"]],
        ["... and the rest dimmed to keep the energy", found["clamping"]["error ratio, rescaled to clamped"]],
    ]
    return _table(
        ("change", *CELL_NAMES),
        [[str(name), *_ratios(cells)] for name, cells in rows if isinstance(cells, dict)],
    )


def degree() -> str:
    """Ambient light of other degrees."""
    found = _representation()["ambient degree"]
    names = {
        "degree 1": "degree 1 (4 coefficients)",
        "degree 2": "**degree 2 (9)**",
        "degree 3": "degree 3 (16)",
        "degree 4": "degree 4 (25)",
        "degree 2 without any source": "degree 2 and no sources at all",
    }
    return _table(
        ("ambient light", *CELL_NAMES),
        [[shown, *_medians(found[f"spheres, {key}"])] for key, shown in names.items()],
    )


def sparse() -> str:
    """The sparse layer's modes on noisy distributions."""
    found = _representation()["sparse layer"]
    rows = []
    for sigma in (key for key in found if key.startswith("sigma")):
        for mode, entry in found[sigma].items():
            rows.append(
                [
                    sigma.removeprefix("sigma "),
                    f"`{mode}`",
                    f"{entry['sum']['mean']:.3f} ({entry['sum']['max']:.3f})",
                    f"{entry['active anchors']['median']:.0f}",
                    _number(entry["squared error"]["mean"]),
                    _number(entry["transport"]["mean"]),
                ]
            )
    head = ("noise σ", "mode", "sum: mean (largest)", "active anchors", "squared error", "transport (rad)")
    return _table(head, rows)


def transport() -> str:
    """A unit light on a wrong anchor."""
    found = _representation()["transport"]
    sinkhorn, released = found["Sinkhorn divergence (radians)"], found["EMLight as released"]
    rows = [
        [name, _number(entry["next"]["median"]), _number(entry["antipode"]["median"])]
        for name, entry in (("EMLight's loss as released", released), ("Sinkhorn divergence", sinkhorn))
    ]
    return _table(("all light moved", "to the next anchor", "to the antipode"), rows)


def facts() -> str:
    """Single numbers: what a simplification does before any sphere is rendered."""
    found = _representation()
    projection, normaliser, clamping = found["projection"], found["normaliser"], found["clamping"]
    plain = projection["Gram matrix, 4 pi / (w h), one pole for both"]
    intensity, sparse_layer, exposed = found["intensity"], found["sparse layer"], found["exposure"]
    fitted = found["separation"]["top_fraction 0.05"]
    rows = [
        (
            "Gram matrix under 4π/(wh) Σ (the harmonics' pole at the panorama's), diagonal",
            f"{_number(plain['smallest on the diagonal'])} to {_number(plain['largest on the diagonal'])}",
        ),
        ("the same, largest off the diagonal", _number(plain["largest off the diagonal"])),
        (
            "source energy under the plain sum, over the true one",
            _spread(projection["source energy without over with solid angle"]),
        ),
        ("q with e^(−2s) over q with e^(−2/s), s = 0.0025", f"{normaliser['factor']:.1f}"),
        (
            "integral of one lobe of v = 1 on 128×256, not rescaled",
            f"{normaliser['integral of a lobe on 128x256 with q']:.5f}",
        ),
        (
            "energy of the fit against that of the panorama, largest error",
            _percent(fitted["energy error of the fit"]["max"]),
        ),
        ("E from its 5 % to its 95 % quantile, decades", _number(intensity["decades of E from p5 to p95"])),
        ("E² likewise, decades", _number(intensity["decades of E squared from p5 to p95"])),
        ("length of R = T/E²", _spread(intensity["length of R = T / E squared"])),
        (
            "energy in the wrong colour with one colour for all anchors",
            _spread(found["colour"]["misplaced"], _percent),
        ),
        (
            "sphere where the ambient expansion is negative in a channel",
            _spread(clamping["share of the sphere"], _percent),
        ),
        ("energy that clamping adds", _spread(clamping["energy added"], _percent)),
        (
            "sum of `literal` on standard normal scores",
            _spread(sparse_layer["sum of the literal mode on standard normal scores"]),
        ),
        (
            "largest change that `masked` makes after a softmax",
            f"{sparse_layer['largest change after a softmax']:.1g}",
        ),
        (
            "light target over truth when the gain is taken after the curve x^(1/2.4)",
            _spread(exposed["target over truth"]),
        ),
        (
            "the same, largest over smallest among the views of one panorama",
            _spread(exposed["largest over smallest among the views of one panorama"]),
        ),
    ]
    return _table(("what", "measured: median (5 % to 95 % quantile), or the value"), rows)


def _spread(entry: Json, form: Callable[[float], str] = _number) -> str:
    return f"{form(entry['median'])} ({form(entry['p5'])} to {form(entry['p95'])})"


METHOD_NAMES = {
    "training-mean": "training panoramas' mean light",
    "training-mean-geometric": "the same, at its typical brightness",
    "photo-mean": "photo's mean colour",
    "photo-extended": "photo's pixels, extended",
    "oracle:top_fraction": "oracle, SH2 and 128 lobes (`top_fraction`)",
    "oracle:max_fraction": "oracle, SH2 and 128 lobes (`max_fraction`)",
    "oracle:sh2": "oracle, SH2 alone",
    "oracle:gardner19": "oracle, constant and 3 lamps",
    "oracle:emlight": "oracle, constant and 128 lobes of one colour",
    "mixlight": "**MixLight**",
    "mixlight+detail": "**MixLight** with the photo's pixels (`--detail photo`)",
}


def accuracy() -> str:
    """Protocol M on test photos: the model in the box, the floors and the ceiling."""
    found = _evaluation()
    if not found:
        return ""
    measured = found["protocols"]["M"]
    count, pose = measured["counts"]["indoor"], found["camera"]
    rows = []
    for name, entry in measured["tables"]["indoor"].items():
        cells = [f"{entry[cell]['median']:.3f} ({entry[cell]['mean']:.3f})" for cell in CELLS]
        rows.append([METHOD_NAMES.get(name, name), *cells])
    about = (
        f"Protocol M, {found['split']} split: {count['photos']} photos of {count['panoramas']} indoor "
        "panoramas that were neither trained on nor chosen by. Errors of three spheres, linear, in the "
        "photo's exposure: median (mean).\n"
    )
    camera = (
        f"On {pose['views']} views of the same panoramas with other poses: median error of "
        f"the camera's pitch {pose['pitch_error_deg']:.1f}° (best constant guess "
        f"{pose['constant_pitch_error_deg']:.1f}°), of its roll {pose['roll_error_deg']:.1f}° "
        f"({pose['constant_roll_error_deg']:.1f}°).\n"
    )
    return "\n".join([about, _table(("light", *CELL_NAMES), rows), camera])


def evaluation(letter: str, category: str) -> Callable[[], str]:
    """Means with their intervals: a protocol's table of one category."""

    def table() -> str:
        from mixlight.evaluation.cells import describe
        from mixlight.evaluation.protocols import PROTOCOLS
        from mixlight.evaluation.report import shown as number

        found = _evaluation().get("protocols", {})
        if letter not in found:
            return ""
        measured, rows = found[letter], []
        cells = [cell for cell in PROTOCOLS[letter].cells if not cell.endswith("_geometric")]  # type: ignore[index]
        for name, entry in measured["tables"][category].items():
            shown = []
            for cell in cells:
                digits, values = describe(cell).digits, entry[cell]
                if values["mean"] is None:
                    shown.append("–")
                    continue
                low, high = values["mean_95"]
                mean, low, high = (number(value, digits) for value in (values["mean"], low, high))
                shown.append(f"{mean} ({low} to {high})")
            rows.append([METHOD_NAMES.get(name, name), *shown])
        count = measured["counts"][category]
        units = [describe(cell) for cell in cells]
        heads = [f"{unit.title} [{unit.unit}]" if unit.unit else unit.title for unit in units]
        about = (
            f"{count['photos']} photos of {count['panoramas']} panoramas, {category}; mean (95 % interval).\n"
        )
        return "\n".join([about, _table((f"protocol {letter}", *heads), rows)])

    return table


def evaluation_ratios() -> str:
    """The model's errors over those of the floors, on the same photos."""
    found = _evaluation()
    if not found:
        return ""
    rows = []
    for category in ("indoor", "outdoor"):
        for name, cells in found["protocols"]["M"]["ratios"][category].items():
            if not name.startswith("oracle") and name != "mixlight+detail":
                rows.append([f"{category}: {METHOD_NAMES.get(name, name)}", *_ratios(cells)])
    return _table(("MixLight's error / error of", *CELL_NAMES), rows)


def evaluation_basis() -> str:
    """What the evaluation ran on."""
    found = _evaluation()
    if not found:
        return ""
    made = found["provenance"]
    return (
        f"Made by `experiments/evaluation.py`, split {found['split']}, seed 0 of the intervals; commit "
        f"`{made['commit'][:10]}`; {made['machine']}; Python {made['python']}, torch {made['torch']}.\n"
    )


def _evaluation() -> Json:
    path = RESULTS / "evaluation.json"
    found: Json = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def sphere_accuracy() -> str:
    """The exact spheres against Cycles, percent of the mean."""
    found = _sphere_accuracy()
    rows = []
    for scene, entry in found.get("scenes", {}).items():
        for name, cells in entry["spheres"].items():
            numbers = [f"{cells[key]:.2f} %" for key in ("error", "worst_error", "noise")]
            rows.append([f"{scene}: {name}", *numbers, f"{cells['mean_ratio']:.4f}"])
    head = ("scene and sphere", "error", "worst map", "noise of the reference", "our mean / Cycles' mean")
    return _table(head, rows) if rows else ""


def sphere_mitsuba() -> str:
    """Means against Mitsuba's."""
    found = _sphere_accuracy().get("mitsuba", {})
    rows = []
    for camera in ("orthographic", "perspective"):
        if camera in found:
            means = [sum(values) / len(values) for values in found[camera].values()]
            rows.append([camera, *(f"{mean:.4f}" for mean in means)])
    return _table(("our mean / Mitsuba's mean", *SPHERES), rows) if rows else ""


def sphere_basis() -> str:
    """What the comparison of the spheres ran on."""
    found = _sphere_accuracy()
    if not found:
        return ""
    scenes = "; ".join(
        f"{scene}: {entry['panoramas']} maps of 128×256, {entry['pixels']} pixels, {entry['samples']} samples"
        for scene, entry in found["scenes"].items()
    )
    blender = next(iter(found["scenes"].values()))["blender"]
    return (
        f"Made by `experiments/sphere_accuracy.py`; {scenes} in {len(found['seeds'])} seeds; "
        f"Blender {blender}, Mitsuba {found['mitsuba']['version']}; commit `{found['commit']}`; "
        f"{found['machine']}.\n"
    )


def _sphere_accuracy() -> Json:
    path = RESULTS / "sphere_accuracy.json"
    found: Json = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def trials() -> str:
    """Validation of the training runs that led to the model in the box, at the step that each run chose."""
    path = RESULTS / "trials.json"
    if not path.is_file():
        return ""
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    rows = []
    for trial in found["trials"]:
        cells = [f"{trial['best'][cell]:.3f}" for cell in trial["best"]]
        score = "–" if trial["best_score"] is None else f"{trial['best_score']:.4f}"
        rows.append([trial["run"], f"{trial['best_step']} of {trial['last_step']}", score, *cells])
    names = [cell.replace("/", " ") for cell in found["trials"][0]["best"]]
    return _table(("run", "step", "score", *names), rows)


def glow() -> str:
    """Few sources: the energy of the others given to them, against added to the ambient light."""
    path = RESULTS / "glow.json"
    if not path.is_file():
        return ""
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    cells = [
        (kind, cell)
        for kind in ("real", "rooms")
        for cell in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse")
    ]
    rows = []
    for name, entry in found["variants"].items():
        medians = [f"{entry[kind][cell]['median']:.3f}" for kind, cell in cells]
        rows.append([name, f"{entry['active']:.0f}", f"{100 * entry['kept']:.0f} %", *medians])
    names = [f"{kind} {cell.replace('_', ' ')}" for kind, cell in cells]
    return _table(("variant and gain", "active anchors", "source energy kept", *names), rows)


def onnx() -> str:
    """Size, speed and accuracy of the ONNX file's variants."""
    found = _onnx()
    if not found:
        return ""
    rows = []
    for name, entry in found["variants"].items():
        error = entry["largest_output_error"]
        rows.append(
            [
                f"**`--precision {name}`**" if entry["offered"] else name,
                f"{entry['bytes'] / 1e6:.1f} MB",
                f"{entry['ms']['least']:.1f} ms",
                f"{entry['ms']['ratio']:.2f}",
                f"{entry['web_ms']['least']:.0f} ms" if "least" in entry.get("web_ms", {}) else "–",
                f"{error['ambient']:.1g}",
                f"{error['anchor_energy']:.1g}",
                "0 %" if abs(entry["cost"]) < 5e-5 else f"{100 * entry['cost']:+.2f} %",
            ]
        )
    return _table(
        (
            "variant",
            "file",
            "onnxruntime",
            "of float32",
            "onnxruntime-web",
            "ambient",
            "sources",
            "cost",
        ),
        rows,
    )


def onnx_basis() -> str:
    """What the ONNX variants were measured on."""
    found = _onnx()
    if not found:
        return ""
    made, model = found["versions"], found["model"]
    return (
        f"Model `{model['name']}` (SHA-256 {model['sha256'][:12]}…), {found['views']} views of "
        f"{found['scenes']} scenes of the split `val`; commit `{found['commit']}`, "
        f"onnxruntime {made['onnxruntime']}, torch {made['torch']}.\n"
    )


def _onnx() -> Json:
    path = RESULTS / "onnx.json"
    found: Json = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def insertion() -> str:
    """Objects in photos, under the estimate against under the true panorama."""
    found = _insertion()
    if not found:
        return ""
    rows = [
        [
            f"`{scene}`",
            row["object"],
            *(_number(row[f"object_{name}"]) for name in ("rmse", "si_rmse", "rms_of_truth")),
            _number(row["object_mean_over_true_mean"]),
            _number(row["shadow_rmse"]),
            _number(row["shadow_sum_over_true_sum"]),
        ]
        for scene, row in found["scenes"].items()
    ]
    return _table(
        (
            "photo",
            "object",
            "object RMSE",
            "si-RMSE",
            "rms of the true one",
            "brightness over true",
            "shadow RMSE",
            "depth over true",
        ),
        rows,
    )


def insertion_basis() -> str:
    """What the insertions were measured on."""
    found = _insertion()
    if not found:
        return ""
    weights = found.get("model_commit", "as shipped")
    return (
        f"Model `{found['model']}` ({weights}), {found['samples']} samples, seed {found['seed']}; "
        f"commit `{found['commit']}`.\n"
    )


def _insertion() -> Json:
    path = RESULTS / "insert.json"
    found: Json = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found


def rooms() -> str:
    """Networks trained on real panoramas, on rooms and on both, on the same real test photos."""
    path = RESULTS / "rooms.json"
    if not path.is_file():
        return ""
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    rows = []
    for entry in found["conditions"]:
        row = [entry["label"], str(entry["real"]), str(entry["rooms"]), str(len(entry["seeds"]))]
        for cell in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse"):
            number = entry["cells"][cell]
            low, high = number["interval_95"]
            row.append(f"{number['error']:.3f} ({low:.3f}–{high:.3f})")
        number = entry["cells"]["diffuse_rmse"]
        if "ratio" in number:
            low, high = number["ratio_interval_95"]
            row.append(f"{number['ratio']:.2f} ({low:.2f}–{high:.2f})")
        else:
            row.append("1")
        row.append(" ".join(f"{score:.3f}" for score in entry["validation"]))
        rows.append(row)
    about = (
        f"Protocol {found['protocol']}, {found['split']} split: {found['views']} photos of "
        f"{len(found['panoramas'])} panoramas ({', '.join(found['categories'])}); commit "
        f"`{found['provenance']['commit'][:10]}`; {found['provenance']['machine']}.\n"
    )
    head = (
        *("trained on", "real panoramas", "panoramas of rooms", "seeds"),
        *("diffuse RMSE", "diffuse si-RMSE", "matte RMSE", "diffuse RMSE over real only's"),
        "score on val, by seed",
    )
    return "\n".join([about, _table(head, rows)])


def room_statistics() -> str:
    """The light of rendered rooms beside that of real interiors."""
    from mixlight.data.rooms.stats import LABELS

    path = RESULTS / "room_statistics.json"
    if not path.is_file():
        return ""
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    rows = []
    for name, entry in found["statistics"].items():
        spans = [
            f"{low:.2f} / **{median:.2f}** / {high:.2f}"
            for _, low, median, high, _ in (entry["rooms"], entry["reference"])
        ]
        rows.append([LABELS[name], *spans, entry["median"]])
    head = (
        "25 % / **median** / 75 %",
        f"{found['panoramas']} relightings of {found['rooms']} rooms",
        found["reference"]["name"],
        "the rooms' median",
    )
    made = found["set"]
    about = (
        f"Rooms of the seeds {made['seeds'][0]} to {made['seeds'][1]}, {made['width']}x{made['width'] // 2}, "
        f"{made['cameras']} camera each, {made['samples']} paths a pixel, rendered by `{made['commit']}`; "
        f"{found['recipes']} relightings each, drawn by `{found['provenance']['commit'][:7]}`.\n"
    )
    return "\n".join([about, _table(head, rows)])


def retrained() -> str:
    """Trainings that might go into the box: val, which decides, and test."""
    path = RESULTS / "retrained.json"
    if not path.is_file():
        return ""
    rows = []
    for name, row in json.loads(path.read_text(encoding="utf-8"))["models"].items():
        camera, test = row["camera_on_val"], row["test_medians"]
        rows.append(
            [
                name,
                *(f"{row['val'][key]:.4f}" for key in ("score", "real/score", "rooms/score")),
                *(f"{camera[kind]['pitch_error_deg']:.1f}°" for kind in ("real", "rooms")),
                *(
                    f"{test[c]:.3f}"
                    for c in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse")
                ),
            ]
        )
    head = ("run", "val: score", "real", "rooms", "val: pitch, real", "pitch, rooms")
    tested = ("test: diffuse RMSE", "diffuse si-RMSE", "matte RMSE", "matte si-RMSE")
    return _table((*head, *tested), rows)


def brightness() -> str:
    """How much brighter than a photo the light around it is."""
    path = RESULTS / "brightness.json"
    if not path.is_file():
        return ""
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    rows = []
    for name, row in found["groups"].items():
        low, median, high = (f"{value:.2f}" for value in row["quartiles"])
        rows.append(
            [
                name,
                str(row["panoramas"]),
                f"{low} / **{median}** / {high}",
                f"{row['standard_deviation']:.2f}",
            ]
        )
    head = ("panoramas", "number", "25 % / **median** / 75 %", "standard deviation")
    return f"Commit `{found['provenance']['commit'][:10]}`.\n\n" + _table(head, rows)


def detail() -> str:
    """The photo in the map: errors of the spheres with and without it, on test."""
    found = _detail()
    test = found["test"]
    entry = test["with the photo"]["shipped"]
    rows = []
    for cell, shown in DETAIL_CELLS.items():
        ratio = entry["ratio"][cell]
        rows.append(
            [
                shown,
                f"{test['without'][cell]:.3f}",
                f"{entry['median'][cell]:.3f}",
                _ratio(ratio),
                f"{100 * ratio['views that gain']:.0f} %",
            ]
        )
    head = ("error", "without: median", "with: median", "with / without", "views that gain")
    about = (
        f"N = {test['views']} photos of {test['panoramas']} indoor test panoramas; model "
        f"`{found['provenance']['model']}`, the camera's pose as the model found it; commit "
        f"`{found['provenance']['commit'][:10]}`.\n"
    )
    return "\n".join([about, _table(head, rows)])


def detail_variants() -> str:
    """What was chosen between, on val."""
    found = _detail()["validation"]
    cells = ("diffuse_rmse", "matte_rmse", "mirror_rmse", "mirror_si_rmse", "mirror_seen_shown")
    rows = []
    for kind, group in found.items():
        for name, entry in group["with the photo"].items():
            shown = f"**{name}**" if name == "shipped" else name
            ratios = [_ratio(entry["ratio"][cell]) for cell in cells]
            rows.append([f"{group['views']} views of {group['panoramas']} {kind}", shown, *ratios])
    return _table(("validation", "variant", *(DETAIL_CELLS[cell] for cell in cells)), rows)


DETAIL_CELLS = {
    "diffuse_rmse": "diffuse RMSE",
    "matte_rmse": "matte RMSE",
    "mirror_rmse": "mirror RMSE",
    "mirror_si_rmse": "mirror si-RMSE",
    "mirror_shown": "mirror as a screen shows it",
    "mirror_seen_shown": "the same, where it reflects what the photo shows",
}


def turning() -> str:
    """What a turn by any angle costs, by method."""
    found: Json = json.loads((RESULTS / "turning.json").read_text(encoding="utf-8"))
    cells = {
        "off_deg": ("direction off", lambda value: f"{value:.1f}°"),
        "spread_deg": ("spread", lambda value: f"{value:.1f}°"),
        "energy": ("energy off", _percent_above_rounding),
        "diffuse": ("diffuse sphere", _percent_above_rounding),
        "matte": ("matte sphere", _percent_above_rounding),
        "mirror": ("mirror sphere", _percent_above_rounding),
    }
    rows = [
        [name, *(form(entry[cell]["median"]) for cell, (_, form) in cells.items())]
        for name, entry in found["methods"].items()
    ]
    about = (
        f"Medians over {found['panoramas']} fitted indoor panoramas and "
        f"{len(found['turns_deg'])} turns each; spheres: RMSE over the sphere's own root mean square.\n"
    )
    return "\n".join([about, _table(("lobes", *(shown for shown, _ in cells.values())), rows)])


def _percent_above_rounding(value: float) -> str:
    return _percent(value) if value > 1e-5 else "< 0.001 %"


def _detail() -> Json:
    found: Json = json.loads((RESULTS / "detail.json").read_text(encoding="utf-8"))
    return found


def _ratio(entry: Json) -> str:
    low, high = entry["interval_95"]
    return f"{entry['ratio']:.3f} ({low:.3f}–{high:.3f})"


def ablation(name: str, kind: str, part: str = "whole") -> Callable[[], str]:
    """A table of an ablation's results: `medians`, `ratios` or `basis`."""

    def made() -> str:
        from mixlight.evaluation import ablation_report

        result = _ablation(name)
        if result is None:
            return ""
        if kind == "basis":
            return ablation_report.basis(result) + "\n"
        return str(getattr(ablation_report, kind)(result, part))

    return made


def confirmed() -> str:
    """What each of the paper's comparisons comes to here: the other's error over MixLight's, cell by cell."""
    from mixlight.evaluation.ablation_report import decided

    rows = []
    for experiment, variant, label in CONFIRM:
        result = _ablation(experiment)
        if result is None:
            return ""
        cells = result["variants"][variant]["parts"]["whole"]
        entries = []
        for cell in CELLS:
            found, side = cells["ratio_to_reference"][cell], decided(cells, cell)
            low, high = found["interval_95"]
            word = {1: "yes", -1: "**no**", 0: "open"}[side]
            entries.append(f"{word}: {found['ratio']:.2f} ({low:.2f}–{high:.2f})")
        rows.append([label, *entries])
    return _table(("MixLight is better than", *CELL_NAMES), rows)


CONFIRM = (
    ("baselines", "Gardner19, as published", "Gardner19 (Table 1)"),
    ("baselines", "EMLight, as published", "EMLight, regression stage (Table 1)"),
    ("baselines", "Gardner19, tuned", "Gardner19, tuned"),
    ("baselines", "Gardner19 with our render loss", "Gardner19 with our render loss"),
    ("baselines", "EMLight with our losses", "EMLight with our losses"),
    ("combinations", "SGG (9 SG + 128 SG)", "SGG (Table 2)"),
    ("combinations", "SHH (SH2 + SH6)", "SHH (Table 2)"),
    ("combinations", "SGH (9 SG + SH6)", "SGH (Table 2)"),
    ("sparse", "sparsemax", "sparsemax instead of SLSparsemax (Table 3)"),
    ("sparse", "softmax", "no sparse layer: softmax (Table 3)"),
    ("sparse", "none", "no sparse layer: clamped scores (Table 3)"),
    ("representation", "SGG (9 SG + 128 SG)", "SGG, given the truth"),
    ("representation", "SHH (SH2 + SH6)", "SHH, given the truth"),
    ("representation", "SGH (9 SG + SH6)", "SGH, given the truth"),
)
"""Experiment and variant of each comparison of the paper, and how the table calls it."""


def claims() -> str:
    """The baselines' own claims, and what our data says of them."""
    from mixlight.evaluation.baselines import BASELINES, verdict

    rows = []
    for baseline in BASELINES.values():
        for claim in baseline.claims:
            result = _ablation(claim.experiment)
            if result is None:
                return ""
            found = [verdict(result, claim, cell) for cell in claim.cells]
            words = ", ".join(
                f"{found.count(word)} {word}"
                for word in ("confirmed", "open", "contradicted")
                if word in found
            )
            rows.append([baseline.title, claim.says, f"`{claim.experiment}`", words])
    return _table(("paper", "claim", "experiment", "of four errors (diffuse and matte)"), rows)


def _ablation(name: str) -> Json | None:
    file = RESULTS / "ablations" / f"{name}.json"
    if not file.is_file():
        return None
    found: Json = json.loads(file.read_text(encoding="utf-8"))
    return found


def room_storage() -> str:
    """What each way to store light groups costs: median and 95th percentile."""
    path = RESULTS / "room_storage.json"
    if not path.is_file():
        return ""
    found = json.loads(path.read_text(encoding="utf-8"))
    keys = ("pixels", "energy", "sources", "ambient", "diffuse", "matte", "mirror")

    def share(value: float) -> str:
        return _percent(value) if value >= 1e-4 else "< 0.01 %"

    rows = [
        [name, _plain(cells["megabytes"]["median"], 2)]
        + [f"{share(cells[key]['median'])} ({share(cells[key]['p95'])})" for key in keys]
        for name, cells in found["variants"].items()
    ]
    return _table(["storage", "MB a position", *keys], rows)


TABLES: Mapping[str, Callable[[], str]] = {
    "accuracy": accuracy,
    **{
        f"evaluation-{letter.lower()}-{category}": evaluation(letter, category)
        for letter in ("M", "S", "L")
        for category in ("indoor", "outdoor")
    },
    "evaluation-ratios": evaluation_ratios,
    "evaluation-basis": evaluation_basis,
    "sphere-accuracy": sphere_accuracy,
    "sphere-mitsuba": sphere_mitsuba,
    "sphere-basis": sphere_basis,
    "basis": basis,
    "facts": facts,
    "separation": separation,
    "decision": decision,
    "ratios": ratios,
    "degree": degree,
    "sparse": sparse,
    "transport": transport,
    "trials": trials,
    "glow": glow,
    "room_storage": room_storage,
    "rooms": rooms,
    "room-statistics": room_statistics,
    "brightness": brightness,
    "retrained": retrained,
    "detail": detail,
    "detail-variants": detail_variants,
    "turning": turning,
    "onnx": onnx,
    "onnx-basis": onnx_basis,
    "insertion": insertion,
    "insertion-basis": insertion_basis,
    "confirmed": confirmed,
    "claims": claims,
    **{
        f"ablation-{name.replace('_', '-')}-{kind}": ablation(name, kind)
        for name in (
            "representation",
            "combinations",
            "sparse",
            "losses",
            "baselines",
            "counts",
            "counts_anchors",
            "tuning_mixlight",
            "tuning_gardner19",
            "tuning_emlight",
        )
        for kind in ("medians", "ratios", "basis")
    },
    **{
        f"ablation-{name}-{part}": ablation(name, "medians", part)
        for name in ("representation", "combinations")
        for part in ("ambient", "sources")
    },
}


if __name__ == "__main__":
    main()
