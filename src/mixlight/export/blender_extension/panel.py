"""The panel in the 3D view's sidebar (N), tab MixLight."""

import bpy

from . import scene as light_scene


class MIXLIGHT_PT_light(bpy.types.Panel):
    """The light of the scene: load, turn, expose, and each light by its name."""

    bl_idname = "MIXLIGHT_PT_light"
    bl_label = "MixLight"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "MixLight"

    def draw(self, context):
        """Draw it."""
        layout = self.layout
        layout.operator("mixlight.load", icon="IMPORT")
        root = light_scene.find(context.scene)
        if root is None:
            return
        settings = context.scene.mixlight
        column = layout.column(align=True)
        column.prop(settings, "rotation")
        column.prop(settings, "exposure")
        column.prop(settings, "map_strength")
        suns = light_scene.suns(root)
        if suns:
            layout.label(text="Lights")
        column = layout.column(align=True)
        for sun in suns:
            row = column.row(align=True)
            row.prop(sun.mixlight, "enabled", text="")
            row.prop(sun.data, "color", text="")
            row.prop(sun.mixlight, "strength", text=sun.name)
        if root[light_scene.RIG] == "full" and any(sun.mixlight.enabled for sun in suns):
            layout.label(text="The map holds these lights already", icon="ERROR")
        row = layout.row(align=True)
        row.operator("mixlight.photo_colours", icon="COLOR")
        row.operator("mixlight.remove", icon="X")


def register():
    """Add the panel."""
    bpy.utils.register_class(MIXLIGHT_PT_light)


def unregister():
    """Take it away."""
    bpy.utils.unregister_class(MIXLIGHT_PT_light)
