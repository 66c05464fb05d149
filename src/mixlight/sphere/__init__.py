"""Geometry of the sphere; knows nothing of light or colour.

`equirect` is the panorama, `camera` the pinhole, `cubemap` the six faces, `points` the anchors, `frames`
names the frames of other programs, `calibration` draws the card that shows which way is which. Functions
whose names say enough by themselves are also here.
"""

from mixlight.sphere import calibration as calibration
from mixlight.sphere import camera as camera
from mixlight.sphere import cubemap as cubemap
from mixlight.sphere import equirect as equirect
from mixlight.sphere import frames as frames
from mixlight.sphere import points as points
from mixlight.sphere.calibration import calibration_card as calibration_card
from mixlight.sphere.frames import FRAMES as FRAMES
from mixlight.sphere.frames import convert_directions as convert_directions
from mixlight.sphere.frames import convert_panorama as convert_panorama
from mixlight.sphere.frames import rotation as rotation

__all__ = [
    "calibration",
    "camera",
    "cubemap",
    "equirect",
    "frames",
    "points",
    "FRAMES",
    "calibration_card",
    "convert_directions",
    "convert_panorama",
    "rotation",
]
