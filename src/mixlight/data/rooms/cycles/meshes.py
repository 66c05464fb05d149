"""Runs inside Blender: meshes from arrays."""

import bpy
import numpy as np


def mesh(name, arrays, prefix, material, smooth):
    """An object from the arrays `PREFIX.vertices`, `.corners`, `.starts` and `.uv`."""
    vertices, corners = arrays[f"{prefix}.vertices"], arrays[f"{prefix}.corners"]
    starts, uv = arrays[f"{prefix}.starts"], arrays[f"{prefix}.uv"]
    made = bpy.data.meshes.new(name)
    made.vertices.add(len(vertices))
    made.vertices.foreach_set("co", vertices.ravel())
    made.loops.add(len(corners))
    made.loops.foreach_set("vertex_index", corners)
    made.polygons.add(len(starts))
    made.polygons.foreach_set("loop_start", starts)
    made.polygons.foreach_set("use_smooth", np.full(len(starts), smooth))
    made.update(calc_edges=True)
    made.uv_layers.new(name="uv").data.foreach_set("uv", uv.ravel())
    made.materials.append(material)
    placed = bpy.data.objects.new(name, made)
    bpy.context.scene.collection.objects.link(placed)
    return placed
