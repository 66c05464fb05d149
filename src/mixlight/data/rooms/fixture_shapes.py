"""Lamps as meshes: the body that holds the light, and the faces that shine.

Convention: every body is made in the fixture's own frame, its origin in the middle of what emits; all faces
of a fixture together give its power in lumens, each evenly in all directions of its outside (Lambert).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Emission, Mesh, Part
from mixlight.data.rooms.plan import Fixture, Plan, Surface
from mixlight.data.rooms.sky import LUMENS_PER_UNIT
from mixlight.image.temperature import COOLEST, WARMEST, black_body

__all__ = ["fixture_parts", "mesh_area", "parts"]

_WHITE = Surface("plastic", (0.8, 0.8, 0.78), roughness=0.4)
_DARK = Surface("metal", (0.03, 0.03, 0.03), roughness=0.4)
_WAX = Surface("plastic", (0.85, 0.82, 0.72), roughness=0.5)
_GLASS = (0.75, 0.75, 0.72)
"""Reflectance of white glass that is off."""


def parts(plan: Plan) -> list[Part]:
    """The bodies of all fixtures of a plan, placed in the room frame.

    Those that are off shine, too: their group is rendered, and stays out of the mix.
    """
    return [part for fixture in plan.fixtures for part in fixture_parts(fixture)]


def fixture_parts(fixture: Fixture) -> list[Part]:
    """One fixture, placed in the room frame.

    Raises:
        ValueError: an unknown kind.
    """
    if fixture.kind not in _MAKERS:
        raise ValueError(f"expected a fixture of kind {', '.join(_MAKERS)}, got {fixture.kind!r}")
    bench = _Bench(fixture)
    _MAKERS[fixture.kind](bench)
    matrix = shapes.placement(fixture.position, fixture.turn)
    return [shapes.move(part, matrix) for part in bench.parts]


def mesh_area(mesh: Mesh) -> float:
    """Area of a mesh's faces in m².

    >>> round(mesh_area(shapes.box((0, 0, 0), (1, 2, 3))), 6)
    22.0
    """
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    first = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    quads = mesh.faces[:, 3] >= 0
    d = mesh.vertices[mesh.faces[quads, 3]]
    second = np.linalg.norm(np.cross(c[quads] - a[quads], d - a[quads]), axis=1)
    return float((first.sum() + second.sum()) / 2)


@dataclass
class _Bench:
    """Where one fixture is put together."""

    fixture: Fixture
    parts: list[Part] = field(default_factory=list)

    def __post_init__(self) -> None:
        kelvin = min(max(self.fixture.temperature, WARMEST), COOLEST)
        self.colour = black_body(kelvin)
        surfaces = self.fixture.surfaces
        self.metal = surfaces[0] if surfaces else _DARK
        self.shade = surfaces[1] if len(surfaces) > 1 else _WHITE

    def get(self, name: str, default: Any) -> Any:
        return self.fixture.parameters.get(name, default)

    def body(self, mesh: Mesh, surface: Surface) -> None:
        self.parts.append(Part(mesh, surface, f"{self.fixture.name}_body"))

    def glow(
        self,
        mesh: Mesh,
        share: float = 1.0,
        *,
        two_sided: bool = False,
        reflectance: tuple[float, float, float] = _GLASS,
        tint: tuple[float, float, float] = (1.0, 1.0, 1.0),
    ) -> None:
        """Faces that give a share of the power: radiance = lumens / (pi area 683) in the lamp's colour."""
        sides = 2 if two_sided else 1
        colour = self.colour * np.array(tint)
        colour = colour / (colour @ (0.2126, 0.7152, 0.0722))
        level = self.fixture.power * share / (math.pi * mesh_area(mesh) * sides * LUMENS_PER_UNIT)
        red, green, blue = (float(c) * level for c in colour)
        emission = Emission(self.fixture.group, (red, green, blue), two_sided, reflectance)
        self.parts.append(Part(mesh, emission, f"{self.fixture.name}_light"))


def _disc(radius: float, z: float, *, down: bool = True, segments: int = 24) -> Mesh:
    profile = [[0.0, z], [radius, z]] if down else [[radius, z], [0.0, z]]
    return shapes.lathe(np.array(profile), segments=segments, caps=False)


def _sheet(width: float, depth: float, z: float, *, down: bool = True) -> Mesh:
    x, y = width / 2, depth / 2
    return shapes.polygon(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), z, up=not down)


def _panel(b: _Bench) -> None:
    width, depth, _ = b.fixture.size
    rim, thick = 0.015, 0.014
    b.glow(_sheet(width, depth, 0.0))
    x, y = width / 2, depth / 2
    low = np.array([[-x - rim, -y - rim], [-x - rim, y], [-x - rim, -y], [x, -y]])
    high = np.array([[x + rim, -y], [x + rim, y + rim], [-x, y], [x + rim, y]])
    z0, z1 = np.full((4, 1), -0.002), np.full((4, 1), thick)
    b.body(shapes.boxes(np.hstack((low, z0)), np.hstack((high, z1))), b.metal)


def _tube(b: _Bench) -> None:
    length, width, _ = b.fixture.size
    x, lift = length / 2, 0.02
    style = b.get("style", "batten")
    if style == "linear":
        b.body(shapes.box((-x, -width / 2, 0.001), (x, width / 2, 0.06)), b.metal)
        b.glow(_sheet(length - 0.01, width * 0.9, 0.0))
    else:
        b.body(shapes.box((-x - 0.02, -width / 2, lift), (x + 0.02, width / 2, lift + 0.05)), _WHITE)
        count = 1 if width < 0.1 else 2
        for i in range(count):
            y = 0.0 if count == 1 else (i - 0.5) * width * 0.6
            path = np.array([[-x, y, 0.0], [x, y, 0.0]])
            b.glow(shapes.tube(path, 0.013, segments=10, caps=False), 1 / count)
            for end in (-x, x):
                b.body(shapes.box((end - 0.015, y - 0.016, -0.016), (end + 0.015, y + 0.016, lift)), _WHITE)
    drop = b.get("drop", 0.0)
    if drop > 0.1:
        for end in (-0.8 * x, 0.8 * x):
            b.body(shapes.cylinder(0.003, drop, base=(end, 0.0, 0.05), segments=6), _DARK)


def _downlight(b: _Bench) -> None:
    radius = b.fixture.size[0] / 2
    b.glow(_disc(radius, 0.003))
    r = np.array(
        [[radius * 1.0, 0.003], [radius * 1.02, -0.002], [radius * 1.35, -0.001], [radius * 1.4, 0.006]]
    )
    b.body(shapes.lathe(r, caps=False), b.metal)


def _can(b: _Bench, share: float, at: tuple[float, float, float], tilt: float, turn: float) -> None:
    """A spot in a tube, its light some centimetres inside; tilt from straight down."""
    radius, length = b.get("can_radius", 0.035), b.get("can_length", 0.12)
    sink = 0.3 * radius
    tube = shapes.lathe(
        np.array([[radius * 0.9, sink], [radius * 0.9, 0.0], [radius, 0.0], [radius, length], [0.0, length]]),
        segments=20,
        caps=False,
    )
    lamp = _disc(radius * 0.88, sink)
    c, s = math.cos(tilt), math.sin(tilt)
    lean = np.array([[1.0, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])
    matrix = shapes.placement(at, turn) @ lean
    b.body(shapes.transform(tube, matrix), b.metal)
    b.glow(shapes.transform(lamp, matrix), share)


def _track(b: _Bench) -> None:
    length = b.fixture.size[0]
    heads = b.get("heads", [])
    rise = b.get("rise", 0.16)
    b.body(shapes.box((-length / 2, -0.017, rise - 0.03), (length / 2, 0.017, rise)), b.metal)
    for x, tilt, turn in heads:
        b.body(shapes.cylinder(0.008, rise - 0.08, base=(x, 0.0, 0.06), segments=8), b.metal)
        _can(b, 1 / len(heads), (x, 0.0, 0.0), tilt, turn)


def _bulb(b: _Bench, share: float, z: float = 0.0, radius: float = 0.03) -> None:
    b.glow(shapes.sphere(radius, centre=(0.0, 0.0, z), segments=14, rings=8), share)


def _drum(b: _Bench, bottom: float, top: float, height: float, through: float) -> None:
    """A shade of cloth or paper that glows most around its bulb; the rest leaves above and below.

    `through` is the share of the power that the shade itself gives.
    """
    count = 8
    z = np.linspace(-height / 2, height / 2, count + 1)
    radius = np.interp(z, [-height / 2, height / 2], [bottom, top])
    middle = (z[1:] + z[:-1]) / 2
    weight = 0.35 + np.exp(-0.5 * (middle / (0.28 * height)) ** 2)
    area = (radius[1:] + radius[:-1]) * np.diff(z)
    share = weight * area / (weight * area).sum()
    tint = tuple(b.get("tint", (1.0, 0.92, 0.8)))
    for i in range(count):
        band = np.array([[radius[i], z[i]], [radius[i + 1], z[i + 1]]])
        mesh = shapes.lathe(band, segments=28, caps=False)
        b.glow(
            mesh,
            through * float(share[i]),
            two_sided=True,
            reflectance=b.shade.colour,
            tint=(tint[0], tint[1], tint[2]),
        )
    for r, height_at in ((bottom, -height / 2), (top, height / 2)):
        b.body(shapes.torus(r, 0.003, centre=(0.0, 0.0, height_at), segments=28, sides=6), b.metal)
    _bulb(b, 1 - through)


def _shade(b: _Bench) -> None:
    """What hangs on a cable or stands on a pole."""
    style = b.get("shade", "drum")
    width, _, height = b.fixture.size
    radius = width / 2
    if style == "globe":
        b.glow(shapes.sphere(radius, segments=28, rings=14))
    elif style == "paper":
        b.glow(shapes.sphere(radius, segments=28, rings=14), 0.97, reflectance=(0.8, 0.78, 0.7))
        b.glow(_disc(0.25 * radius, -radius * 0.975), 0.03)
    elif style == "bare":
        _bulb(b, 1.0, radius=b.get("bulb", 0.03))
        b.body(shapes.cylinder(0.02, 0.06, base=(0, 0, 0.025), segments=14), b.metal)
    elif style == "cone":
        neck = max(0.03, 0.18 * radius)
        rise = 0.55 * height
        outer = np.array([[radius, -height / 2], [neck, rise], [neck, rise + 0.04], [0.0, rise + 0.04]])
        inner = np.array([[neck - 0.003, rise - 0.004], [radius - 0.003, -height / 2]])
        b.body(shapes.lathe(outer, segments=28, caps=False), b.shade)
        b.body(shapes.lathe(inner, segments=28, caps=False), _WHITE)
        _bulb(b, 1.0, z=0.05 * height)
    elif style == "bowl":
        # Opaque, open above: all light goes to the ceiling.
        bowl = np.array([[0.0, -height / 2], [0.6 * radius, -0.4 * height], [radius, height / 2]])
        b.body(shapes.lathe(bowl, segments=28, caps=False), b.shade)
        lining = np.array(
            [[radius - 0.003, height / 2], [0.58 * radius, -0.38 * height], [0.0, -0.45 * height]]
        )
        b.body(shapes.lathe(lining, segments=28, caps=False), _WHITE)
        b.glow(_disc(0.5 * radius, 0.0, down=False))
    else:
        _drum(b, b.get("bottom", radius), b.get("top", radius), height, b.get("through", 0.4))


def _pendant(b: _Bench) -> None:
    drop = b.get("drop", 0.5)
    style = b.get("shade", "drum")
    if style == "chandelier":
        _chandelier(b, drop)
        return
    _shade(b)
    top = {"globe": 0.5, "paper": 0.5, "cone": 0.55}.get(style, 0.0) * b.fixture.size[2]
    start = max(top, 0.03)
    b.body(shapes.cylinder(0.004, max(drop - start, 0.01), base=(0, 0, start), segments=8), _DARK)
    b.body(shapes.cylinder(0.05, 0.025, base=(0, 0, max(drop - 0.025, start)), segments=20), b.metal)


def _chandelier(b: _Bench, drop: float) -> None:
    count, radius = b.get("arms", 6), b.fixture.size[0] / 2
    b.body(shapes.cylinder(0.012, drop + 0.1, base=(0, 0, -0.1), segments=10), b.metal)
    b.body(shapes.sphere(0.045, centre=(0, 0, -0.1)), b.metal)
    b.body(shapes.cylinder(0.06, 0.025, base=(0, 0, drop - 0.025), segments=20), b.metal)
    for i in range(count):
        angle = 2 * math.pi * i / count
        c, s = math.cos(angle), math.sin(angle)
        reach = np.array([[0, -0.1], [0.35, -0.17], [0.75, -0.16], [1.0, -0.09], [1.0, -0.05]])
        path = np.stack((reach[:, 0] * radius * c, reach[:, 0] * radius * s, reach[:, 1]), -1)
        b.body(shapes.tube(path, 0.006), b.metal)
        b.glow(shapes.sphere(0.02, centre=(radius * c, radius * s, -0.01), segments=12, rings=8), 1 / count)


def _flush(b: _Bench) -> None:
    radius, height = b.fixture.size[0] / 2, b.fixture.size[2]
    half = height / 2
    if b.get("style", "drum") == "dome":
        angles = np.linspace(0.0, math.pi / 2, 7)
        profile = np.stack((radius * np.sin(angles), half - height * np.cos(angles)), -1)
        profile[0, 0] = 0.0
        b.glow(shapes.lathe(profile, segments=28, crease=math.pi, caps=False))
    else:
        profile = np.array([[0.0, -half], [radius, -half], [radius, half]])
        b.glow(shapes.lathe(profile, segments=28, caps=False))
    b.body(shapes.cylinder(radius * 1.03, 0.012, base=(0, 0, half), segments=28), b.metal)


def _sconce(b: _Bench) -> None:
    """On a wall whose face lies `gap` metres behind (+y)."""
    width, depth, height = b.fixture.size
    gap = b.get("gap", 0.06)
    style = b.get("style", "globe")
    if style == "updown":
        x, y, z = width / 2, depth / 2, height / 2
        for sign in (-1, 1):
            b.body(shapes.box((sign * x - 0.003, -y, -z), (sign * x + 0.003, gap, z)), b.shade)
        b.body(shapes.box((-x, -y - 0.003, -z), (x, -y + 0.003, z)), b.shade)
        b.glow(_sheet(width * 0.8, depth * 0.7, z * 0.5, down=False), b.get("up", 0.5))
        b.glow(_sheet(width * 0.8, depth * 0.7, -z * 0.5, down=True), 1 - b.get("up", 0.5))
        return
    if style == "bar":
        b.glow(
            shapes.rounded_box(
                (-width / 2, -depth / 2, -height / 2), (width / 2, depth / 2, height / 2), 0.012
            )
        )
    elif style == "drum":
        _drum(b, width / 2, width / 2 * 0.8, height, 0.5)
    else:
        b.glow(shapes.sphere(width / 2, segments=20, rings=10))
    b.body(shapes.box((-0.012, 0.0, -0.012), (0.012, gap, 0.012)), b.metal)
    b.body(shapes.box((-0.05, gap - 0.015, -0.06), (0.05, gap, 0.06)), b.metal)


def _floor_lamp(b: _Bench) -> None:
    height = b.get("height", 1.4)
    style = b.get("shade", "drum")
    _shade(b)
    foot = -height
    if style == "bare" or b.get("arc", False):
        reach = b.get("reach", 0.0)
    else:
        reach = 0.0
    b.body(shapes.cylinder(b.get("foot", 0.14), 0.02, base=(0, reach, foot), segments=28), b.metal)
    if reach:
        t = np.linspace(0.0, 1.0, 14)
        path = np.stack(
            (0 * t, reach * (1 - t**2.2), foot + 0.02 + (height + 0.25) * np.sin(t * 2.2) / np.sin(2.2) * t),
            -1,
        )
        path[-1] = (0.0, 0.0, 0.55 * b.fixture.size[2])
        b.body(shapes.tube(path, 0.01), b.metal)
    else:
        b.body(shapes.cylinder(0.011, height - 0.02, base=(0, 0, foot + 0.02), segments=12), b.metal)


def _table_lamp(b: _Bench) -> None:
    height = b.get("height", 0.35)
    foot = -height
    if b.get("desk", False):
        b.body(shapes.cylinder(0.09, 0.02, base=(0, 0.18, foot), segments=24), b.metal)
        joint = np.array([[0, 0.18, foot + 0.02], [0, 0.3, -0.02 + 0.05], [0.0, 0.02, 0.1]])
        b.body(shapes.tube(joint, 0.007), b.metal)
        _shade(b)
        return
    _shade(b)
    belly, neck = b.get("belly", 0.07), 0.012
    rise = max(height - 0.5 * b.fixture.size[2], 0.05)
    z = np.array([0.0, 0.06, 0.35, 0.75, 1.0]) * rise + foot
    r = np.array([0.8, 0.95, 1.0, 0.4, neck / belly]) * belly
    b.body(
        shapes.lathe(np.stack((r, z), -1), segments=24, crease=math.pi),
        b.shade if b.get("painted", 0) else b.metal,
    )
    b.body(
        shapes.cylinder(neck, max(-(foot + rise) - 0.02, 0.01), base=(0, 0, foot + rise), segments=10),
        b.metal,
    )


def _screen(b: _Bench) -> None:
    """A picture of rectangles that looks along -y."""
    width, _, height = b.fixture.size
    rng = np.random.default_rng(int(b.get("seed", 0)))
    columns, rows = int(rng.integers(1, 4)), int(rng.integers(2, 6))
    xs = np.concatenate(([0.0], np.sort(rng.uniform(0.1, 0.9, columns - 1)), [1.0]))
    zs = np.concatenate(([0.0], np.sort(rng.uniform(0.1, 0.95, rows - 1)), [1.0]))
    levels = rng.choice([0.03, 0.12, 0.4, 1.0], (columns, rows), p=[0.25, 0.25, 0.25, 0.25])
    tints = rng.uniform(0.45, 1.0, (columns, rows, 3))
    weight = levels * np.outer(np.diff(xs), np.diff(zs))
    for i in range(columns):
        for j in range(rows):
            x0, x1 = (xs[i : i + 2] - 0.5) * width
            z0, z1 = (zs[j : j + 2] - 0.5) * height
            corners = np.array([[x0, 0, z0], [x1, 0, z0], [x1, 0, z1], [x0, 0, z1]])
            mesh = Mesh(corners, np.array([[0, 1, 2, 3]]))
            red, green, blue = (float(c) for c in tints[i, j])
            share = float(weight[i, j] / weight.sum())
            b.glow(mesh, share, reflectance=(0.02, 0.02, 0.02), tint=(red, green, blue))


def _candle(b: _Bench) -> None:
    radius, height = b.get("radius", 0.02), b.get("height", 0.1)
    b.body(shapes.cylinder(radius, height, base=(0, 0, -height - 0.018), segments=16), _WAX)
    flame = np.array([[0.0, -0.016], [0.005, -0.006], [0.004, 0.006], [0.0, 0.02]])
    b.glow(shapes.lathe(flame, segments=10, crease=math.pi, caps=False))


def _under_cabinet(b: _Bench) -> None:
    length, depth, _ = b.fixture.size
    b.body(shapes.box((-length / 2, -depth / 2, 0.001), (length / 2, depth / 2, 0.012)), b.metal)
    b.glow(_sheet(length * 0.98, depth * 0.7, 0.0))


_MAKERS: dict[str, Callable[[_Bench], None]] = {
    "panel": _panel,
    "tube": _tube,
    "downlight": _downlight,
    "track": _track,
    "pendant": _pendant,
    "flush": _flush,
    "sconce": _sconce,
    "floor_lamp": _floor_lamp,
    "table_lamp": _table_lamp,
    "under_cabinet": _under_cabinet,
    "screen": _screen,
    "candle": _candle,
    "neighbour": _flush,
}
