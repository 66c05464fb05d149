"""What the panel's buttons do."""

import bpy
import numpy as np
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import documents, synthesis
from . import scene as light_scene

_QUARTER_TURN = 1.5707963267948966


def load(scene, path, lights="SUNS", height=256):
    """Put the light of a document, or of the folder that it is in, into a scene.

    Nothing of the scene changes before the document has been read and checked.

    Args:
        scene: where to.
        path: as `documents.resolve` takes it.
        lights: "SUNS" or "MAP"; only for a `lighting.json`, an exported rig has decided.
        height: rows of a map made from a `lighting.json`.

    Raises:
        ValueError: no such document; OSError: it cannot be read.
    """
    path = documents.resolve(path)
    if documents.is_rig(path):
        if path.name != "rig.json":
            raise ValueError(f"{path}: expected an exported rig under its name, rig.json")
        rig = light_scene.read_rig(path.parent)
        image = light_scene.load_map(path.parent / "environment.exr")
        return light_scene.build(scene, rig, image)
    document = documents.read_lighting(path)
    rig = documents.to_rig(document, lights == "SUNS")
    light_scene.check_rig(rig)
    beside = path.parent / "environment.exr"
    if rig["map"] == "full" and path.name == "lighting.json" and beside.is_file():
        # The estimate's own map, in MixLight's layout: ahead is in its centre.
        return light_scene.build(scene, rig, light_scene.load_map(beside), -_QUARTER_TURN)
    make = synthesis.residual_map if rig["map"] == "residual" else synthesis.full_map
    return light_scene.build(scene, rig, _image(make(document, height)), -_QUARTER_TURN)


def _image(radiance):
    """An image datablock that holds a map, packed into the file."""
    height, width, _ = radiance.shape
    image = bpy.data.images.new("MixLight map", width, height, float_buffer=True)
    light_scene.set_linear(image)
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = radiance[::-1]  # Blender's first row is the lowest
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


class MIXLIGHT_OT_load(bpy.types.Operator, ImportHelper):
    """Light the scene with an estimate: rig.json, lighting.json, or the folder of either."""

    bl_idname = "mixlight.load"
    bl_label = "Load Light"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    lights: EnumProperty(
        name="Lights",
        description="Where the light of a lighting.json goes (an exported folder has decided that itself)",
        items=(
            ("SUNS", "As Suns", "Named Suns to switch and scale; they are taken out of the map"),
            ("MAP", "In the map", "The map holds all light; the Suns are switched off"),
        ),
        default="SUNS",
    )
    height: IntProperty(
        name="Map Rows",
        description="Rows of a map that is made from lighting.json",
        default=256,
        min=16,
        max=2048,
    )

    def execute(self, context):
        """Load what was chosen: a file, or the folder that the file browser stands in."""
        try:
            root = load(context.scene, self.filepath or self.directory, self.lights, self.height)
        except (ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        count = len(light_scene.suns(root))
        self.report({"INFO"}, f"MixLight: {count} lights, map: {root[light_scene.RIG]}")
        return {"FINISHED"}


class MIXLIGHT_OT_remove(bpy.types.Operator):
    """Take the light out again and give the scene its former world back."""

    bl_idname = "mixlight.remove"
    bl_label = "Remove Light"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        """There is a light to remove."""
        return light_scene.find(context.scene) is not None

    def execute(self, context):
        """Remove it."""
        light_scene.remove(context.scene)
        return {"FINISHED"}


class MIXLIGHT_OT_photo_colours(bpy.types.Operator):
    """Show radiance as the photo does: view transform Standard, no look, no exposure. Radiance 1 is white."""

    bl_idname = "mixlight.photo_colours"
    bl_label = "Photo's Colours"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        """Set the scene's colour management."""
        view = context.scene.view_settings
        view.view_transform = "Standard"
        view.look = "None"
        view.exposure = 0.0
        view.gamma = 1.0
        return {"FINISHED"}


CLASSES = (MIXLIGHT_OT_load, MIXLIGHT_OT_remove, MIXLIGHT_OT_photo_colours)


def register():
    """Add the operators."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    """Take them away."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
