"""What a room is: plain data from which every mesh, material and light follows.

Convention: the room frame is Blender's: metres, +X right, +Y into the room, +Z up, the main space's floor at
z = 0; turns are radians, counter-clockwise seen from above, and a thing that is not turned faces -Y (a sofa's
back stands at +Y). Colours are linear Rec.709.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["Camera", "Fixture", "Item", "Opening", "Plan", "Sky", "Space", "Surface"]

VERSION = 1

Point2 = tuple[float, float]
Point3 = tuple[float, float, float]
Colour = tuple[float, float, float]

KINDS = (
    "living",
    "bedroom",
    "office",
    "kitchen",
    "bathroom",
    "hall",
    "corridor",
    "shop",
    "workshop",
    "empty",
)
"""What a space is for."""

SURFACES = (
    "paint",
    "plaster",
    "wallpaper",
    "wood",
    "planks",
    "carpet",
    "tile",
    "stone",
    "brick",
    "concrete",
    "metal",
    "plastic",
    "fabric",
    "leather",
    "glass",
    "mirror",
    "translucent",
    "paper",
    "picture",
    "plant",
    "skin",
    "outdoors",
)
"""What a thing is made of; each is one shader."""


@dataclass(frozen=True)
class Surface:
    """What a face is made of."""

    kind: str
    """One of `SURFACES`."""
    colour: Colour = (0.7, 0.7, 0.7)
    """Base colour, linear, each in [0, 1]."""
    second: Colour | None = None
    """Second colour of a pattern (grain, mortar, veins); the shader's own choice if not given."""
    roughness: float = 0.6
    metallic: float = 0.0
    scale: float = 1.0
    """Size of the pattern relative to the usual one (planks .12 m wide, tiles .3 m, bricks .22 m)."""
    bump: float = 0.0
    """Strength of the relief, 0 to 1."""
    transmission: float = 0.0
    """Share of light let through (translucent: curtains, shades; glass: clear)."""
    turn: float = 0.0
    """Turn of the pattern in radians."""
    seed: int = 0
    """Makes two surfaces of one kind differ in their pattern's place."""


@dataclass(frozen=True)
class Space:
    """One room of the plan: a prism over a polygon of right angles."""

    kind: str
    """One of `KINDS`."""
    outline: tuple[Point2, ...]
    """Corners, counter-clockwise, axis-aligned edges; edge i goes from corner i to i + 1.
    These are the inner faces of the walls."""
    height: float
    walls: tuple[Surface, ...]
    """One for each edge."""
    floor: Surface
    ceiling: Surface
    skirting: Surface | None = None
    details: dict[str, Any] = field(default_factory=dict)
    """Plain values of what is built in, each key optional (`mixlight.data.rooms.shell` reads them):
    beams, columns (each a list of [x0, y0, x1, y1, z0, z1] in the room frame), bands (of other material on a
    wall), cornice, grid (of a suspended ceiling)."""


@dataclass(frozen=True)
class Opening:
    """A rectangular hole in the wall behind one edge of a space."""

    kind: Literal["window", "door", "passage"]
    space: int
    edge: int
    start: float
    """Metres from the edge's first corner."""
    end: float
    bottom: float
    """Metres above the floor."""
    top: float
    leads: int | None = None
    """The space behind (written once, by the lower-numbered space); None: outdoors, or a shut door."""
    depth: float = 0.15
    """Thickness of the wall there in metres."""
    details: dict[str, Any] = field(default_factory=dict)
    """Plain values: frame (Surface fields), mullions (columns, rows), dressing (none, curtain,
    sheer, venetian, roller), drawn (share of the window that the dressing covers), angle (of a door, rad)."""


@dataclass(frozen=True)
class Item:
    """A piece of furniture or clutter, in its place."""

    kind: str
    """Catalogue kind: sofa, table, chair, bed, shelf, plant, book ..."""
    piece: str
    """Who makes it: `own:NAME` (our parametric pieces) or `library:NAME` (an object of the library)."""
    position: Point3
    """Centre of the footprint, and the height of the underside."""
    turn: float
    size: Point3
    """Width (x), depth (y), height (z) before the turn, in metres."""
    surfaces: tuple[Surface, ...] = ()
    """The piece's materials, in its own order; a library piece takes the first ones as recolouring."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """Plain values that the piece reads (number of shelves, seed ...)."""
    supported_by: int | None = None
    """The item of the plan that it stands on; None: the floor, a wall or the ceiling."""


@dataclass(frozen=True)
class Fixture:
    """A source of artificial light, with the thing that holds it."""

    name: str
    """Unique in the plan."""
    group: str
    """Light group: what one switch controls (`ceiling`, `floor_lamp_1` ...); letters, digits, `_`."""
    kind: str
    """panel, tube, downlight, track, pendant, flush, sconce, floor_lamp, table_lamp, under_cabinet, screen,
    candle, neighbour (light of the space behind a door)."""
    space: int
    position: Point3
    """Centre of what emits."""
    turn: float
    power: float
    """Luminous flux in lumens at full brightness."""
    temperature: float
    """Correlated colour temperature in kelvins."""
    size: Point3
    """Extent of what emits, in metres."""
    on: bool = True
    """As the plan was made; the remix may switch it."""
    surfaces: tuple[Surface, ...] = ()
    parameters: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Sky:
    """What is outside the windows."""

    time: Literal["day", "dusk", "night"]
    file: str | None
    """Name of an outdoor panorama in the folder of skies; None: an analytic sky."""
    turn: float
    illuminance: float
    """Of the sky without the sun, on the open ground, in lux."""
    colour: Colour
    """Tint that multiplies the panorama (or is the colour of the analytic sky's zenith)."""
    sun_direction: Point3 | None
    """Towards the sun, room frame, unit length; None: no sun."""
    sun_illuminance: float = 0.0
    """On a plane facing the sun, in lux."""
    sun_temperature: float = 5500.0
    sun_angle: float = 0.00935
    """Angular diameter in radians."""
    seed: int = 0
    """Of the clouds and the skyline of an analytic sky."""
    cloud: float = 0.0
    """Share of an analytic sky that clouds cover, 0 to 1."""


@dataclass(frozen=True)
class Camera:
    """Where a panorama is taken: level, its centre looks along `turn` (0: along +Y)."""

    space: int
    position: Point3
    turn: float


@dataclass(frozen=True)
class Plan:
    """A room, whole."""

    seed: int
    spaces: tuple[Space, ...]
    """The first is the main one, where the cameras are."""
    openings: tuple[Opening, ...]
    items: tuple[Item, ...]
    fixtures: tuple[Fixture, ...]
    sky: Sky
    cameras: tuple[Camera, ...]
    version: int = VERSION
