"""What the panel shows and changes. Nothing is stored twice: each value is read from the scene itself.

So a Sun's strength may be edited here or in its own tab, the empty may be turned by hand, and a file opened
without the extension is lit the same.
"""

import bpy
from bpy.props import BoolProperty, FloatProperty, PointerProperty

from . import scene as light_scene


def _gain(root):
    return 2.0 ** root.get(light_scene.EXPOSURE, 0.0)


def _get_rotation(settings):
    root = light_scene.find(settings.id_data)
    return 0.0 if root is None else root.rotation_euler[2]


def _set_rotation(settings, angle):
    root = light_scene.find(settings.id_data)
    if root is not None:
        root.rotation_euler[2] = angle


def _get_exposure(settings):
    root = light_scene.find(settings.id_data)
    return 0.0 if root is None else root.get(light_scene.EXPOSURE, 0.0)


def _set_exposure(settings, stops):
    scene = settings.id_data
    root = light_scene.find(scene)
    if root is None:
        return
    ratio = 2.0**stops / _gain(root)
    root[light_scene.EXPOSURE] = stops
    for sun in light_scene.suns(root):
        sun.data.energy *= ratio
    node = light_scene.background(scene)
    if node is not None:
        node.inputs["Strength"].default_value *= ratio


def _get_map_strength(settings):
    scene = settings.id_data
    root, node = light_scene.find(scene), light_scene.background(scene)
    if root is None or node is None:
        return 1.0
    return node.inputs["Strength"].default_value / _gain(root)


def _set_map_strength(settings, strength):
    scene = settings.id_data
    root, node = light_scene.find(scene), light_scene.background(scene)
    if root is not None and node is not None:
        node.inputs["Strength"].default_value = strength * _gain(root)


def _get_enabled(settings):
    return not settings.id_data.hide_render


def _set_enabled(settings, enabled):
    light_scene.set_enabled(settings.id_data, enabled)


def _get_strength(settings):
    sun = settings.id_data
    full = sun.get(light_scene.ENERGY, 0.0) * (_gain(sun.parent) if sun.parent else 1.0)
    return sun.data.energy / full if full and sun.type == "LIGHT" else 1.0


def _set_strength(settings, strength):
    sun = settings.id_data
    if sun.type == "LIGHT" and light_scene.ENERGY in sun:
        sun.data.energy = strength * sun[light_scene.ENERGY] * (_gain(sun.parent) if sun.parent else 1.0)


class MixLightSceneSettings(bpy.types.PropertyGroup):
    """The whole light of a scene, `scene.mixlight`."""

    rotation: FloatProperty(
        name="Rotation",
        description="Turn map and lights together about the vertical, positive to the left",
        subtype="ANGLE",
        soft_min=-3.14159265,
        soft_max=3.14159265,
        get=_get_rotation,
        set=_set_rotation,
    )
    exposure: FloatProperty(
        name="Exposure",
        description="Brighten map and lights together, in stops: +1 doubles the light",
        soft_min=-5.0,
        soft_max=5.0,
        get=_get_exposure,
        set=_set_exposure,
    )
    map_strength: FloatProperty(
        name="Map",
        description="Strength of the environment map; 1 is as estimated",
        min=0.0,
        soft_max=4.0,
        get=_get_map_strength,
        set=_set_map_strength,
    )


class MixLightSunSettings(bpy.types.PropertyGroup):
    """One light, `sun.mixlight`."""

    enabled: BoolProperty(
        name="On",
        description="Switch the light on or off, in renders and in the viewport",
        get=_get_enabled,
        set=_set_enabled,
    )
    strength: FloatProperty(
        name="Strength",
        description="Strength of the light; 1 is as estimated",
        min=0.0,
        soft_max=4.0,
        get=_get_strength,
        set=_set_strength,
    )


CLASSES = (MixLightSceneSettings, MixLightSunSettings)


def register():
    """Add `scene.mixlight` and `object.mixlight`."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.mixlight = PointerProperty(type=MixLightSceneSettings)
    bpy.types.Object.mixlight = PointerProperty(type=MixLightSunSettings)


def unregister():
    """Take both away; the scene's light stays as it is."""
    del bpy.types.Object.mixlight
    del bpy.types.Scene.mixlight
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
