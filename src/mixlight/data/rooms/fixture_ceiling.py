"""Light that hangs from the ceiling: which scheme a kind of room has, how many lamps and how strong."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from mixlight.data.rooms.fixture_site import Site
from mixlight.data.rooms.outline import contains_rectangle
from mixlight.data.rooms.plan import Point2, Surface

__all__ = ["ceiling", "plain_lamp"]

_WHITE = Surface("plastic", (0.8, 0.8, 0.78), roughness=0.4)
_UTILISATION = 0.45
"""Share of the lamps' light that arrives at the height of a table."""

_SHIFTS = ((0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2), (0.2, 0.2), (-0.2, -0.2))
"""Parts of the distance by which a grid may move."""

_SCHEMES: dict[str, Mapping[str, float]] = {
    "living": {"pendant": 0.34, "flush": 0.14, "down": 0.16, "track": 0.10, "none": 0.26},
    "bedroom": {"pendant": 0.36, "flush": 0.26, "down": 0.14, "none": 0.24},
    "office": {"panel": 0.42, "tube": 0.16, "linear": 0.2, "down": 0.12, "pendant": 0.1},
    "kitchen": {"flush": 0.16, "down": 0.3, "pendant": 0.28, "tube": 0.1, "track": 0.16},
    "bathroom": {"flush": 0.4, "down": 0.36, "none": 0.24},
    "hall": {"pendants": 0.28, "panel": 0.18, "down": 0.26, "linear": 0.14, "chandelier": 0.14},
    "corridor": {"down": 0.34, "flush": 0.34, "panel": 0.14, "pendant": 0.18},
    "shop": {"track": 0.4, "panel": 0.2, "tube": 0.14, "down": 0.26},
    "workshop": {"tube": 0.56, "pendants": 0.44},
    "empty": {"bare": 0.4, "none": 0.36, "flush": 0.14, "down": 0.1},
}
_LUX: dict[str, tuple[float, float]] = {
    "living": (60, 200),
    "bedroom": (50, 150),
    "office": (250, 600),
    "kitchen": (120, 350),
    "bathroom": (100, 300),
    "hall": (100, 400),
    "corridor": (60, 200),
    "shop": (300, 900),
    "workshop": (200, 600),
    "empty": (50, 150),
}
"""Illuminance that the ceiling is made for."""


def ceiling(site: Site) -> None:
    """Hangs one scheme of ceiling light into a space; behind doors a plain one."""
    if site.index:
        _neighbour(site)
        return
    schemes = _SCHEMES.get(site.space.kind, _SCHEMES["living"])
    scheme = site.rng.choices(list(schemes), list(schemes.values()))[0]
    if scheme != "none":
        _MAKERS[scheme](site)


def plain_lamp(site: Site) -> None:
    """One flush lamp, for a room that would have no light at all."""
    _flushes(site)


def _lumens(site: Site) -> float:
    low, high = _LUX.get(site.space.kind, (100.0, 300.0))
    lux = math.exp(site.rng.uniform(math.log(low), math.log(high)))
    return lux * site.area / _UTILISATION


def _grid(site: Site, spacing: tuple[float, float], size: Point2, drop: float) -> list[Point2]:
    """Places in rows over the ceiling where a rectangle of this size has room.

    The rows stand evenly, or moved a little where more of them are free of beams, ducts and cupboards.
    """
    x0, y0, x1, y1 = site.bounds
    nx = max(1, round((x1 - x0) / spacing[0]))
    ny = max(1, round((y1 - y0) / spacing[1]))
    dx, dy = (x1 - x0) / nx, (y1 - y0) / ny
    half = (size[0] / 2, size[1] / 2)
    best: list[Point2] = []
    for u, v in _SHIFTS:
        places = [
            (x, y)
            for x in (x0 + dx * (i + 0.5 + u) for i in range(nx))
            for y in (y0 + dy * (j + 0.5 + v) for j in range(ny))
            if site.under_ceiling((x - half[0], y - half[1], x + half[0], y + half[1]), drop)
        ]
        if len(places) > len(best):
            best = places
        if len(best) == nx * ny:
            break
    return best


def _centre(site: Site, radius: float, drop: float) -> Point2 | None:
    """The middle of the ceiling, or the free place nearest to it."""
    x0, y0, x1, y1 = site.bounds
    middle = ((x0 + x1) / 2, (y0 + y1) / 2)
    tries = [middle]
    tries += [(site.rng.uniform(x0, x1), site.rng.uniform(y0, y1)) for _ in range(30)]
    free = [
        (x, y) for x, y in tries if site.under_ceiling((x - radius, y - radius, x + radius, y + radius), drop)
    ]
    return min(free, key=lambda p: math.dist(p, middle)) if free else None


def _circuits(site: Site, places: list[Point2]) -> list[str]:
    """The group of each place: one switch, or one for each half of a large room."""
    if len(places) < 4 or site.rng.random() > 0.4:
        return ["ceiling"] * len(places)
    x0, y0, x1, y1 = site.bounds
    if x1 - x0 > y1 - y0:
        return ["ceiling" if x < (x0 + x1) / 2 else "ceiling_2" for x, _ in places]
    return ["ceiling" if y < (y0 + y1) / 2 else "ceiling_2" for _, y in places]


def _panels(site: Site) -> None:
    rng = site.rng
    width, depth = rng.choice([(0.6, 0.6), (0.6, 0.6), (1.2, 0.3), (0.3, 1.2), (1.2, 0.6)])
    spacing = rng.uniform(1.8, 2.8), rng.uniform(1.8, 2.8)
    places = _grid(site, spacing, (width, depth), 0.02)
    if not places:
        _flushes(site)
        return
    power = min(max(_lumens(site) / len(places), 1200.0), 5500.0)
    for (x, y), group in zip(places, _circuits(site, places), strict=True):
        if rng.random() > 0.04:  # a few are dead
            site.add(
                "panel", group, (x, y, site.height - 0.015), (width, depth, 0.01), power, surfaces=(_WHITE,)
            )


def _tubes(site: Site) -> None:
    _rows(site, "batten", 0.0 if site.height < 3.0 else site.rng.choice([0.0, site.height - 2.8]))


def _linears(site: Site) -> None:
    _rows(site, "linear", site.rng.uniform(0.3, 0.6) if site.height > 2.55 else 0.0)


def _rows(site: Site, style: str, drop: float) -> None:
    rng = site.rng
    length = rng.choice([1.2, 1.2, 1.5]) if style == "batten" else rng.choice([1.2, 1.5, 2.4])
    x0, y0, x1, y1 = site.bounds
    along_x = x1 - x0 > y1 - y0 if rng.random() < 0.75 else x1 - x0 <= y1 - y0
    size = (length, 0.12) if along_x else (0.12, length)
    across = rng.uniform(1.8, 3.0)
    along = length + rng.uniform(0.3, 1.2)
    places = _grid(site, (along, across) if along_x else (across, along), size, drop + 0.1)
    if not places:
        _flushes(site)
        return
    width = rng.choice([0.06, 0.13]) if style == "batten" else rng.uniform(0.05, 0.09)
    power = min(max(_lumens(site) / len(places), 1000.0), 6000.0)
    metal = _WHITE if rng.random() < 0.6 else site.metal
    for (x, y), group in zip(places, _circuits(site, places), strict=True):
        if rng.random() > 0.05:
            site.add(
                "tube",
                group,
                (x, y, site.height - drop - 0.075),
                (length, width, 0.026),
                power,
                turn=0.0 if along_x else math.pi / 2,
                surfaces=(metal,),
                style=style,
                drop=round(drop, 3),
            )


def _downlights(site: Site) -> None:
    rng = site.rng
    radius = rng.uniform(0.03, 0.05) if rng.random() < 0.7 else rng.uniform(0.06, 0.09)
    home = site.space.kind in ("living", "bedroom", "kitchen", "bathroom", "empty", "corridor")
    spacing = rng.uniform(1.3, 2.6)
    places = _grid(site, (spacing, spacing), (0.2, 0.2), 0.02)
    if home and rng.random() < 0.45:  # only along one or two walls
        x0, y0, x1, y1 = site.bounds
        near = rng.sample([0, 1, 2, 3], rng.choice([1, 2]))
        rows = [(p[0] - x0, x1 - p[0], p[1] - y0, y1 - p[1]) for p in places]
        first = [min((row[k] for row in rows), default=0.0) for k in range(4)]
        kept = [any(row[k] < first[k] + 0.05 for k in near) for row in rows]
        places = [p for p, keep in zip(places, kept, strict=True) if keep]
    if not places:
        _flushes(site)
        return
    power = min(max(_lumens(site) / len(places), 250.0), 1800.0)
    metal = _WHITE if rng.random() < 0.6 else site.metal
    for (x, y), group in zip(places, _circuits(site, places), strict=True):
        if rng.random() > 0.03:
            position = (x, y, site.height - 0.008)
            site.add("downlight", group, position, (2 * radius, 2 * radius, 0.005), power, surfaces=(metal,))


def _tracks(site: Site) -> None:
    rng = site.rng
    x0, y0, x1, y1 = site.bounds
    along_x = x1 - x0 > y1 - y0
    span = max(x1 - x0, y1 - y0)
    count = 1 if site.space.kind in ("living", "kitchen") else max(1, round(min(x1 - x0, y1 - y0) / 2.8))
    length = min(rng.uniform(1.0, 2.4) if count == 1 else span * 0.8, span - 0.6)
    rise, drop = rng.uniform(0.14, 0.22), 0.02
    if site.height > 3.2:
        drop = site.height - 3.0
    heads = max(2, round(length / rng.uniform(0.4, 0.9)))
    total = _lumens(site) / count
    power = min(max(total, 350.0 * heads), 2200.0 * heads)
    radius = rng.uniform(0.03, 0.05)
    for k in range(count):
        share = (k + 0.5) / count if count > 1 else rng.uniform(0.3, 0.7)
        x = (x0 + x1) / 2 if along_x else x0 + (x1 - x0) * share
        y = y0 + (y1 - y0) * share if along_x else (y0 + y1) / 2
        half = (length / 2, 0.1) if along_x else (0.1, length / 2)
        if not site.under_ceiling((x - half[0], y - half[1], x + half[0], y + half[1]), rise + drop + 0.1):
            continue
        spots = [
            [
                round((i + 0.5) / heads * length - length / 2, 3),
                round(rng.uniform(0.1, 0.9), 3),
                round(rng.choice([0.0, math.pi]) + rng.uniform(-0.5, 0.5), 3),
            ]
            for i in range(heads)
        ]
        site.add(
            "track",
            "ceiling" if k % 2 == 0 or count < 3 else "ceiling_2",
            (x, y, site.height - drop - rise),
            (length, 0.12, 0.12),
            power,
            turn=0.0 if along_x else math.pi / 2,
            heads=spots,
            rise=round(rise, 3),
            can_radius=round(radius, 4),
            can_length=round(rng.uniform(0.09, 0.16), 3),
        )
    if not any(f.kind == "track" for f in site.fixtures):
        _downlights(site)


def _flushes(site: Site) -> None:
    rng = site.rng
    radius, height = rng.uniform(0.12, 0.26), rng.uniform(0.05, 0.11)
    long = max(site.bounds[2] - site.bounds[0], site.bounds[3] - site.bounds[1])
    many = site.space.kind == "corridor" or long > 6
    places = _grid(site, (3.0, 3.0), (2 * radius, 2 * radius), height) if many else []
    if not places:
        centre = _centre(site, radius, height)
        places = [] if centre is None else [centre]
    power = min(max(_lumens(site) / max(len(places), 1), 500.0), 3000.0)
    style = rng.choice(["drum", "dome"])
    for x, y in places:
        z = site.height - 0.012 - height / 2
        size = (2 * radius, 2 * radius, height)
        site.add("flush", "ceiling", (x, y, z), size, power, style=style, surfaces=(site.metal,))


def _pendants(site: Site) -> None:
    """One to three over the table, or one in the middle of the room."""
    rng = site.rng
    style, radius, tall, parameters = _pendant_style(site)
    tables = [
        item
        for item in site.items
        if item.kind in ("table", "round_table", "island", "bar_table") and max(item.size[:2]) > 0.75
    ]
    if tables and rng.random() < 0.75:
        table = rng.choice(tables)
        long_x = table.size[0] >= table.size[1]
        span = max(table.size[:2])
        count = 1 if span < 1.3 or radius > 0.22 else rng.choice([1, 2, 3, 3])
        z = table.position[2] + table.size[2] + rng.uniform(0.6, 0.85) + tall / 2
        turn = table.turn if long_x else table.turn + math.pi / 2
        offsets = [(i - (count - 1) / 2) * span / max(count, 2) for i in range(count)]
        places = [
            (table.position[0] + o * math.cos(turn), table.position[1] + o * math.sin(turn)) for o in offsets
        ]
    else:
        drop = rng.uniform(0.3, 0.8)
        z = max(site.height - drop, 2.05 + tall / 2)
        centre = _centre(site, radius, site.height - z + tall / 2)
        places = [] if centre is None else [centre]
    z = min(z, site.height - tall / 2 - 0.06)
    power = rng.uniform(600, 1800) / math.sqrt(max(len(places), 1))
    _hang(site, places, z, radius, tall, power, style, parameters)


def _hall_pendants(site: Site) -> None:
    """The same pendant again and again, as in cafés, halls and workshops."""
    rng = site.rng
    style, radius, tall, parameters = _pendant_style(site)
    spacing = rng.uniform(2.4, 4.0)
    z = max(min(site.height - 0.6, rng.uniform(2.4, 3.6)), 2.1)
    places = _grid(site, (spacing, spacing), (2 * radius, 2 * radius), site.height - z + tall / 2)
    power = min(max(_lumens(site) / max(len(places), 1), 500.0), 6000.0)
    _hang(site, places, z, radius, tall, power, style, parameters)


def _hang(
    site: Site,
    places: list[Point2],
    z: float,
    radius: float,
    tall: float,
    power: float,
    style: str,
    parameters: dict[str, float],
) -> None:
    surfaces = (site.metal, site.shade())
    for (x, y), group in zip(places, _circuits(site, places), strict=True):
        if not contains_rectangle(site.space.outline, (x - radius, y - radius, x + radius, y + radius)):
            continue
        site.add(
            "pendant",
            group,
            (x, y, z),
            (2 * radius, 2 * radius, tall),
            power,
            surfaces=surfaces,
            shade=style,
            drop=round(site.height - z, 3),
            **parameters,
        )


def _pendant_style(site: Site) -> tuple[str, float, float, dict[str, float]]:
    """Shade, radius, height of what emits, and further parameters."""
    rng = site.rng
    style = rng.choice(["drum", "drum", "globe", "cone", "cone", "paper", "bare"])
    if site.space.kind in ("workshop", "hall") and rng.random() < 0.6:
        style = "cone"
    if style == "globe":
        radius = rng.uniform(0.08, 0.2)
        return style, radius, 2 * radius, {}
    if style == "paper":
        radius = rng.uniform(0.18, 0.32)
        return style, radius, 2 * radius, {}
    if style == "bare":
        return style, 0.045, 0.09, {"bulb": round(rng.uniform(0.03, 0.06), 3)}
    if style == "cone":
        radius = rng.uniform(0.1, 0.26)
        return style, radius, radius * rng.uniform(0.8, 1.6), {}
    radius, height = rng.uniform(0.15, 0.3), rng.uniform(0.16, 0.32)
    return style, radius, height, {"through": round(rng.uniform(0.3, 0.6), 3)}


def _chandelier(site: Site) -> None:
    rng = site.rng
    radius = rng.uniform(0.3, 0.6)
    z = max(site.height - rng.uniform(0.7, 1.5), 2.2)
    centre = _centre(site, radius, site.height - z + 0.2)
    if centre is None:
        _flushes(site)
        return
    arms = rng.choice([5, 6, 8])
    site.add(
        "pendant",
        "ceiling",
        (*centre, z),
        (2 * radius, 2 * radius, 0.1),
        arms * rng.uniform(250, 500),
        shade="chandelier",
        arms=arms,
        drop=round(site.height - z, 3),
    )


def _bare(site: Site) -> None:
    z = site.height - site.rng.uniform(0.15, 0.5)
    centre = _centre(site, 0.05, site.height - z + 0.1)
    if centre is not None:
        parameters = {"bulb": 0.03}
        _hang(site, [centre], z, 0.045, 0.09, site.rng.uniform(400, 1500), "bare", parameters)


def _neighbour(site: Site) -> None:
    """What lights the space behind a door: nothing more is known of it than its glow."""
    group = f"neighbour_{min(site.index, 2)}"
    radius, height = site.rng.uniform(0.12, 0.22), site.rng.uniform(0.06, 0.1)
    places = _grid(site, (4.0, 4.0), (2 * radius, 2 * radius), height)
    if not places:
        centre = _centre(site, radius, height)
        places = [] if centre is None else [centre]
    power = min(max(_lumens(site) / max(len(places), 1), 400.0), 3500.0)
    for x, y in places:
        z = site.height - 0.012 - height / 2
        site.add("neighbour", group, (x, y, z), (2 * radius, 2 * radius, height), power, surfaces=(_WHITE,))


_MAKERS: dict[str, Callable[[Site], None]] = {
    "panel": _panels,
    "tube": _tubes,
    "linear": _linears,
    "down": _downlights,
    "track": _tracks,
    "flush": _flushes,
    "pendant": _pendants,
    "pendants": _hall_pendants,
    "chandelier": _chandelier,
    "bare": _bare,
}
