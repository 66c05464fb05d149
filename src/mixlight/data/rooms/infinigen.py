"""Furniture that infinigen's factories make, where infinigen is installed: as many chairs as there are seeds.

Infinigen (BSD-3-Clause) needs Blender 4.2 as a Python module, in an environment of its own that
`MIXLIGHT_INFINIGEN_PYTHON` names. It is never imported here: a script in that environment writes OBJ files.
"""

from __future__ import annotations

import json
import os
from importlib import resources
from pathlib import Path

from mixlight.blender.program import run
from mixlight.data.rooms.assets import AssetsError, Model

__all__ = ["FACTORIES", "VARIABLE", "check", "infinigen_python", "make"]

VARIABLE = "MIXLIGHT_INFINIGEN_PYTHON"
"""Names the Python that can import bpy and infinigen."""

_NEEDS = (
    "trimesh tqdm gin-config opencv-python-headless matplotlib scikit-learn psutil scikit-image OpenEXR "
    "shapely rtree"
)

_OBJECTS = "infinigen.assets.objects."

FACTORIES: tuple[tuple[str, str, str], ...] = (
    ("chair", "seating.chairs.chair", "ChairFactory"),
    ("bar_stool", "seating.chairs.bar_chair", "BarChairFactory"),
    ("sofa", "seating.sofa", "SofaFactory"),
    ("armchair", "seating.sofa", "ArmChairFactory"),
    ("low_shelf", "shelves.simple_bookcase", "SimpleBookcaseFactory"),
    ("shelf", "shelves.large_shelf", "LargeShelfFactory"),
    ("low_shelf", "shelves.cell_shelf", "CellShelfFactory"),
    ("cabinet", "shelves.single_cabinet", "SingleCabinetFactory"),
    ("desk", "shelves.simple_desk", "SimpleDeskFactory"),
    ("table", "tables.dining_table", "TableDiningFactory"),
    ("side_table", "tables.dining_table", "SideTableFactory"),
    ("coffee_table", "tables.dining_table", "CoffeeTableFactory"),
    ("bar_table", "tables.cocktail_table", "TableCocktailFactory"),
    ("vase", "table_decorations.vase", "VaseFactory"),
)
"""Kind of furniture, module below infinigen's objects, and factory."""


def infinigen_python() -> Path | None:
    """The Python that has infinigen; None where none is named.

    Raises:
        AssetsError: the variable names nothing that can be run.
    """
    named = os.environ.get(VARIABLE)
    if not named:
        return None
    path = Path(named).expanduser()
    if not (path.is_file() and os.access(path, os.X_OK)):
        raise AssetsError(f"{VARIABLE}: expected a Python with bpy and infinigen, {path} is no program")
    return path.absolute()


def check() -> Path:
    """The Python that has infinigen.

    Raises:
        AssetsError: none is named; the message says how to get one.
    """
    python = infinigen_python()
    if python is None:
        raise AssetsError(
            f"expected infinigen, but {VARIABLE} names no Python that has it. It needs an environment of its "
            'own: python3.11 -m venv FOLDER && FOLDER/bin/python -m pip install "bpy==4.2.0" "numpy<2" '
            f"{_NEEDS} && FOLDER/bin/python -m pip install --no-deps infinigen"
        )
    return python


def make(count: int, folder: Path, *, timeout: float = 3600.0) -> list[Model]:
    """Let every factory make some pieces; what one fails at is left out.

    Args:
        count: of each factory, with the seeds 0, 1, ...
        folder: where the OBJ files go.
        timeout: seconds for all of them; a piece takes a few.

    Raises:
        AssetsError: no infinigen, or it made nothing.
        BlenderError: its Python failed as a whole.
    """
    python = check()
    pieces = {
        f"infinigen-{factory.lower()}-{seed}": (kind, module, factory, seed)
        for kind, module, factory in FACTORIES
        for seed in range(count)
    }
    listing, report = folder / "infinigen.json", folder / "infinigen-report.json"
    listing.write_text(
        json.dumps(
            [
                {"name": name, "module": _OBJECTS + module, "factory": factory, "seed": seed}
                for name, (_, module, factory, seed) in pieces.items()
            ]
        ),
        encoding="utf-8",
    )
    script = resources.files("mixlight.data.rooms").joinpath("cycles", "infinigen_furniture.py")
    with resources.as_file(script) as path:
        run(path, [listing, folder, report], timeout=timeout, blender=python)
    answer = json.loads(report.read_text(encoding="utf-8"))
    made = [
        Model(
            name=name,
            kind=kind,
            file=Path(answer["pieces"][name]["file"]),
            size=tuple(answer["pieces"][name]["size"]),
            rotation=None,
            top=None,
            elevation=None,
            title=f"{factory}({seed})",
            creator="",
            licence="BSD-3-Clause",
            source=f"infinigen {answer['version']}",
        )
        for name, (kind, _, factory, seed) in pieces.items()
        if "error" not in answer["pieces"][name]
    ]
    if not made:
        first = next(iter(answer["pieces"].values()))["error"]
        raise AssetsError(f"infinigen made nothing of what it was asked for; the first one: {first}")
    return made
