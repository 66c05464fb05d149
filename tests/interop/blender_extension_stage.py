"""Runs inside Blender: installs the extension as a user would, and checks its operators, settings and panel.

    python blender_extension_stage.py -- FOLDER

Writes FOLDER/checks.json: the name of each check, and null or how it failed.
"""

import json
import math
import sys
import traceback
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
MODULE = "bl_ext.user_default.mixlight"


def main():
    results = {}
    install()
    for name, check in list(globals().items()):
        if name.startswith("check_"):
            try:
                fresh_scene()
                check(bpy.context.scene)
                results[name] = None
            except Exception:
                results[name] = traceback.format_exc()
    (FOLDER / "checks.json").write_text(json.dumps(results))


def install():
    archive = next((FOLDER / "residual").glob("*.zip"))
    done = bpy.ops.extensions.package_install_files(
        filepath=str(archive), repo="user_default", enable_on_install=True
    )
    assert done == {"FINISHED"}, done
    assert MODULE in bpy.context.preferences.addons


def fresh_scene():
    """Blender's first scene; add-ons stay on."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    if not hasattr(bpy.types.Scene, "mixlight"):
        bpy.ops.preferences.addon_enable(module=MODULE)


def load(name, **options):
    assert bpy.ops.mixlight.load(filepath=str(FOLDER / name), **options) == {"FINISHED"}
    bpy.context.view_layer.update()


def suns():
    return [bpy.data.objects[f"light_{number}"] for number in range(1, 5)]


def background(scene):
    return scene.world.node_tree.nodes["MixLight Background"]


def mapping(scene):
    """The Mapping node's turn as the renderer sees it."""
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    nodes = scene.world.evaluated_get(graph).node_tree.nodes
    return next(node for node in nodes if node.type == "MAPPING").inputs["Rotation"].default_value[2]


def pixels(image):
    """The image as [rows from the top, columns, rgb]."""
    values = np.empty(4 * image.size[0] * image.size[1], dtype=np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[::-1, :, :3]


def map_image(scene):
    return next(node.image for node in scene.world.node_tree.nodes if node.type == "TEX_ENVIRONMENT")


def refused(call, expected):
    complaint = "nothing"
    try:
        call()
    except RuntimeError as error:
        complaint = str(error)
    assert expected in complaint, complaint


def check_loads_an_exported_folder(scene):
    load("residual")
    assert scene.world.name == "MixLight"
    assert [sun.data.type for sun in suns()] == ["SUN"] * 4
    assert not any(sun.hide_render or sun.hide_viewport for sun in suns())
    assert {"Camera", "Cube", "Light"} <= {thing.name for thing in scene.objects}  # what was there stays
    assert abs(mapping(scene)) < 1e-6


def check_loads_the_document_itself(scene):
    load("residual/rig.json")
    assert len(bpy.data.objects["MixLight"].children) == 4


def check_a_full_map_has_its_lights_off(scene):
    load("full")
    assert all(sun.hide_render and sun.hide_viewport for sun in suns())


def check_a_lighting_json_becomes_suns_and_the_residual_map(scene):
    load("alone.json", height=32)
    expected = np.load(FOLDER / "residual.npy")
    np.testing.assert_allclose(pixels(map_image(scene)), expected, rtol=1e-4, atol=1e-5)
    assert map_image(scene).packed_file is not None
    assert map_image(scene).colorspace_settings.name == "Linear Rec.709"
    assert abs(mapping(scene) + math.pi / 2) < 1e-6  # the layout of MixLight, turned by the node
    reference = json.loads((FOLDER / "residual" / "rig.json").read_text())["lights"]
    for sun, light in zip(suns(), reference, strict=True):
        outward = sun.matrix_world.to_3x3().col[2]
        np.testing.assert_allclose(outward, light["direction"], atol=1e-5)
        irradiance = sun.data.energy * np.array(sun.data.color)
        np.testing.assert_allclose(irradiance, light["irradiance"], rtol=1e-5)


def check_a_lighting_json_with_all_light_in_the_map(scene):
    load("alone.json", height=32, lights="MAP")
    np.testing.assert_allclose(pixels(map_image(scene)), np.load(FOLDER / "full.npy"), rtol=1e-4, atol=1e-5)
    assert all(sun.hide_render for sun in suns())


def check_an_estimates_folder_takes_its_own_map(scene):
    load("estimate", lights="MAP")
    assert Path(bpy.path.abspath(map_image(scene).filepath)) == FOLDER / "estimate" / "environment.exr"
    assert abs(mapping(scene) + math.pi / 2) < 1e-6
    load("estimate")  # Suns: the map on disk holds them, so another one is made
    assert map_image(scene).filepath == "" or map_image(scene).packed_file is not None


def check_switching_a_light(scene):
    load("residual")
    sun = suns()[0]
    sun.mixlight.enabled = False
    assert sun.hide_render
    assert sun.hide_viewport
    assert not sun.mixlight.enabled
    sun.mixlight.enabled = True
    assert not sun.hide_render
    assert not sun.hide_viewport


def check_strength_of_a_light(scene):
    load("residual")
    sun = suns()[1]
    before = sun.data.energy
    assert abs(sun.mixlight.strength - 1) < 1e-6
    sun.mixlight.strength = 2.5
    np.testing.assert_allclose(sun.data.energy, 2.5 * before, rtol=1e-6)
    sun.data.energy = before / 2  # edited in the light's own tab
    np.testing.assert_allclose(sun.mixlight.strength, 0.5, rtol=1e-6)


def check_exposure_scales_map_and_lights_and_keeps_edits(scene):
    load("residual")
    before = [sun.data.energy for sun in suns()]
    suns()[0].mixlight.strength = 3
    scene.mixlight.exposure = 1
    np.testing.assert_allclose(
        [sun.data.energy for sun in suns()], np.multiply(before, [6, 2, 2, 2]), rtol=1e-6
    )
    np.testing.assert_allclose(background(scene).inputs["Strength"].default_value, 2, rtol=1e-6)
    np.testing.assert_allclose(suns()[0].mixlight.strength, 3, rtol=1e-6)
    scene.mixlight.exposure = -1
    np.testing.assert_allclose(suns()[1].data.energy, before[1] / 2, rtol=1e-6)
    np.testing.assert_allclose(scene.mixlight.map_strength, 1, rtol=1e-6)


def check_map_strength(scene):
    load("residual")
    scene.mixlight.exposure = 1
    scene.mixlight.map_strength = 0.25
    np.testing.assert_allclose(background(scene).inputs["Strength"].default_value, 0.5, rtol=1e-6)


def check_rotation_turns_map_and_lights_alike(scene):
    load("residual")
    before = [np.array(sun.matrix_world.to_3x3().col[2]) for sun in suns()]
    scene.mixlight.rotation = 0.5
    bpy.context.view_layer.update()
    assert abs(mapping(scene) + 0.5) < 1e-6  # a lookup turned back turns the light
    turn = np.array([[math.cos(0.5), -math.sin(0.5), 0], [math.sin(0.5), math.cos(0.5), 0], [0, 0, 1]])
    for sun, was in zip(suns(), before, strict=True):
        np.testing.assert_allclose(sun.matrix_world.to_3x3().col[2], turn @ was, atol=1e-6)
    bpy.data.objects["MixLight"].rotation_euler[2] = -0.25  # turned by hand
    assert abs(scene.mixlight.rotation + 0.25) < 1e-6
    assert abs(mapping(scene) - 0.25) < 1e-6


def check_loading_again_replaces(scene):
    for _ in range(3):
        load("residual")
        load("alone.json", height=16)
    assert sum(thing.type == "LIGHT" for thing in scene.objects) == 5  # four and the scene's own
    assert sum("MixLight" in world.name for world in bpy.data.worlds) == 1
    assert sum(image.name.startswith(("MixLight", "environment")) for image in bpy.data.images) == 1
    assert sum(collection.name.startswith("MixLight") for collection in bpy.data.collections) == 1


def check_loading_the_same_again(scene):
    for _ in range(2):
        load("residual")
        assert map_image(scene).size[1] == 32
        assert not map_image(scene).use_fake_user
    assert sum(image.name.startswith("environment") for image in bpy.data.images) == 1


def check_copies_of_a_light_go_too(scene):
    load("residual")
    copy = suns()[0].copy()  # shares its light
    scene.collection.objects.link(copy)
    assert bpy.ops.mixlight.remove() == {"FINISHED"}
    assert [thing.name for thing in scene.objects if thing.type == "LIGHT"] == ["Light"]


def check_the_panel_lists_lights_by_name(scene):
    load("residual")
    listed = sys.modules[f"{MODULE}.scene"].suns(bpy.data.objects["MixLight"])
    assert [sun.name for sun in listed] == ["light_1", "light_2", "light_3", "light_4"]


def check_remove_gives_everything_back(scene):
    before = {name: sorted(block.name for block in getattr(bpy.data, name)) for name in BLOCKS}
    world = scene.world
    load("residual")
    assert bpy.ops.mixlight.remove() == {"FINISHED"}
    assert {name: sorted(block.name for block in getattr(bpy.data, name)) for name in BLOCKS} == before
    assert scene.world == world
    assert not bpy.ops.mixlight.remove.poll()


BLOCKS = ("objects", "lights", "worlds", "collections")


def check_remove_leaves_a_world_chosen_later(scene):
    load("residual")
    scene.world = bpy.data.worlds.new("mine")
    assert bpy.ops.mixlight.remove() == {"FINISHED"}
    assert scene.world.name == "mine"


def check_bad_input_changes_nothing(scene):
    load("residual")
    before = sorted(thing.name for thing in scene.objects), scene.world
    broken = FOLDER / "broken"
    broken.mkdir(exist_ok=True)
    refused(lambda: bpy.ops.mixlight.load(filepath=str(FOLDER / "none.json")), "none.json")
    refused(lambda: bpy.ops.mixlight.load(filepath=str(broken)), "expected a folder with rig.json")
    (broken / "rig.json").write_text("{")
    refused(lambda: bpy.ops.mixlight.load(filepath=str(broken)), "expected a JSON document")
    document = json.loads((FOLDER / "residual" / "rig.json").read_text())
    for entry, value, complaint in (
        ("frame", "mixlight", "frame: expected 'blender'"),
        ("map", "half", "map: expected 'residual' or 'full'"),
        ("lights", {}, "lights: expected a list"),
        ("version", 2, "version 1"),
    ):
        (broken / "rig.json").write_text(json.dumps(document | {entry: value}))
        refused(lambda: bpy.ops.mixlight.load(filepath=str(broken)), complaint)
    for entry, value in (
        ("direction", [0, 0, 0]),
        ("direction", [0, 1]),
        ("irradiance", [1, -1, 1]),
        ("irradiance", [1, "1", 1]),
        ("angular_diameter_deg", 0),
        ("enabled", 1),
        ("name", None),
    ):
        light = document["lights"][0] | {entry: value}
        (broken / "rig.json").write_text(json.dumps(document | {"lights": [light]}))
        refused(lambda: bpy.ops.mixlight.load(filepath=str(broken)), "lights[0]")
    (broken / "rig.json").write_text(json.dumps(document))
    refused(lambda: bpy.ops.mixlight.load(filepath=str(broken)), "expected environment.exr")
    assert (sorted(thing.name for thing in scene.objects), scene.world) == before


def check_photo_colours(scene):
    scene.view_settings.exposure = 2
    assert bpy.ops.mixlight.photo_colours() == {"FINISHED"}
    view = scene.view_settings
    assert (view.view_transform, view.look, view.exposure, view.gamma) == ("Standard", "None", 0, 1)


def check_the_panel_draws_with_and_without_a_light(scene):
    panel = bpy.types.MIXLIGHT_PT_light
    assert (panel.bl_space_type, panel.bl_region_type, panel.bl_category) == ("VIEW_3D", "UI", "MixLight")
    assert draw(panel) == ["mixlight.load"]
    load("residual")
    shown = draw(panel)
    for name in ("rotation", "exposure", "map_strength"):
        assert shown.count(name) == 1
    assert shown.count("enabled") == shown.count("strength") == shown.count("color") == 4
    assert "The map holds these lights already" not in shown
    load("full")
    suns()[0].mixlight.enabled = True
    assert "The map holds these lights already" in draw(panel)


class Layout:
    """Stands in for the panel's layout: notes what is drawn, and complains about what does not exist."""

    def __init__(self, shown):
        self.shown = shown

    def row(self, align=False):
        return self

    column = row

    def label(self, text="", icon="NONE"):
        self.shown.append(text)
        known_icon(icon)

    def operator(self, name, icon="NONE"):
        group, verb = name.split(".")
        getattr(getattr(bpy.ops, group), verb).get_rna_type()
        known_icon(icon)
        self.shown.append(name)

    def prop(self, owner, name, text=""):
        assert name in owner.bl_rna.properties, name
        self.shown.append(name)


def known_icon(icon):
    assert icon in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items, icon


def draw(panel):
    shown = []
    cls = sys.modules[f"{MODULE}.panel"].MIXLIGHT_PT_light
    cls.draw(SimpleNamespace(layout=Layout(shown)), bpy.context)
    return shown


def check_a_saved_file_is_lit_the_same_without_the_extension(scene):
    load("alone.json", height=16)
    bpy.data.objects["MixLight"].rotation_euler[2] = 0.3
    energies = [sun.data.energy for sun in suns()]
    path = str(FOLDER / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        assert not hasattr(bpy.context.scene, "mixlight")
        assert [sun.data.energy for sun in suns()] == energies
        assert abs(mapping(bpy.context.scene) - (-math.pi / 2 - 0.3)) < 1e-6
        assert map_image(bpy.context.scene).size[1] == 16
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)


if __name__ == "__main__":
    main()
