"""Runs inside Blender: loads lights as their users would and renders what shows them, with one thread.

    python blender_stage.py -- JOBS.json

JOBS.json is a list of {"load": ["script" | "usd", PATH], "turn": radians, "shots": [{"file", "kind", ...}],
"lights": FILE}; every job begins with Blender's own first scene, emptied. Shots are 32-bit OpenEXR, or PNG
through a view transform.
"""

import json
import math
import runpy
import sys
from pathlib import Path

import bpy
from mathutils import Vector

AHEAD = (0.0, 1.0, 0.0)


def main():
    for job in json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text()):
        bpy.ops.wm.read_factory_settings(use_empty=False)  # the scene that Blender opens with
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        load(*job["load"])
        if "turn" in job:
            bpy.data.objects["MixLight"].rotation_euler[2] = job["turn"]
        for shot in job["shots"]:
            shoot(**shot)
        if "lights" in job:
            Path(job["lights"]).write_text(json.dumps(lights()))


def load(how, path):
    if how == "script":
        folder = Path(path)
        before = sys.argv
        sys.argv = [str(folder / "open_in_blender.py")]  # as a user would: it finds its folder by itself
        try:
            runpy.run_path(sys.argv[0], run_name="__main__")
        finally:
            sys.argv = before
    elif how == "usd":
        bpy.ops.wm.usd_import(filepath=path)


def lights():
    """What the outliner and the light tabs show."""
    found = []
    things = list(bpy.context.scene.objects)
    hidden = {thing.name: [thing.hide_render, thing.hide_viewport] for thing in things}
    for thing in things:
        thing.hide_viewport = False  # where a hidden one stands is not worked out
    bpy.context.view_layer.update()
    for thing in things:
        if thing.type == "LIGHT":
            outward = thing.matrix_world.to_3x3() @ Vector((0, 0, 1))
            found.append(
                {
                    "name": thing.name,
                    "kind": thing.data.type,
                    "direction": list(outward.normalized()),
                    "irradiance": [thing.data.energy * part for part in thing.data.color],
                    "angle": thing.data.angle,
                    "hidden": hidden[thing.name],
                }
            )
    return found


def shoot(file, kind, size=64, samples=16, transform=None, **options):
    """Render one picture, and take away again what was needed for it."""
    scene = bpy.context.scene
    before = set(bpy.data.objects)
    width, height = (2 * size, size) if kind == "panorama" else (size, size)
    data = bpy.data.cameras.new("camera")
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    look(camera, AHEAD)
    if kind == "panorama":
        data.type = "PANO"
        (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
    elif kind == "view":
        data.angle = math.radians(options.get("fov_deg", 90))
        if "pitch_deg" in options:
            camera.rotation_euler[0] += math.radians(options["pitch_deg"])
    elif kind == "sphere":
        bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128)
        matte(bpy.context.object, options["albedo"])
        bpy.ops.object.shade_smooth()
        data.type, data.ortho_scale = "ORTHO", 2.0
        camera.location = (0, -5, 0)
    elif kind == "patch":
        towards = Vector(options["towards"]).normalized()
        bpy.ops.mesh.primitive_plane_add(size=2)
        patch = bpy.context.object
        patch.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
        matte(patch, options["albedo"])
        data.type, data.ortho_scale = "ORTHO", 1.0
        camera.location = 3 * towards
        look(camera, -towards)
    elif kind == "still_life":
        still_life()
        data.angle = math.radians(38)
        camera.location = (0, -6.4, 2.0)
        look(camera, (0, 1, -0.25))
    render(scene, file, width, height, samples, transform)
    for thing in set(bpy.data.objects) - before:
        bpy.data.objects.remove(thing)


def still_life():
    """Three balls on a table: what a picture for the docs is made of."""
    bpy.ops.mesh.primitive_plane_add(size=7)
    matte(bpy.context.object, 0.35)
    for place, (metallic, roughness, value) in enumerate(((0, 1, 0.7), (1, 0.3, 0.8), (1, 0, 0.9))):
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=96, ring_count=48, radius=0.6, location=(1.4 * place - 1.4, 0, 0.6)
        )
        bpy.ops.object.shade_smooth()
        material = bpy.data.materials.new("ball")
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (value, value, value, 1)
        shader.inputs["Metallic"].default_value = metallic
        shader.inputs["Roughness"].default_value = roughness
        bpy.context.object.data.materials.append(material)


def render(scene, file, width, height, samples, transform):
    settings = scene.render
    settings.engine = "CYCLES"
    settings.threads_mode, settings.threads = "FIXED", 1
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = width, height, 100
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, 1
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    if transform is None:
        settings.image_settings.file_format = "OPEN_EXR"
        settings.image_settings.color_mode, settings.image_settings.color_depth = "RGB", "32"
    else:
        settings.image_settings.file_format = "PNG"
        settings.image_settings.color_mode, settings.image_settings.color_depth = "RGB", "8"
        scene.view_settings.view_transform = transform
        scene.view_settings.look = "None"
        settings.dither_intensity = 0.0
    settings.filepath = file
    bpy.ops.render.render(write_still=True)


def look(camera, direction):
    """Turn the camera to a direction; up is +Z, and +Y for one that looks straight up or down."""
    camera.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()


def matte(thing, albedo):
    material = bpy.data.materials.new("matte")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (albedo, albedo, albedo, 1)
    links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    thing.data.materials.append(material)


if __name__ == "__main__":
    main()
