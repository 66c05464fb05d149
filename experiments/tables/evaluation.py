"""The model on test photos, beside floors, baselines and oracles (README.md, docs/evaluation.md)."""

from experiments.tables.cells import CELL_NAMES, CELLS, error_ratios
from experiments.tables.markdown import table
from experiments.tables.results import Json, Table, Tables, made_on, measured
from mixlight.evaluation.cells import describe
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.report import shown as number

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


@measured("evaluation")
def accuracy(found: Json) -> str:
    """Protocol M on test photos: the model in the box, the floors and the ceiling."""
    result = found["protocols"]["M"]
    count, pose = result["counts"]["indoor"], found["camera"]
    rows = []
    for name, entry in result["tables"]["indoor"].items():
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
    return "\n".join([about, table(("light", *CELL_NAMES), rows), camera])


def evaluation(letter: str, category: str) -> Table:
    """Means with their intervals: a protocol's table of one category."""

    @measured("evaluation")
    def made(found: Json) -> str:
        if letter not in found["protocols"]:
            return ""
        result, rows = found["protocols"][letter], []
        cells = [cell for cell in PROTOCOLS[letter].cells if not cell.endswith("_geometric")]  # type: ignore[index]
        for name, entry in result["tables"][category].items():
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
        count = result["counts"][category]
        units = [describe(cell) for cell in cells]
        heads = [f"{unit.title} [{unit.unit}]" if unit.unit else unit.title for unit in units]
        about = (
            f"{count['photos']} photos of {count['panoramas']} panoramas, {category}; mean (95 % interval).\n"
        )
        return "\n".join([about, table((f"protocol {letter}", *heads), rows)])

    return made


@measured("evaluation")
def evaluation_ratios(found: Json) -> str:
    """The model's errors over those of the floors, on the same photos."""
    rows = []
    for category in ("indoor", "outdoor"):
        for name, cells in found["protocols"]["M"]["ratios"][category].items():
            if not name.startswith("oracle") and name != "mixlight+detail":
                rows.append([f"{category}: {METHOD_NAMES.get(name, name)}", *error_ratios(cells)])
    return table(("MixLight's error / error of", *CELL_NAMES), rows)


@measured("evaluation")
def evaluation_basis(found: Json) -> str:
    """What the evaluation ran on."""
    return (
        f"Made by `experiments/evaluation.py`, split {found['split']}, seed 0 of the intervals; "
        f"{made_on(found['provenance'])}.\n"
    )


TABLES: Tables = {
    "accuracy": accuracy,
    **{
        f"evaluation-{letter.lower()}-{category}": evaluation(letter, category)
        for letter in ("M", "S", "L")
        for category in ("indoor", "outdoor")
    },
    "evaluation-ratios": evaluation_ratios,
    "evaluation-basis": evaluation_basis,
}
