"""Runs inside Blender: renders the scene that `mixlight.render.cycles` has laid down in a folder.

    blender --background --python cycles_script.py -- FOLDER

Reads FOLDER/scene.json, its arrays (.npy) and textures (.exr); writes scene.npy, ground.npy, coverage.npy.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix


def main(folder):
    """Render everything that scene.json asks for."""
    job = json.loads((folder / "scene.json").read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    world(scene, folder / "environment.exr")
    camera(scene, job)
    settings(scene, job)
    ground = mesh("ground", folder, {"name": "ground", "uv": True})
    ground.data.materials.append(matte(folder / "ground.exr"))
    parts = []
    for part in job["parts"]:
        made = mesh(part["name"], folder, part)
        made.data.materials.append(principled(folder, part))
        parts.append(made)
    for name, show_ground, show_parts, runs in (
        ("scene", True, True, job["runs"]),
        ("ground", True, False, job["runs"]),
        ("coverage", False, True, 1),
    ):
        ground.hide_render = not show_ground
        for part in parts:
            part.hide_render = not show_parts
        pictures = []
        for run in range(runs):
            scene.cycles.seed = (job["seed"] + run) % 2**31
            scene.cycles.samples = job["samples"] if runs > 1 else job["samples"] * job["runs"]
            pictures.append(render(scene, folder / "picture.exr"))
        np.save(folder / f"{name}.npy", np.stack(pictures))


def world(scene, path):
    """Light from all around."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    nodes.clear()
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image(path)
    background = nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])


def camera(scene, job):
    """The photo's camera, cropped to the region."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "HORIZONTAL"
    data.angle = job["fov_x"]
    data.clip_start, data.clip_end = 1e-3, 1e5
    made = bpy.data.objects.new("camera", data)
    made.matrix_world = Matrix([[*row, 0.0] for row in job["axes"]] + [[0.0, 0.0, 0.0, 1.0]])
    scene.collection.objects.link(made)
    scene.camera = made
    picture, region = scene.render, job["region"]
    picture.resolution_x, picture.resolution_y = job["width"], job["height"]
    picture.resolution_percentage = 100
    picture.use_border = picture.use_crop_to_border = True
    picture.border_min_x = region[0] / job["width"]
    picture.border_max_x = region[2] / job["width"]
    picture.border_min_y = 1 - region[3] / job["height"]
    picture.border_max_y = 1 - region[1] / job["height"]


def settings(scene, job):
    """Plain path tracing with a box filter, no tricks that bias it."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.max_bounces = job["bounces"]
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(scene.cycles, f"{kind}_bounces", job["bounces"])
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.blur_glossy = 0.0
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Raw"
    form = scene.render.image_settings
    form.file_format, form.color_mode, form.color_depth = "OPEN_EXR", "RGBA", "32"
    form.exr_codec = "NONE"


def image(path):
    """A picture of linear values, taken as they are."""
    found = bpy.data.images.load(str(path))
    found.colorspace_settings.name = "Non-Color"
    return found


def mesh(name, folder, part):
    """An object from the arrays of a part."""
    stem = part["name"]
    positions = np.load(folder / f"{stem}.positions.npy")
    normals = np.load(folder / f"{stem}.normals.npy")
    triangles = np.load(folder / f"{stem}.triangles.npy")
    data = bpy.data.meshes.new(name)
    data.from_pydata(positions.tolist(), [], triangles.tolist())
    if part["uv"]:
        uv = np.load(folder / f"{stem}.uv.npy")
        layer = data.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", uv[triangles.ravel()].astype(np.float32).ravel())
    data.polygons.foreach_set("use_smooth", np.ones(len(data.polygons), dtype=bool))
    data.normals_split_custom_set_from_vertices(normals.tolist())
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def material(name, shader):
    """A material with one shader on its surface."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    surface, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return made, tree, surface


def texture(tree, path, extension):
    """A node that reads a picture."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.extension = image(path), extension
    return node


def matte(path):
    """The ground."""
    made, tree, surface = material("ground", "ShaderNodeBsdfDiffuse")
    tree.links.new(texture(tree, path, "EXTEND").outputs["Color"], surface.inputs["Color"])
    return made


def principled(folder, part):
    """The material of a part."""
    made, tree, surface = material(part["name"], "ShaderNodeBsdfPrincipled")
    surface.inputs["Base Color"].default_value = (*part["base_color"], 1.0)
    surface.inputs["Metallic"].default_value = part["metallic"]
    surface.inputs["Roughness"].default_value = part["roughness"]
    if part["base_texture"]:
        node = texture(tree, folder / f"{part['name']}.base.exr", "REPEAT")
        tree.links.new(node.outputs["Color"], surface.inputs["Base Color"])
    if part["surface_texture"]:
        node = texture(tree, folder / f"{part['name']}.surface.exr", "REPEAT")
        split = tree.nodes.new("ShaderNodeSeparateColor")
        tree.links.new(node.outputs["Color"], split.inputs["Color"])
        tree.links.new(split.outputs["Red"], surface.inputs["Metallic"])
        tree.links.new(split.outputs["Green"], surface.inputs["Roughness"])
    return made


def render(scene, path):
    """The picture as [rows, columns, 4], row 0 on top."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    found = image(path)
    width, height = found.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    found.pixels.foreach_get(pixels)
    bpy.data.images.remove(found)
    return pixels.reshape(height, width, 4)[::-1]


main(Path(sys.argv[sys.argv.index("--") + 1]))
