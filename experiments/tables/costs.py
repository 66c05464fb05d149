"""What things cost (benchmarks/README.md, docs/rooms.md)."""

from benchmarks.report import HEAD, basis, cells
from experiments.tables.markdown import table
from experiments.tables.results import Json, Tables, measured

_WORK = {
    "host": "plan, files, packing (MixLight)",
    "build": "scene (Blender)",
    "render": "light paths (Cycles)",
    "denoise": "denoising of every group, and raw files (Blender)",
}


_USUAL = {"width": 1024, "samples": 16}
"""Of `benchmarks.rooms`."""


@measured("benchmarks")
def benchmarks(found: Json) -> str:
    """Ratios of `python -m benchmarks`, and what they were measured on."""
    rows = found["rows"]
    made = sorted({basis(row["provenance"]) for row in rows.values()})
    return table(HEAD, (cells(name, row) for name, row in rows.items())) + "\n" + "\n".join(made) + "\n"


@measured("rooms_cost")
def rooms_cost(found: Json) -> str:
    """Core-seconds of a rendered room by kind of work."""
    spent = found["core_seconds"]
    total = sum(spent.values())
    rows = [
        [name, f"{spent[kind]:.2f}", f"{100 * spent[kind] / total:.1f} %"] for kind, name in _WORK.items()
    ]
    rows.append(
        ["all", f"{total:.2f}", f"{found['panoramas_an_hour_and_core']:.0f} panoramas an hour and core"]
    )
    other, limit = found["share_not_cycles"], found["limit"]
    verdict = "met" if other <= limit else "not met"
    more = "".join(f" --{key} {found[key]}" for key in ("width", "samples") if found[key] != _USUAL[key])
    begin = f"--seed {found['provenance']['seed']} --count {found['count']}{more}"
    size = f"{found['width']} x {found['width'] // 2}, {found['samples']} paths a pixel"
    return (
        f"{found['rooms']} rooms, one panorama each, {size}, in core-seconds a panorama "
        f"(`python -m benchmarks.rooms {begin}`). "
        f"{basis(found['provenance'])}\n\n"
        + table(("work", "core-seconds", "share"), rows)
        + f"\nNot Cycles: {100 * other:.1f} %; at most {100 * limit:g} % is wanted: {verdict}.\n"
    )


@measured("spheres_cost")
def spheres_cost(found: Json) -> str:
    """The exact spheres against Cycles at equal error."""
    rows = [
        [
            name,
            f"{row['our_error_percent']:.2f} %",
            f"{row['samples_for_it']}",
            f"{row['cycles_seconds']:.0f} s",
        ]
        for name, row in found["spheres"].items()
    ]
    return (
        table(("sphere", "our error", "samples of Cycles for it", "processor time of Cycles a map"), rows)
        + f"\nExact spheres: {found['maps_per_processor_second']:.0f} maps a processor second, all three "
        f"together, {_two(found['ratio'])} times as many as Cycles. At 1024 samples Cycles takes "
        f"{found['cycles_seconds_of_1024_samples']:.0f} s a map. Blender {found['blender']}. "
        f"{basis(found['provenance'])}\n"
    )


def _two(value: float) -> str:
    """Two significant digits of a large number."""
    return f"{float(f'{value:.2g}'):,.0f}"


TABLES: Tables = {"benchmarks": benchmarks, "rooms-cost": rooms_cost, "spheres-cost": spheres_cost}
