"""Runs in a Python with bpy and infinigen: its factories make furniture, one OBJ file a piece.

Arguments: a JSON list of pieces (name, module, factory, seed), the folder to write OBJ files into, and the
JSON to write: infinigen's version, for each piece that was made its file and its size in metres (width,
depth, height), and for the others why not.
"""

import importlib
import importlib.metadata
import json
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix

LARGEST = 4.0
"""Metres: what is larger is no furniture but a mistake."""


def main(pieces, folder, report):
    """Make every piece; one that fails is left out and named."""
    found = {"version": importlib.metadata.version("infinigen"), "pieces": {}}
    for piece in pieces:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        try:
            found["pieces"][piece["name"]] = make(piece, folder)
        except Exception as error:  # a factory that fails must not cost the others
            found["pieces"][piece["name"]] = {"error": f"{type(error).__name__}: {error}"}
    with open(report, "w", encoding="utf-8") as file:
        json.dump(found, file)


def make(piece, folder):
    """One piece as an OBJ file with +Y up."""
    np.random.seed(piece["seed"])  # noqa: NPY002 - what the factories draw from
    factory = getattr(importlib.import_module(piece["module"]), piece["factory"])(piece["seed"])
    made = factory.spawn_asset(0)
    meshes = [part for part in (made, *made.children_recursive) if part.type == "MESH"]
    bpy.ops.object.select_all(action="DESELECT")
    for part in meshes:
        part.select_set(True)
    bpy.context.view_layer.objects.active = meshes[0]
    bpy.ops.object.convert(target="MESH")  # applies what its modifiers do
    bpy.ops.object.parent_clear(type="CLEAR_KEEP_TRANSFORM")
    for part in meshes:  # infinigen's furniture looks along +X, ours along -Y
        part.matrix_world = Matrix.Rotation(-np.pi / 2, 4, "Z") @ part.matrix_world
    bpy.context.view_layer.update()
    corners = np.array([part.matrix_world @ vertex.co for part in meshes for vertex in part.data.vertices])
    if not len(corners) or not np.isfinite(corners).all():
        raise ValueError("no finite points")
    size = np.ptp(corners, axis=0)
    if size.min() <= 0 or size.max() > LARGEST:
        raise ValueError(f"a size of {size.round(2).tolist()} m")
    file = os.path.join(folder, f"{piece['name']}.obj")
    bpy.ops.wm.obj_export(
        filepath=file,
        export_selected_objects=True,
        forward_axis="NEGATIVE_Z",
        up_axis="Y",
        export_triangulated_mesh=True,
    )
    return {"file": file, "size": size.round(4).tolist()}


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    with open(arguments[0], encoding="utf-8") as listing:
        main(json.load(listing), arguments[1], arguments[2])
