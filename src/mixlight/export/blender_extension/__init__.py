"""MixLight in Blender: load an estimated light, switch, scale, turn and expose it. Sidebar (N), tab
MixLight.
"""

from . import operators, panel, properties

_PARTS = (properties, operators, panel)


def register():
    """Called by Blender when the extension is switched on."""
    for part in _PARTS:
        part.register()


def unregister():
    """Called by Blender when the extension is switched off."""
    for part in reversed(_PARTS):
        part.unregister()
