"""Screens, computers, household machines."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]

_CASE = Surface("plastic", (0.015, 0.015, 0.016), roughness=0.35)
_KEYS = Surface("plastic", (0.025, 0.025, 0.027), roughness=0.6)


def _draw_screen(rng: Random, style: Style, kind: str) -> Item:
    if kind == "monitor":
        width = rng.uniform(0.46, 0.72)
        size = (width, 0.19, width * 0.58 + rng.uniform(0.08, 0.14))
    elif kind == "wall_tv":
        width = rng.uniform(0.8, 1.55)
        size = (width, 0.06, width * 0.575)
    else:
        width = rng.uniform(0.7, 1.45)
        size = (width, 0.24, width * 0.575 + 0.06)
    case = rng.choice([_CASE, _CASE, style.metal]) if kind == "monitor" else _CASE
    return draft(size, (case, style.screen, style.metal))


def _screen(item: Item) -> list[Part]:
    """A flat screen whose glass looks along -Y; on a foot, unless it hangs (its depth is under 0.1)."""
    width, depth, height = item.size
    bodies = Bodies(item)
    x = width / 2
    hangs = depth < 0.1
    tall = width * 0.575 if item.kind != "monitor" else width * 0.58
    low = height - tall
    front = -depth / 2 if hangs else -0.02
    rear = depth / 2 - 0.012 if hangs else 0.02
    bodies.box(0, (-x, front + 0.004, low), (x, rear, height))
    t = 0.008
    bodies.add(
        1, shapes.panel((-x + t, front + 0.003, low + t * 1.6), (width - 2 * t, 0, 0), (0, 0, tall - 2.6 * t))
    )
    if hangs:
        bodies.box(0, (-0.15, rear, low + 0.2 * tall), (0.15, depth / 2, low + 0.6 * tall))
    else:
        bodies.box(0, (-0.03, 0.02, 0.02), (0.03, 0.05, low + tall * 0.4))
        bodies.box(0, (-min(0.14, x * 0.6), -depth / 2, 0.0), (min(0.14, x * 0.6), depth / 2, 0.014))
        bodies.box(0, (-0.03, 0.02, 0.0), (0.03, 0.05, low + 0.02))
    return bodies.parts()


def _draw_keyboard(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.5, 0.62), 0.16, 0.03),
        (rng.choice([_CASE, style.plastic]), _KEYS, style.plastic),
        mouse=True,
    )


def _keyboard(item: Item) -> list[Part]:
    width, depth, _height = item.size
    bodies = Bodies(item)
    x0, x1, y = -width / 2, width / 2 - 0.12, depth / 2 - 0.015
    bodies.box(0, (x0, -y, 0.0), (x1, y, 0.014))
    for row in range(5):
        a = -y + 0.008 + row * (2 * y - 0.016) / 5
        columns = 14
        step = (x1 - x0 - 0.016) / columns
        for i in range(columns):
            b = x0 + 0.008 + i * step
            bodies.box(1, (b, a, 0.014), (b + step - 0.003, a + (2 * y - 0.016) / 5 - 0.003, 0.021))
    ball = shapes.sphere(0.5, segments=14, rings=8)
    bodies.put(0, ball, shapes.placement((width / 2 - 0.04, 0.0, 0.019), 0.1, (0.062, 0.105, 0.038)))
    return bodies.parts()


def _draw_laptop(rng: Random, style: Style) -> Item:
    width = rng.uniform(0.3, 0.37)
    return draft(
        (width, width * 0.95, width * 0.62),
        (rng.choice([style.metal, _CASE, style.plastic]), style.screen, _KEYS),
        open=rng.random() < 0.75,
    )


def _laptop(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, deep = width / 2, width * 0.68
    front = -depth / 2
    bodies.box(0, (-x, front, 0.0), (x, front + deep, 0.016))
    if not item.parameters["open"]:
        bodies.box(0, (-x, front, 0.017), (x, front + deep, 0.024))
        return bodies.parts()
    bodies.box(2, (-x + 0.02, front + deep * 0.42, 0.016), (x - 0.02, front + deep - 0.02, 0.018))
    lean = shapes.placement((0, front + deep - 0.004, 0.014)) @ shapes.rotation("x", math.radians(-18))
    tall = min(deep, (height - 0.02) / math.cos(math.radians(18)))
    bodies.put(0, shapes.box((-x, 0.0, 0.0), (x, 0.008, tall)), lean)
    bodies.put(1, shapes.panel((-x + 0.008, -0.001, 0.012), (width - 0.016, 0, 0), (0, 0, tall - 0.02)), lean)
    return bodies.parts()


def _draw_printer(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.38, 0.48), rng.uniform(0.32, 0.4), rng.uniform(0.16, 0.3)),
        (rng.choice([_CASE, style.ceramic]), _KEYS, style.paper),
    )


def _printer(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.add(0, shapes.rounded_box((-x, -y + 0.05, 0.0), (x, y, height), 0.018, steps=1))
    bodies.box(1, (-x + 0.06, -y + 0.044, height * 0.35), (x - 0.06, -y + 0.052, height * 0.6))
    bodies.box(0, (-x + 0.07, -y, height * 0.18), (x - 0.07, -y + 0.06, height * 0.22))
    bodies.box(2, (-0.1, -y + 0.01, height * 0.22), (0.1, -y + 0.06, height * 0.24))
    return bodies.parts()


def _draw_phone(rng: Random, style: Style) -> Item:
    if rng.random() < 0.6:
        return draft((0.074, 0.155, 0.009), (_CASE, style.screen), desk=False)
    return draft((0.2, 0.21, 0.08), (_CASE, style.screen), desk=True)


def _phone(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    if not item.parameters["desk"]:
        bodies.box(0, (-x, -y, 0.0), (x, y, height - 0.0008))
        bodies.box(1, (-x + 0.002, -y + 0.003, height - 0.0008), (x - 0.002, y - 0.003, height))
        return bodies.parts()
    wedge = np.array([(-y, 0.0), (y, 0.0), (y, 0.06), (-y, 0.02)])
    body = shapes.extrude(wedge, -x, x)
    # From (y, z; along x): the prism's axis becomes x.
    bodies.put(0, body, np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]))
    bodies.add(0, shapes.rounded_box((-x, -y + 0.02, 0.045), (-x + 0.05, y - 0.01, 0.08), 0.015, steps=1))
    return bodies.parts()


def _draw_electronics(rng: Random, style: Style) -> Item:
    size = rng.choice(
        [
            (0.05, 0.17, 0.02),
            (0.04, 0.19, 0.018),
            (0.2, 0.14, 0.04),
            (0.17, 0.24, 0.008),
            (0.11, 0.11, 0.1),
            (0.24, 0.2, 0.06),
        ]
    )
    return draft(size, (rng.choice([_CASE, _CASE, style.plastic, style.metal]), _KEYS))


def _device(item: Item) -> list[Part]:
    """A remote control, a router, a tablet, a loudspeaker: a dark thing with rounded edges."""
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.add(0, shapes.rounded_box((-x, -y, 0.0), (x, y, height), min(height, width) * 0.3, steps=1))
    if depth > 0.12 and height < 0.03:
        for i in range(4):
            at = -y + depth * (0.2 + 0.17 * i)
            bodies.box(1, (-x * 0.6, at, height - 0.001), (x * 0.6, at + depth * 0.08, height))
    return bodies.parts()


def _draw_speaker(rng: Random, style: Style, *, floor: bool) -> Item:
    size = (
        (rng.uniform(0.18, 0.28), rng.uniform(0.22, 0.34), rng.uniform(0.8, 1.15))
        if floor
        else (rng.uniform(0.15, 0.22), 0.2, rng.uniform(0.24, 0.36))
    )
    return draft(size, (rng.choice([style.wood, _CASE, _CASE]), _KEYS, style.metal))


def _speaker(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.012, 0.0), (x, y, height))
    front = shapes.rotation("x", math.pi / 2)
    at = height - width * 0.45
    for radius in (x * 0.5, x * 0.8, x * 0.8):
        if at - radius < 0.04:
            break
        profile = np.array(
            [(radius, 0.0), (radius, 0.01), (radius * 0.9, 0.012), (radius * 0.25, 0.002), (0.0, 0.006)]
        )
        cone = shapes.lathe(profile, segments=20, caps=False)
        bodies.put(1, cone, shapes.placement((0, -y + 0.013, at)) @ front)
        at -= radius * 2.2
    return bodies.parts()


def _draw_appliance(rng: Random, style: Style) -> Item:
    what = rng.choice(["kettle", "toaster", "coffee", "blender", "cooker"])
    size = {
        "kettle": (0.17, 0.22, 0.24),
        "toaster": (0.3, 0.17, 0.19),
        "coffee": (0.22, 0.3, 0.34),
        "blender": (0.18, 0.18, 0.4),
        "cooker": (0.28, 0.28, 0.26),
    }[what]
    return draft(
        size,
        (rng.choice([style.metal, _CASE, style.ceramic, style.accents[0]]), _CASE, style.glass),
        what=what,
    )


def _appliance(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, what = Bodies(item), item.parameters["what"]
    x, y = width / 2, depth / 2
    if what == "kettle":
        r = 0.075
        bodies.add(
            0,
            shapes.lathe(
                np.array(
                    [
                        (r, 0.0),
                        (r, 0.02),
                        (r * 0.95, 0.12),
                        (r * 0.72, height - 0.04),
                        (0.02, height - 0.015),
                        (0.012, height),
                        (0, height),
                    ]
                ),
                segments=20,
            ),
        )
        handle = np.array([(0, 0.06, height - 0.05), (0, y, height - 0.06), (0, y, 0.08), (0, 0.07, 0.06)])
        bodies.add(1, shapes.tube(handle, 0.01))
        bodies.put(
            0,
            shapes.cone(0.03, 0.012, 0.05),
            shapes.placement((0, -0.06, height - 0.1)) @ shapes.rotation("x", 0.9),
        )
    elif what == "toaster":
        bodies.add(0, shapes.rounded_box((-x, -y, 0.01), (x, y, height), 0.035))
        for side in (-1, 1):
            bodies.box(
                1,
                (-x * 0.8, side * 0.03 - 0.014, height - 0.001),
                (x * 0.8, side * 0.03 + 0.014, height + 0.001),
            )
        bodies.box(1, (x - 0.002, -0.015, height * 0.6), (x, 0.015, height * 0.7))
    elif what == "coffee":
        bodies.box(0, (-x, -y, 0.0), (x, y, 0.04))
        bodies.box(0, (-x, 0.03, 0.04), (x, y, height))
        bodies.box(1, (-x, -y, height - 0.1), (x, 0.03, height))
        bodies.add(
            2,
            shapes.lathe(
                np.array([(0.05, 0.0), (0.065, 0.04), (0.06, 0.12), (0.045, 0.14)]), segments=18, caps=False
            ),
        )
        bodies.put(1, shapes.cylinder(0.055, 0.07, segments=18), shapes.placement((0, -0.04, 0.045)))
    elif what == "blender":
        bodies.add(1, shapes.lathe(np.array([(0.085, 0.0), (0.08, 0.06), (0.055, 0.14)]), segments=18))
        bodies.put(
            2,
            shapes.lathe(np.array([(0.05, 0.0), (0.085, 0.22)]), segments=18, caps=False),
            shapes.placement((0, 0, 0.14)),
        )
        bodies.put(1, shapes.cylinder(0.086, 0.035, segments=18), shapes.placement((0, 0, height - 0.04)))
    else:
        bodies.add(
            0,
            shapes.lathe(
                np.array(
                    [(0.12, 0.0), (0.138, 0.03), (0.138, 0.18), (0.12, 0.235), (0.03, 0.25), (0.0, 0.25)]
                ),
                segments=24,
            ),
        )
        bodies.box(1, (-0.05, -y, 0.05), (0.05, -y + 0.03, 0.12))
    return bodies.parts()


def _draw_microwave(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.45, 0.52), rng.uniform(0.33, 0.4), rng.uniform(0.26, 0.31)),
        (rng.choice([style.ceramic, _CASE, style.metal]), style.screen, style.metal),
    )


def _microwave(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.025, 0.0), (x, y, height))
    bodies.box(0, (-x + 0.002, -y + 0.012, 0.005), (x - 0.002, -y + 0.024, height - 0.004))
    bodies.box(1, (-x + 0.03, -y + 0.01, 0.04), (x - 0.13, -y + 0.012, height - 0.04))
    bodies.box(1, (x - 0.1, -y + 0.01, 0.04), (x - 0.02, -y + 0.012, height - 0.04))
    bodies.bars(2, [((x - 0.12, -y + 0.004, 0.05), (x - 0.12, -y + 0.004, height - 0.05))], 0.005)
    return bodies.parts()


def _draw_stereo(rng: Random, style: Style) -> Item:
    return draft(
        (0.43, 0.34, rng.uniform(0.08, 0.16)), (rng.choice([_CASE, style.metal]), _KEYS, style.metal)
    )


def _stereo(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.012, 0.008), (x, y, height))
    for side in (-1, 1):
        bodies.box(1, (side * (x - 0.05) - 0.02, -y + 0.05, 0.0), (side * (x - 0.05) + 0.02, y - 0.05, 0.008))
    front = shapes.rotation("x", math.pi / 2)
    for at, radius in ((x - 0.06, 0.022), (-x + 0.05, 0.012), (-x + 0.1, 0.012)):
        bodies.put(
            2,
            shapes.cylinder(radius, 0.012, segments=16),
            shapes.placement((at, -y + 0.012, height / 2)) @ front,
        )
    bodies.box(1, (-0.08, -y + 0.01, height * 0.35), (0.06, -y + 0.012, height * 0.75))
    return bodies.parts()


def _draw_till(rng: Random, style: Style) -> Item:
    return draft((0.36, 0.36, 0.36), (_CASE, style.screen, _KEYS))


def _till(item: Item) -> list[Part]:
    width, depth, _height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, 0.0), (x, y, 0.1))
    bodies.bars(0, [((0, 0.05, 0.1), (0, 0.05, 0.2))], 0.02)
    lean = shapes.placement((0, 0.0, 0.13)) @ shapes.rotation("x", -0.35)
    bodies.put(0, shapes.box((-x * 0.9, 0.0, 0.0), (x * 0.9, 0.02, 0.23)), lean)
    bodies.put(1, shapes.panel((-x * 0.86, -0.001, 0.012), (x * 1.72, 0, 0), (0, 0, 0.206)), lean)
    return bodies.parts()


PIECES = (
    Piece("tv", "tv", lambda rng, style: _draw_screen(rng, style, "tv"), _screen),
    Piece("wall_tv", "wall_tv", lambda rng, style: _draw_screen(rng, style, "wall_tv"), _screen),
    Piece("monitor", "monitor", lambda rng, style: _draw_screen(rng, style, "monitor"), _screen),
    Piece("keyboard", "keyboard", _draw_keyboard, _keyboard),
    Piece("laptop", "laptop", _draw_laptop, _laptop),
    Piece("printer", "printer", _draw_printer, _printer),
    Piece("phone", "phone", _draw_phone, _phone),
    Piece("device", "electronics", _draw_electronics, _device),
    Piece("floor_speaker", "speaker", lambda rng, style: _draw_speaker(rng, style, floor=True), _speaker),
    Piece("small_speaker", "stereo", lambda rng, style: _draw_speaker(rng, style, floor=False), _speaker),
    Piece("amplifier", "stereo", _draw_stereo, _stereo),
    Piece("appliance", "appliance", _draw_appliance, _appliance),
    Piece("microwave", "microwave", _draw_microwave, _microwave),
    Piece("till", "till", _draw_till, _till),
)
