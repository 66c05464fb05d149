"""Runs inside Blender: renders the test spheres that `mixlight.render.cycles_spheres` asks for in a folder.

    blender --background --python cycles_spheres_script.py -- FOLDER

Reads FOLDER/job.json and FOLDER/maps.npy, [maps, rows, columns, 3]; writes FOLDER/pictures.npy, [maps,
spheres, rows, columns, 4], and FOLDER/report.json.
"""

import json
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix


def main(folder):
    """Render every sphere under every map."""
    job = json.loads((folder / "job.json").read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    settings(scene, job)
    camera(scene, job["camera"])
    texture = world(scene)
    wear = sphere(scene)
    materials = [material(values) for values in job["materials"]]
    pictures, seconds, processor = [], [], []
    for values in np.load(folder / "maps.npy"):
        texture.image = panorama(values)
        for made in materials:
            wear.inputs["Material"].default_value = made
            start = time.perf_counter(), time.process_time()
            pictures.append(render(scene, folder / "picture.exr"))
            seconds.append(time.perf_counter() - start[0])
            processor.append(time.process_time() - start[1])
        bpy.data.images.remove(texture.image)
    stacked = np.stack(pictures)
    np.save(folder / "pictures.npy", stacked.reshape(-1, len(materials), *stacked.shape[1:]))
    report = {"version": bpy.app.version_string, "seconds": seconds, "processor_seconds": processor}
    (folder / "report.json").write_text(json.dumps(report))


def settings(scene, job):
    """Plain path tracing with a box filter, no tricks that bias it, and nothing behind the sphere."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = job["samples"], job["seed"]
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    cycles.max_bounces = 2  # a sphere alone lights nothing of itself
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = cycles.blur_glossy = 0.0
    scene.render.film_transparent = True
    if job["threads"]:
        scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.view_settings.view_transform = "Raw"
    form = scene.render.image_settings
    form.file_format, form.color_mode, form.color_depth = "OPEN_EXR", "RGBA", "32"
    form.exr_codec = "NONE"


def camera(scene, job):
    """The camera and the size of its picture."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "HORIZONTAL"
    if job["fov_x"] is None:
        data.type, data.ortho_scale = "ORTHO", job["span"]
    else:
        data.angle = job["fov_x"]
    data.clip_start, data.clip_end = 1e-2, 1e3
    made = bpy.data.objects.new("camera", data)
    columns = zip(*job["axes"], job["position"], strict=True)
    made.matrix_world = Matrix([*columns, (0.0, 0.0, 0.0, 1.0)])
    scene.collection.objects.link(made)
    scene.camera = made
    picture = scene.render
    picture.resolution_x, picture.resolution_y = job["width"], job["height"]
    picture.resolution_percentage = 100


def world(scene):
    """Light from all around; the texture node that the maps go into."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    nodes.clear()
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.interpolation = "Linear"
    background, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])
    return texture


def sphere(scene):
    """A true sphere of radius 1, which Cycles makes of a point; the node that says what it is made of.

    A mesh would have facets at its outline, and shadows between them where light grazes it.
    """
    mesh = bpy.data.meshes.new("sphere")
    mesh.from_pydata([(0.0, 0.0, 0.0)], [], [])
    made = bpy.data.objects.new("sphere", mesh)
    scene.collection.objects.link(made)
    tree = bpy.data.node_groups.new("sphere", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    points, wear = tree.nodes.new("GeometryNodeMeshToPoints"), tree.nodes.new("GeometryNodeSetMaterial")
    points.inputs["Radius"].default_value = 1.0
    tree.links.new(start.outputs["Geometry"], points.inputs["Mesh"])
    tree.links.new(points.outputs["Points"], wear.inputs["Geometry"])
    tree.links.new(wear.outputs["Geometry"], end.inputs["Geometry"])
    made.modifiers.new("sphere", "NODES").node_group = tree
    return wear


def material(values):
    """A material with one shader node, its inputs set by name."""
    made = bpy.data.materials.new(values["shader"])
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    surface, output = tree.nodes.new(values["shader"]), tree.nodes.new("ShaderNodeOutputMaterial")
    if values["distribution"]:
        surface.distribution = values["distribution"]
    for name, value in values["inputs"].items():
        surface.inputs[name].default_value = value
    tree.links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return made


def image(path):
    """A picture of linear values, taken as they are."""
    found = bpy.data.images.load(str(path))
    found.colorspace_settings.name = "Non-Color"
    return found


def panorama(values):
    """A map as a picture in full floats."""
    height, width, _ = values.shape
    made = bpy.data.images.new("map", width, height, float_buffer=True)
    made.colorspace_settings.name = "Non-Color"
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = values[::-1]
    made.pixels.foreach_set(pixels.ravel())
    made.update()
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
