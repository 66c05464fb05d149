"""Runs inside Blender: OBJ models become one .blend file of objects in metres, each a single mesh.

Arguments: a JSON list of models (name, file, size in metres, rotation or null), the .blend to write, and the
JSON to write: for each model that was made its faces, whether it has pictures, and for the others why not.
"""

import json
import sys

import bpy
import numpy as np
from mathutils import Matrix

MOST_FACES = 30_000
"""A model with more is thinned: it is furniture of a room, not a portrait."""

MOST_PIXELS = 512
"""Longest side of a picture on a model."""

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From the models' axes (+Y up) to Blender's."""


def main(models, blend, report):
    """Import every model; one that cannot be read is left out and named."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    found = {}
    for model in models:
        try:
            found[model["name"]] = convert(model)
        except Exception as error:  # a broken model must not cost the others
            found[model["name"]] = {"error": f"{type(error).__name__}: {error}"}
    drop_broken_pictures()
    for model in models:
        made = bpy.data.objects.get(model["name"])
        if made is not None:
            made.use_fake_user = True
            found[model["name"]] |= {"textured": textured(made)}
    for scene in bpy.data.scenes:
        for placed in list(scene.collection.objects):
            scene.collection.objects.unlink(placed)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.ops.wm.save_as_mainfile(filepath=blend, compress=True)
    with open(report, "w", encoding="utf-8") as file:
        json.dump(found, file)


def convert(model):
    """One OBJ file as one object of the given name and size, standing on its origin."""
    before = set(bpy.data.objects)
    bpy.ops.wm.obj_import(
        filepath=model["file"], forward_axis="NEGATIVE_Z", up_axis="Y", validate_meshes=True
    )
    imported = [made for made in bpy.data.objects if made not in before]
    meshes = [made for made in imported if made.type == "MESH" and len(made.data.polygons)]
    if not meshes:
        raise ValueError("no faces")
    bpy.ops.object.select_all(action="DESELECT")
    for made in meshes:
        made.select_set(True)
    bpy.context.view_layer.objects.active = meshes[0]
    if len(meshes) > 1:
        bpy.ops.object.join()
    made = bpy.context.view_layer.objects.active
    made.data.transform(made.matrix_world)
    made.matrix_world = Matrix.Identity(4)
    if model["rotation"] is not None:
        turned = Y_UP @ np.array(model["rotation"]).reshape(3, 3) @ Y_UP.T
        made.data.transform(Matrix(turned.tolist()).to_4x4())
    if len(made.data.polygons) > MOST_FACES:
        thin = made.modifiers.new("thin", "DECIMATE")
        thin.ratio = MOST_FACES / len(made.data.polygons)
        bpy.ops.object.modifier_apply(modifier=thin.name)
    points = np.empty(len(made.data.vertices) * 3, np.float32)
    made.data.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3).astype(np.float64)
    low, high = points.min(0), points.max(0)
    if not np.isfinite(points).all() or (high - low).max() <= 0:
        raise ValueError("no extent")
    base = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    points = (points - base) * (np.array(model["size"]) / np.maximum(high - low, 1e-9))
    made.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    made.data.update()
    made.name = made.data.name = model["name"]
    if made.name != model["name"]:
        raise ValueError(f"the name is taken: {made.name}")
    return {"faces": len(made.data.polygons), "materials": len(made.data.materials)}


def drop_broken_pictures():
    """Pictures that cannot be read go, with the nodes that show them (else they render magenta); the others
    are taken into the file, small.
    """
    broken = set()
    for image in bpy.data.images:
        try:
            if max(image.size) == 0:
                broken.add(image.name)
                continue
            if max(image.size) > MOST_PIXELS:
                share = MOST_PIXELS / max(image.size)
                image.scale(max(1, int(image.size[0] * share)), max(1, int(image.size[1] * share)))
            image.pack()
        except RuntimeError:
            broken.add(image.name)
    for material in bpy.data.materials:
        if not material.node_tree:
            continue
        for node in list(material.node_tree.nodes):
            if node.type == "TEX_IMAGE" and (node.image is None or node.image.name in broken):
                material.node_tree.nodes.remove(node)


def textured(made):
    """Whether a picture is on it."""
    return any(
        node.type == "TEX_IMAGE"
        for slot in made.material_slots
        if slot.material is not None and slot.material.node_tree
        for node in slot.material.node_tree.nodes
    )


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    with open(arguments[0], encoding="utf-8") as file:
        listed = json.load(file)
    main(listed, arguments[1], arguments[2])
