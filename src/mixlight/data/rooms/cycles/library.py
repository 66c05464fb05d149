"""Runs inside Blender: objects of the furniture library, placed and recoloured."""

import bpy
import numpy as np
import patterns  # noqa: F401 - a surface of unknown kind fails in the same words everywhere
from mathutils import Matrix

FARTHEST = 1e4
"""Texture coordinates beyond are garbage of the object's file; Cycles mixes texels there with weights of a
million, and the picture shines like a furnace."""


def place(scene, path, placements):
    """Append the objects by name and put a copy of each at its matrices."""
    if not placements:
        return
    wanted = sorted({placement["name"] for placement in placements})
    with bpy.data.libraries.load(str(path)) as (there, here):
        missing = [name for name in wanted if name not in set(there.objects)]
        if missing:
            raise ValueError(f"{path}: expected the objects {', '.join(missing)}, found none of the name")
        here.objects = list(wanted)
    originals = dict(zip(wanted, here.objects, strict=True))
    for original in originals.values():
        mend(original.data)
    for placement in placements:
        made = originals[placement["name"]].copy()
        made.matrix_world = Matrix(placement["matrix"])
        scene.collection.objects.link(made)
        recolour(made, placement["surfaces"])


def mend(mesh):
    """Put texture coordinates that no picture can be meant by to 0."""
    for layer in mesh.uv_layers:
        values = np.empty(2 * len(layer.uv), np.float32)
        layer.uv.foreach_get("vector", values)
        bad = ~(np.abs(values) < FARTHEST)  # NaN, too
        if bad.any():
            values[bad] = 0.0
            layer.uv.foreach_set("vector", values)


def recolour(placed, surfaces):
    """Give the object's plain materials, in their order, the surfaces' colours; what has a picture or lets
    light through stays.
    """
    left = list(surfaces)
    done = {}
    for slot in placed.material_slots:
        if slot.material is None or (not left and slot.material.name not in done):
            continue
        name = slot.material.name
        if name not in done:
            shader = plain(slot.material)
            if shader is None:
                continue
            done[name] = recoloured(slot.material, left.pop(0))
        slot.link = "OBJECT"
        slot.material = done[name]


def plain(material):
    """The Principled node of an opaque material without pictures, or none."""
    if not material.node_tree:
        return None
    nodes = material.node_tree.nodes
    if any(node.type == "TEX_IMAGE" for node in nodes):
        return None
    shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    clear = shader is None or shader.inputs["Alpha"].default_value < 0.9
    return None if clear or shader.inputs["Transmission Weight"].default_value > 0.1 else shader


def recoloured(material, surface):
    """A copy of the material in the surface's colour."""
    made = material.copy()
    shader = plain(made)
    shader.inputs["Base Color"].default_value = (*surface["colour"], 1.0)
    shader.inputs["Roughness"].default_value = surface["roughness"]
    shader.inputs["Metallic"].default_value = surface["metallic"]
    return made
