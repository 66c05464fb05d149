"""The light of a photo as a Blender scene: one world, named Suns, and an empty that turns them together.

This file is a module of MixLight's extension and, copied beside a `rig.json` as `open_in_blender.py`, a
script of its own:

    blender --python open_in_blender.py
    blender --python open_in_blender.py -- FOLDER

or: Scripting workspace, open this file, run it. It adds to the open scene and removes nothing but the
MixLight of an earlier run. Works in Blender 4.2 LTS to 5.x.

Axes are Blender's: +X right, +Y ahead of the photo's camera, +Z up. Radiance 1 is the photo's linear white.
"""

import json
import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

RIG = "mixlight_rig"
"""Custom property of the empty: what the map holds, "residual" or "full"."""
EXPOSURE = "mixlight_exposure_ev"
"""Custom property of the empty: the exposure that strengths are multiplied by, in stops."""
PREVIOUS = "mixlight_previous_world"
"""Custom property of the empty: the world that the scene had before."""
ENERGY = "mixlight_energy"
"""Custom property of a Sun: its strength as estimated."""
RANK = "mixlight_rank"
"""Custom property of a Sun: its place among the lights, the brightest first."""
BACKGROUND = "MixLight Background"
"""Name of the world's node whose strength scales the map."""

_DISTANCE = 4.0  # where Suns and their lines are drawn; a Sun lights the same from everywhere


def read_rig(folder):
    """Read `rig.json`, made by `mixlight export --for blender`, and check it.

    Args:
        folder: a path, with `environment.exr` beside the document.

    Returns:
        The document; directions in Blender's axes.

    Raises:
        ValueError: no such document, saying what was expected; OSError: it cannot be read.
    """
    folder = Path(folder)
    path = folder / "rig.json"
    try:
        rig = json.loads(path.read_bytes())
        check_rig(rig)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: {error}") from None
    if not (folder / "environment.exr").is_file():
        raise ValueError(f"{folder}: expected environment.exr beside rig.json, received none")
    return rig


def check_rig(rig):
    """Refuse what is no rig in Blender's axes, naming the entry, what was expected and what received."""
    if not isinstance(rig, dict) or rig.get("format") != "mixlight/rig" or rig.get("version") != 1:
        raise ValueError("expected a document of the format mixlight/rig, version 1")
    if rig.get("frame") != "blender":
        raise ValueError(f"frame: expected 'blender', received {rig.get('frame')!r}")
    if rig.get("map") not in ("residual", "full"):
        raise ValueError(f"map: expected 'residual' or 'full', received {rig.get('map')!r}")
    if not isinstance(rig.get("lights"), list):
        raise ValueError("lights: expected a list")
    for place, light in enumerate(rig["lights"]):
        where = f"lights[{place}]"
        if not isinstance(light, dict) or not isinstance(light.get("name"), str):
            raise ValueError(f"{where}: expected an object with a name")
        for key in ("direction", "irradiance"):
            value = light.get(key)
            if not (isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))):
                raise ValueError(f"{where}.{key}: expected three numbers, received {value!r}")
        if not 0.99 < math.hypot(*light["direction"]) < 1.01:
            raise ValueError(f"{where}.direction: expected a length of 1, received {light['direction']}")
        if min(light["irradiance"]) < 0:
            raise ValueError(
                f"{where}.irradiance: expected no negative number, received {light['irradiance']}"
            )
        if not (_is_number(light.get("angular_diameter_deg")) and 0 < light["angular_diameter_deg"] <= 360):
            raise ValueError(f"{where}.angular_diameter_deg: expected an angle, received one out of range")
        if not isinstance(light.get("enabled"), bool):
            raise ValueError(f"{where}.enabled: expected true or false")


def load_map(path):
    """Load an environment map as linear Rec.709, anew if it was loaded before."""
    image = bpy.data.images.load(str(Path(path).absolute()), check_existing=True)
    image.reload()  # the file may have changed since
    set_linear(image)
    return image


def set_linear(image):
    """Say that an image holds linear Rec.709, whatever the scene's working space is."""
    for name in ("Linear Rec.709", "Linear"):  # the second: configurations older than Blender's own
        try:
            image.colorspace_settings.name = name
            return
        except TypeError:
            continue


def build(scene, rig, image, image_yaw=0.0):
    """Put the light of a rig into a scene, in place of an earlier one.

    Args:
        scene: where to.
        rig: a document that `check_rig` lets through.
        image: the map, an image datablock.
        image_yaw: radians that the Mapping node turns the lookup by when nothing is turned: 0 for a map whose
            centre is Blender's +X, -pi / 2 for MixLight's own layout, whose centre is ahead of the camera.

    Returns:
        The empty that all hangs on. Turning it about Z turns map and lights together, positive to the left.
    """
    held, image.use_fake_user = image.use_fake_user, True  # it may be the one that the earlier light used
    remove(scene)
    collection = bpy.data.collections.new("MixLight")
    scene.collection.children.link(collection)
    root = bpy.data.objects.new("MixLight", None)
    root.empty_display_type = "SPHERE"
    root.empty_display_size = 0.5
    root.lock_rotation = (True, True, False)  # a map can follow a turn about Z alone
    root[RIG] = rig["map"]
    root[EXPOSURE] = 0.0
    if scene.world is not None:
        root[PREVIOUS] = scene.world
    collection.objects.link(root)
    for rank, light in enumerate(rig["lights"]):
        sun = _sun(light, root)
        sun[RANK] = rank
        collection.objects.link(sun)
    scene.world = _world(image, root, image_yaw)
    image.use_fake_user = held
    return root


def find(scene):
    """The empty of the scene's MixLight, or None."""
    return next((thing for thing in scene.objects if RIG in thing), None)


def suns(root):
    """The Suns that hang on the empty, the brightest first."""
    found = [child for child in root.children if child.type == "LIGHT" and ENERGY in child]
    return sorted(found, key=lambda child: child.get(RANK, 0))


def set_enabled(sun, enabled):
    """Switch a Sun on or off, in renders and in the viewport alike."""
    sun.hide_render = sun.hide_viewport = not enabled


def remove(scene):
    """Take the scene's MixLight out again and give the scene its former world back."""
    root = find(scene)
    if root is None:
        return
    world, image = None, map_of(scene)
    if background(scene) is not None:  # else the user has chosen another world, which stays
        world = scene.world
        scene.world = root.get(PREVIOUS)
    for data in {sun.data for sun in suns(root)}:  # copies share theirs
        bpy.data.lights.remove(data)  # takes the objects with it
    for collection in list(root.users_collection):
        others = [thing for thing in collection.objects if thing != root]
        if collection.name.startswith("MixLight") and not others and not collection.children:
            bpy.data.collections.remove(collection)
    bpy.data.objects.remove(root)
    for block, home in ((world, bpy.data.worlds), (image, bpy.data.images)):
        if block is not None and not block.users and block != scene.world:
            home.remove(block)


def map_of(scene):
    """The image of the scene's MixLight world, or None."""
    if background(scene) is None:
        return None
    nodes = scene.world.node_tree.nodes
    return next((node.image for node in nodes if node.type == "TEX_ENVIRONMENT"), None)


def background(scene):
    """The node whose strength scales the map, or None."""
    if scene.world is None or scene.world.node_tree is None:
        return None
    return scene.world.node_tree.nodes.get(BACKGROUND)


def _sun(light, root):
    data = bpy.data.lights.new(light["name"], type="SUN")
    red, green, blue = light["irradiance"]
    energy = max(red, green, blue)
    data.energy = energy
    data.color = [value / energy if energy else 1.0 for value in (red, green, blue)]
    data.angle = min(math.radians(light["angular_diameter_deg"]), math.pi)
    sun = bpy.data.objects.new(light["name"], data)
    sun.parent = root
    towards = Vector(light["direction"]).normalized()
    sun.location = towards * _DISTANCE
    sun.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()  # a Sun shines along its own -Z
    sun[ENERGY] = energy
    set_enabled(sun, light["enabled"])
    return sun


def _world(image, root, image_yaw):
    world = bpy.data.worlds.new("MixLight")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    chain = []
    for place, kind in enumerate(
        (
            "ShaderNodeTexCoord",
            "ShaderNodeMapping",
            "ShaderNodeTexEnvironment",
            "ShaderNodeBackground",
            "ShaderNodeOutputWorld",
        )
    ):
        node = nodes.new(kind)
        node.location = (260 * place - 780, 0)
        chain.append(node)
    coordinate, mapping, texture, shader, output = chain
    shader.name = shader.label = BACKGROUND
    shader.inputs["Strength"].default_value = 1.0
    mapping.vector_type = "POINT"
    texture.image = image
    links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], shader.inputs["Color"])
    links.new(shader.outputs["Background"], output.inputs["Surface"])
    # The map follows the empty: to turn light by an angle, its lookup turns back by it.
    curve = mapping.inputs["Rotation"].driver_add("default_value", 2)
    turn = curve.driver.variables.new()
    turn.name = "turn"
    turn.targets[0].id = root
    turn.targets[0].data_path = "rotation_euler[2]"
    curve.driver.expression = f"{image_yaw:.9f} - turn"
    return world


def _is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _folder():
    """The folder named behind `--`, else the one that this file is in."""
    if "--" in sys.argv[:-1]:
        return Path(sys.argv[sys.argv.index("--") + 1])
    text = getattr(bpy.context.space_data, "text", None)  # run from the text editor
    if text is not None and text.filepath:
        return Path(bpy.path.abspath(text.filepath)).parent
    return Path(__file__).absolute().parent


if __name__ == "__main__":
    _here = _folder()
    build(bpy.context.scene, read_rig(_here), load_map(_here / "environment.exr"))
