"""Runs inside Blender: saves a library with one object, a cube of half a metre with two materials."""

import sys

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.0, 0.0, 0.25))
stool = bpy.context.object
stool.name = "stool"
for vertex in stool.data.vertices:  # the origin is the middle of its underside
    vertex.co.z += 0.25
stool.location = (0.0, 0.0, 0.0)
for name, alpha in (("body", 1.0), ("glass", 0.2)):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    shader.inputs["Alpha"].default_value = alpha
    stool.data.materials.append(material)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[sys.argv.index("--") + 1])
