"""Light below the ceiling: on walls, floors and tables, under cupboards, in screens and candles."""

from __future__ import annotations

import math
import random
from typing import Any

from mixlight.data.rooms.fixture_site import Site, footprint
from mixlight.data.rooms.outline import Edge, holes_of, overlap
from mixlight.data.rooms.plan import Item, Point2, Surface

__all__ = ["candles", "lamps", "sconces", "screens", "under_cabinets"]

_FLOOR_LAMPS: dict[str, tuple[float, ...]] = {
    "living": (0.2, 0.5, 0.3),
    "bedroom": (0.6, 0.4),
    "office": (0.8, 0.2),
    "hall": (0.75, 0.15, 0.1),
    "empty": (0.9, 0.1),
    "workshop": (0.9, 0.1),
}
"""Probabilities of 0, 1, 2 ... of them."""
_TABLE_LAMPS: dict[str, tuple[float, ...]] = {
    "living": (0.25, 0.35, 0.25, 0.15),
    "bedroom": (0.12, 0.35, 0.53),
    "office": (0.6, 0.25, 0.15),
    "kitchen": (0.85, 0.15),
    "hall": (0.7, 0.15, 0.15),
    "shop": (0.85, 0.15),
    "workshop": (0.55, 0.3, 0.15),
    "corridor": (0.75, 0.25),
}
_SCONCES = {"living": 0.12, "bedroom": 0.3, "bathroom": 0.7, "hall": 0.35, "corridor": 0.25, "shop": 0.08}
_CARRIERS = (
    *("side_table", "nightstand", "desk", "console", "low_shelf", "sideboard", "dresser", "drawer_unit"),
    *("workbench", "coffee_table", "table", "counter", "tv_stand", "filing_cabinet"),
)
_SCREEN_CARRIERS = ("monitor", "tv", "wall_tv")
_SCREEN_LUMINANCE = (80.0, 350.0)
"""cd/m² of a white screen."""


def lamps(site: Site) -> None:
    """Floor lamps in corners and beside seats, table lamps on furniture."""
    rng = site.rng
    count = rng.choices(range(3), _padded(_FLOOR_LAMPS.get(site.space.kind, (1.0,)), 3))[0]
    for index in range(count):
        _floor_lamp(site, f"floor_lamp_{index + 1}")
    count = rng.choices(range(4), _padded(_TABLE_LAMPS.get(site.space.kind, (1.0,)), 4))[0]
    shape = _table_shape(site)
    carriers = [i for i in site.items if i.kind in _CARRIERS and 0.3 < i.position[2] + i.size[2] < 1.25]
    rng.shuffle(carriers)
    # Bedside tables first, as they are what a bedroom's lamps stand on.
    carriers.sort(
        key=lambda item: _CARRIERS.index(item.kind) if item.kind == "nightstand" else len(_CARRIERS)
    )
    done = 0
    for item in carriers:
        if done == count:
            return
        desk = item.kind in ("desk", "workbench") and rng.random() < 0.7
        done += _table_lamp(site, item, f"table_lamp_{min(done + 1, 2)}", shape, desk)


def _padded(weights: tuple[float, ...], length: int) -> list[float]:
    return [*weights, *[0.0] * (length - len(weights))]


def _floor_lamp(site: Site, group: str) -> None:
    rng = site.rng
    style = rng.choice(["drum", "drum", "drum", "bowl", "paper", "cone", "globe"])
    radius = {"cone": rng.uniform(0.08, 0.14), "globe": rng.uniform(0.1, 0.16)}.get(
        style, rng.uniform(0.16, 0.26)
    )
    place = _floor_place(site, radius)
    if place is None:
        return
    height = rng.uniform(1.15, 1.65) if style != "bowl" else rng.uniform(1.6, 1.85)
    tall = {"bowl": 0.12, "paper": 2 * radius, "globe": 2 * radius, "cone": 1.4 * radius}.get(
        style, rng.uniform(0.2, 0.36)
    )
    power = rng.uniform(350, 1000) if style != "bowl" else rng.uniform(900, 2500)
    parameters: dict[str, Any] = {"shade": style, "height": round(height, 3), "foot": 0.14}
    if style == "drum":
        parameters |= {"through": round(rng.uniform(0.35, 0.65), 3)}
        parameters |= {"top": round(radius * rng.uniform(0.6, 1.0), 3), "bottom": round(radius, 3)}
    site.add(
        "floor_lamp",
        group,
        (*place, height),
        (2 * radius, 2 * radius, tall),
        power,
        kelvin=_warm(site),
        **parameters,
    )


def _warm(site: Site) -> float:
    """Lamps for the evening are warmer than the ceiling's."""
    return round(min(site.kelvin(), max(2100.0, site.rng.gauss(2750.0, 200.0))))


def _floor_place(site: Site, radius: float) -> Point2 | None:
    """Beside a seat or along a wall."""
    rng = site.rng
    tries: list[Point2] = []
    for item in site.items:
        if item.kind in ("sofa", "armchair", "bed"):
            x0, y0, x1, y1 = footprint(item)
            gap = radius + 0.06
            corners = [(x0 - gap, y0 + gap), (x0 - gap, y1 - gap), (x1 + gap, y0 + gap), (x1 + gap, y1 - gap)]
            corners += [
                (x0 + gap, y0 - gap),
                (x1 - gap, y0 - gap),
                (x0 + gap, y1 + gap),
                (x1 - gap, y1 + gap),
            ]
            tries += corners
    rng.shuffle(tries)
    for edge in site.edges:
        tries += [edge.at(radius + 0.08, radius + 0.08), edge.at(edge.length - radius - 0.08, radius + 0.08)]
        tries += [edge.at(rng.uniform(0, edge.length), radius + 0.08) for _ in range(3)]
    free = [p for p in tries if site.floor_free(p, radius)]
    return free[0] if free and rng.random() < 0.7 else rng.choice(free) if free else None


def _table_shape(site: Site) -> dict[str, Any]:
    """The lamps of one room are often a pair."""
    rng = site.rng
    style = rng.choice(["drum", "drum", "drum", "globe", "cone"])
    radius = {"globe": rng.uniform(0.06, 0.11)}.get(style, rng.uniform(0.09, 0.17))
    return {
        "style": style,
        "radius": radius,
        "tall": 2 * radius if style == "globe" else radius * rng.uniform(1.0, 1.6),
        "lift": rng.uniform(0.2, 0.42),
        "through": round(rng.uniform(0.35, 0.65), 3),
        "narrow": rng.uniform(0.6, 1.0),
        "belly": round(rng.uniform(0.04, 0.09), 3),
        "painted": int(rng.random() < 0.5),
        "surfaces": (site.metal, site.shade()),
        "power": rng.uniform(180, 550),
        "kelvin": _warm(site),
    }


def _table_lamp(site: Site, item: Item, group: str, shape: dict[str, Any], desk: bool) -> int:
    """Puts a lamp on an item where its top is free; 1 if it did."""
    rng = site.rng
    top = item.position[2] + item.size[2]
    radius = 0.09 if desk else shape["radius"]
    tall = 0.12 if desk else shape["tall"]
    lift = max(0.3 if desk else shape["lift"], tall / 2 + 0.06)
    if top + lift + tall / 2 > site.height - 0.2:
        return 0
    place = _top_place(site, item, max(radius * 0.7, 0.06))
    if place is None:
        return 0
    position = (*place, top + lift)
    size = (2 * radius, 2 * radius, tall)
    if desk:
        site.add(
            "table_lamp", group, position, size, rng.uniform(250, 700),
            turn=item.turn, shade="cone", height=round(lift, 3), desk=True,
        )  # fmt: skip
    else:
        site.add(
            "table_lamp", group, position, size, shape["power"],
            turn=item.turn, kelvin=shape["kelvin"], surfaces=shape["surfaces"], shade=shape["style"],
            height=round(lift, 3), through=shape["through"], top=round(radius * shape["narrow"], 3),
            bottom=round(radius, 3), belly=shape["belly"], painted=shape["painted"],
        )  # fmt: skip
    return 1


def _top_place(site: Site, item: Item, radius: float) -> Point2 | None:
    """A place on the top of an item, near its sides and its back; small things there make way."""
    rng = site.rng
    width, depth = item.size[0] / 2 - radius, item.size[1] / 2 - radius
    if min(width, depth) < 0:
        return None
    c, s = math.cos(item.turn), math.sin(item.turn)
    for _ in range(14):
        u, v = rng.choice([-1, 1]) * width * rng.uniform(0.4, 1.0), depth * rng.uniform(-0.3, 1.0)
        x, y = item.position[0] + c * u - s * v, item.position[1] + s * u + c * v
        if any(math.dist((x, y), f.position[:2]) < 2 * radius + 0.05 for f in site.fixtures):
            continue
        if site.clear(item, (x - radius, y - radius, x + radius, y + radius), 0.6):
            return x, y
    return None


def sconces(site: Site) -> None:
    """Lamps on walls, in pairs; in bathrooms beside or above the mirror."""
    rng = site.rng
    if rng.random() > _SCONCES.get(site.space.kind, 0.0):
        return
    style = rng.choice(["updown", "globe", "drum", "bar" if site.space.kind == "bathroom" else "updown"])
    size = {
        "updown": (0.1, 0.09, rng.uniform(0.15, 0.3)),
        "globe": (rng.uniform(0.1, 0.18),) * 3,
        "drum": (rng.uniform(0.14, 0.22), 0.14, rng.uniform(0.14, 0.24)),
        "bar": (rng.uniform(0.35, 0.7), 0.04, 0.05),
    }[style]
    gap = {"bar": 0.06, "updown": 0.05}.get(style, size[0] / 2 + 0.05)
    power = rng.uniform(250, 900)
    parameters: dict[str, Any] = {"style": style, "gap": round(gap, 3)}
    if style == "updown":
        parameters["up"] = rng.choice([0.5, 0.5, 0.7, 1.0])
    surfaces = (site.metal, site.shade())
    spots = _mirror_spots(site, style, gap, size[2]) if site.space.kind == "bathroom" else []
    if site.space.kind == "bedroom":
        spots = _bed_spots(site, gap, size)
    if not spots:
        spots = _wall_spots(site, gap, size)
    for x, y, z, turn in spots:
        site.add("sconce", "sconces", (x, y, z), size, power, turn=turn, surfaces=surfaces, **parameters)


def _mirror_spots(site: Site, style: str, gap: float, tall: float) -> list[tuple[float, float, float, float]]:
    mirrors = [item for item in site.items if item.kind == "mirror"]
    if not mirrors:
        return []
    mirror = site.rng.choice(mirrors)
    c, s = math.cos(mirror.turn), math.sin(mirror.turn)
    back = mirror.size[1] / 2 - gap
    top = mirror.position[2] + mirror.size[2]
    if style == "bar":
        z = min(top + 0.06, site.height - 0.1)
        return [(mirror.position[0] - s * back, mirror.position[1] + c * back, z, mirror.turn)]
    found = []
    for side in (-1, 1):
        u = side * (mirror.size[0] / 2 + 0.14)
        x, y = mirror.position[0] + c * u - s * back, mirror.position[1] + s * u + c * back
        z = mirror.position[2] + 0.6 * mirror.size[2]
        reach = 0.1
        if site.under_ceiling((x - reach, y - reach, x + reach, y + reach), site.height - z + tall / 2) or (
            site.space.kind == "bathroom" and _inside(site, x, y)
        ):
            found.append((x, y, z, mirror.turn))
    return found


def _bed_spots(
    site: Site, gap: float, size: tuple[float, float, float]
) -> list[tuple[float, float, float, float]]:
    """On the wall behind a bed's head, at both sides of it."""
    beds = [item for item in site.items if item.kind == "bed"]
    if not beds:
        return []
    bed = site.rng.choice(beds)
    z = site.rng.uniform(1.0, 1.4)
    found = []
    for index, edge in enumerate(site.edges):
        if math.cos(edge.turn - bed.turn) < 0.99:
            continue
        dx, dy = bed.position[0] - edge.start[0], bed.position[1] - edge.start[1]
        away = dx * edge.inward[0] + dy * edge.inward[1] - bed.size[1] / 2
        middle = dx * edge.direction[0] + dy * edge.direction[1]
        if not -0.05 < away < 0.3:
            continue
        for side in (-1, 1):
            along = middle + side * (bed.size[0] / 2 + 0.12)
            if 0.1 < along < edge.length - 0.1 and _wall_free(site, edge, index, along, z, max(size)):
                found.append((*edge.at(along, gap), z, edge.turn))
    return found


def _inside(site: Site, x: float, y: float) -> bool:
    x0, y0, x1, y1 = site.bounds
    return x0 + 0.08 < x < x1 - 0.08 and y0 + 0.02 < y < y1 - 0.02


def _wall_spots(
    site: Site, gap: float, size: tuple[float, float, float]
) -> list[tuple[float, float, float, float]]:
    """Places on one or two walls, at regular distances, where nothing hangs."""
    rng = site.rng
    z = min(rng.uniform(1.65, 2.0), site.height - 0.35)
    order = list(range(len(site.edges)))
    rng.shuffle(order)
    found: list[tuple[float, float, float, float]] = []
    limit = 6 if site.space.kind in ("hall", "corridor", "shop") else 2
    for index in order[:2]:
        edge = site.edges[index]
        if edge.length < 1.2:
            continue
        count = max(1, min(limit, round(edge.length / rng.uniform(1.8, 3.0))))
        for k in range(count):
            along = edge.length * (k + 0.5) / count
            if _wall_free(site, edge, index, along, z, max(size)):
                found.append((*edge.at(along, gap), z, edge.turn))
    return found


def _wall_free(site: Site, edge: Edge, index: int, along: float, z: float, reach: float) -> bool:
    for hole in holes_of(site.plan.spaces, site.plan.openings, site.index):
        if hole.edge == index and hole.start - 0.15 < along < hole.end + 0.15 and hole.top > z - reach:
            return False
    around = edge.rectangle(along - reach / 2 - 0.05, along + reach / 2 + 0.05, 0.0, reach + 0.1)
    return not any(
        overlap(around, footprint(i)) and i.position[2] < z + reach and i.position[2] + i.size[2] > z - reach
        for i in site.items
    )


def under_cabinets(site: Site) -> None:
    """Strips of light below wall cupboards."""
    rng = site.rng
    cupboards = [i for i in site.items if i.kind in ("wall_cabinet", "hood") and i.position[2] > 1.1]
    if not cupboards or rng.random() > 0.6:
        return
    kelvin = rng.choice([2700.0, 3000.0, 4000.0])
    for item in cupboards:
        length = item.size[0] * 0.85 if item.kind == "wall_cabinet" else 0.15
        c, s = math.cos(item.turn), math.sin(item.turn)
        v = 0.1 * item.size[1] * rng.choice([-1, 1])
        position = (item.position[0] - s * v, item.position[1] + c * v, item.position[2] - 0.014)
        power = 450.0 * length if item.kind == "wall_cabinet" else 200.0
        size = (length, 0.03, 0.01)
        surfaces = (Surface("plastic", (0.8, 0.8, 0.78), roughness=0.4),)
        site.add(
            "under_cabinet", "under_cabinet", position, size, power,
            turn=item.turn, kelvin=kelvin, surfaces=surfaces,
        )  # fmt: skip


def screens(site: Site) -> None:
    """Monitors and televisions that show something."""
    rng = site.rng
    for item in site.items:
        if item.kind not in _SCREEN_CARRIERS or rng.random() > 0.75:
            continue
        spot = _screen_place(item, rng)
        if spot is None:
            continue
        position, width, height = spot
        luminance = math.exp(rng.uniform(*(math.log(v) for v in _SCREEN_LUMINANCE))) * rng.uniform(0.2, 0.8)
        site.add(
            "screen", "screens", position, (width, 0.001, height), math.pi * luminance * width * height,
            turn=item.turn, kelvin=round(rng.uniform(5500, 8000)), surfaces=(), seed=rng.randrange(2**31),
        )  # fmt: skip


def _screen_place(item: Item, rng: random.Random) -> tuple[tuple[float, float, float], float, float] | None:
    """Middle, width and height of an item's display, which looks along its own -y.

    An item tells with the parameter `display` = [x, y, z, width, height] in its own frame (z from its
    underside). Of our own pieces it is known, of others only a television that hangs flat on a wall is.
    """
    display = item.parameters.get("display")
    if display is None:
        display = _own_display(item)
    if display is None:
        return None
    x, y, z, width, height = (float(v) for v in display)
    y -= 0.002
    c, s = math.cos(item.turn), math.sin(item.turn)
    position = (item.position[0] + c * x - s * y, item.position[1] + s * x + c * y, item.position[2] + z)
    return position, width, height


def _own_display(item: Item) -> list[float] | None:
    """The glass of our own flat screens (`pieces.electronics`), whose rim is 8 mm wide."""
    width, depth, height = item.size
    hangs = depth < 0.1
    if item.kind not in ("monitor", "tv", "wall_tv") or (not hangs and not item.piece.startswith("own:")):
        return None
    if not item.piece.startswith("own:"):
        return [0.0, -depth / 2, height / 2, width - 0.05, height - 0.05]
    tall = width * (0.58 if item.kind == "monitor" else 0.575)
    front = (-depth / 2 if hangs else -0.02) + 0.003
    return [0.0, front, height - tall / 2 + 0.003, width - 0.018, tall - 0.024]


def candles(site: Site) -> None:
    """A few candles on tables of homes and halls."""
    rng = site.rng
    if site.space.kind not in ("living", "bedroom", "bathroom", "hall", "kitchen") or rng.random() > 0.15:
        return
    tops = [
        i for i in site.items if i.kind in ("table", "coffee_table", "sideboard", "round_table", "low_shelf")
    ]
    if not tops:
        return
    item = rng.choice(tops)
    top = item.position[2] + item.size[2]
    for _ in range(rng.choice([1, 2, 3])):
        height, radius = rng.uniform(0.06, 0.22), rng.uniform(0.012, 0.03)
        place = _top_place(site, item, radius + 0.02)
        if place is not None:
            site.add(
                "candle", "candles", (*place, top + height + 0.018), (0.01, 0.01, 0.036), 12.0,
                kelvin=2000.0, surfaces=(), height=round(height, 3), radius=round(radius, 3),
            )  # fmt: skip
