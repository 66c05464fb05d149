"""The exact spheres against path tracers (docs/evaluation.md)."""

from experiments.tables.cells import SPHERES
from experiments.tables.markdown import table
from experiments.tables.results import Json, Tables, measured


@measured("sphere_accuracy")
def sphere_accuracy(found: Json) -> str:
    """The exact spheres against Cycles, percent of the mean."""
    rows = []
    for scene, entry in found["scenes"].items():
        for name, cells in entry["spheres"].items():
            numbers = [f"{cells[key]:.2f} %" for key in ("error", "worst_error", "noise")]
            rows.append([f"{scene}: {name}", *numbers, f"{cells['mean_ratio']:.4f}"])
    head = ("scene and sphere", "error", "worst map", "noise of the reference", "our mean / Cycles' mean")
    return table(head, rows)


@measured("sphere_accuracy")
def sphere_mitsuba(found: Json) -> str:
    """Means against Mitsuba's."""
    rows = []
    for camera in ("orthographic", "perspective"):
        if camera in found["mitsuba"]:
            means = [sum(values) / len(values) for values in found["mitsuba"][camera].values()]
            rows.append([camera, *(f"{mean:.4f}" for mean in means)])
    return table(("our mean / Mitsuba's mean", *SPHERES), rows)


@measured("sphere_accuracy")
def sphere_basis(found: Json) -> str:
    """What the comparison of the spheres ran on."""
    scenes = "; ".join(
        f"{scene}: {entry['panoramas']} maps of 128×256, {entry['pixels']} pixels, {entry['samples']} samples"
        for scene, entry in found["scenes"].items()
    )
    blender, made = next(iter(found["scenes"].values()))["blender"], found["provenance"]
    return (
        f"Made by `experiments/sphere_accuracy.py`; {scenes} in {len(made['seed'])} seeds; "
        f"Blender {blender}, Mitsuba {found['mitsuba']['version']}; commit `{made['commit']}`; "
        f"{made['machine']}.\n"
    )


TABLES: Tables = {
    "sphere-accuracy": sphere_accuracy,
    "sphere-mitsuba": sphere_mitsuba,
    "sphere-basis": sphere_basis,
}
