"""Geometry of the sphere; knows nothing of light or colour.

`frames` names the frames of other programs, `equirect` is the panorama, `camera` the pinhole, `cubemap` the six
faces, `points` the anchors, `calibration` the card that shows which way is which.
"""

from mixlight.sphere import camera as camera
from mixlight.sphere import equirect as equirect
from mixlight.sphere import frames as frames
from mixlight.sphere import points as points

__all__ = ["camera", "equirect", "frames", "points"]
