"""Runs inside Blender: the sky, the sun, and the windows that let them in."""

import bpy
from mathutils import Matrix, Vector
from nodes import Tree


def sky(scene, path):
    """A panorama all around, in Blender's own orientation, of radiance as it is."""
    scene.world = bpy.data.worlds.new("sky")
    scene.world.lightgroup = "sky"
    tree = Tree(scene.world)
    tree.is_world = True
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Linear Rec.709"
    texture = tree.add("ShaderNodeTexEnvironment", {"image": image})
    background = tree.add("ShaderNodeBackground", Color=texture.outputs["Color"], Strength=1.0)
    tree.surface(background.outputs[0])
    scene.world.cycles.sampling_method = "MANUAL"
    scene.world.cycles.sample_map_resolution = 512


def sun(scene, given):
    """Parallel light; `irradiance` is on a plane that faces it."""
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy = max(given["irradiance"])
    lamp.color = [channel / lamp.energy for channel in given["irradiance"]]
    lamp.angle = given["angle"]
    placed = bpy.data.objects.new("sun", lamp)
    placed.rotation_mode = "QUATERNION"
    placed.rotation_quaternion = Vector(given["direction"]).to_track_quat("Z", "Y")  # shines along its -Z
    placed.lightgroup = "sun"
    placed.visible_camera = True
    scene.collection.objects.link(placed)


def portal(scene, given):
    """An opening to look for the sky through."""
    lamp = bpy.data.lights.new("portal", "AREA")
    lamp.shape = "RECTANGLE"
    lamp.size, lamp.size_y = given["width"], given["height"]
    lamp.cycles.is_portal = True
    placed = bpy.data.objects.new("portal", lamp)
    placed.matrix_world = Matrix(given["matrix"])
    scene.collection.objects.link(placed)
