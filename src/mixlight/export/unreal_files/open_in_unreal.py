"""Adds the light of unreal.json and the map environment.hdr beside it to the open level.

Runs inside the Unreal Editor (Tools > Execute Python Script...). Derived from Unreal's documentation; never
run in Unreal itself.
"""

import json
from pathlib import Path

import unreal

ASSETS = "/Game/MixLight"
"""Content folder that the map is imported into."""


def main(folder):
    """Import the map, then spawn one Sky Light and the Directional Lights in a folder of the outliner."""
    rig = json.loads((folder / "unreal.json").read_text(encoding="utf-8"))
    if (rig.get("format"), rig.get("version")) != ("mixlight/unreal", 1):
        raise ValueError(f"{folder}: expected mixlight/unreal of version 1, received {rig.get('format')}")
    sky(rig, cube_map(folder / "environment.hdr"))
    for light in rig["lights"]:
        directional(rig, light)


def cube_map(path):
    """The long-lat picture as a cube texture, which is what Unreal makes of an .hdr."""
    task = unreal.AssetImportTask()
    task.filename = str(path)
    task.destination_path = ASSETS
    task.replace_existing = True
    task.automated = True
    task.save = True
    unreal.AssetToolsHelpers.get_asset_tools().import_asset_tasks([task])
    texture = unreal.load_asset(f"{ASSETS}/{path.stem}")
    if not isinstance(texture, unreal.TextureCube):
        raise ValueError(f"{path}: expected a TextureCube from Unreal, received {type(texture).__name__}")
    return texture


def spawn(rig, kind, name, rotation):
    """An actor of ours, movable, in the rig's folder of the outliner."""
    actors = unreal.get_editor_subsystem(unreal.EditorActorSubsystem)
    actor = actors.spawn_actor_from_class(kind, unreal.Vector(0, 0, 200), rotation)
    actor.set_actor_label(name)
    actor.set_folder_path(rig["name"])
    actor.light_component.set_mobility(unreal.ComponentMobility.MOVABLE)
    return actor.light_component


def sky(rig, texture):
    """The map as ambient light; its lower half counts as well."""
    component = spawn(rig, unreal.SkyLight, "ambient", unreal.Rotator(0, 0, 0))
    component.set_editor_property("real_time_capture", False)
    component.set_editor_property("source_type", unreal.SkyLightSourceType.SLS_SPECIFIED_CUBEMAP)
    component.set_editor_property("cubemap", texture)
    component.set_editor_property("source_cubemap_angle", 0.0)
    component.set_editor_property("lower_hemisphere_is_black", False)
    component.set_intensity(1.0)
    component.recapture_sky()


def directional(rig, light):
    """A Directional Light whose colour times intensity (lux) is the irradiance."""
    turn = light["rotation_deg"]
    rotation = unreal.Rotator(roll=turn["roll"], pitch=turn["pitch"], yaw=turn["yaw"])
    component = spawn(rig, unreal.DirectionalLight, light["name"], rotation)
    peak = max(light["irradiance"])
    red, green, blue = (part / peak if peak > 0 else 1.0 for part in light["irradiance"])
    component.set_intensity(peak)
    component.set_light_color(unreal.LinearColor(red, green, blue, 1.0))
    component.set_editor_property("use_temperature", False)
    component.set_editor_property("light_source_angle", light["angular_diameter_deg"])
    component.set_visibility(light["enabled"])


main(Path(__file__).resolve().parent)
