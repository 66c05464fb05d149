"""Where lamps may go: free ceiling, walls, floor and table tops of one space, and the style they share."""

from __future__ import annotations

import math
import random
from typing import Any

from mixlight.data.rooms.outline import (
    Edge,
    Rectangle,
    area,
    bounds,
    contains_rectangle,
    door_sweep,
    edges,
    holes,
    overlap,
)
from mixlight.data.rooms.plan import Fixture, Item, Plan, Point2, Point3, Surface
from mixlight.data.rooms.switches import likely_temperature

__all__ = ["Site", "footprint"]

_METALS = (
    Surface("metal", (0.03, 0.03, 0.03), roughness=0.5),
    Surface("metal", (0.75, 0.75, 0.75), roughness=0.35, metallic=1.0),
    Surface("metal", (0.72, 0.52, 0.25), roughness=0.3, metallic=1.0),
    Surface("plastic", (0.8, 0.8, 0.78), roughness=0.4),
    Surface("metal", (0.35, 0.33, 0.31), roughness=0.45, metallic=1.0),
)
_SHADES = (
    (0.75, 0.72, 0.65),
    (0.78, 0.77, 0.74),
    (0.6, 0.55, 0.45),
    (0.45, 0.42, 0.38),
    (0.25, 0.3, 0.33),
    (0.5, 0.25, 0.15),
)


def footprint(item: Item) -> Rectangle:
    """The smallest axis-aligned rectangle around a turned item."""
    c, s = abs(math.cos(item.turn)), abs(math.sin(item.turn))
    x = (item.size[0] * c + item.size[1] * s) / 2
    y = (item.size[0] * s + item.size[1] * c) / 2
    return item.position[0] - x, item.position[1] - y, item.position[0] + x, item.position[1] + y


class Site:
    """One space of a plan while lamps are put into it."""

    fixtures: list[Fixture]
    """Of all spaces, in the order they were made."""

    def __init__(self, plan: Plan, rng: random.Random, space: int = 0, other: Site | None = None) -> None:
        """A further space of the plan goes on with the fixtures of another."""
        self.plan, self.rng, self.index = plan, rng, space
        self.space = plan.spaces[space]
        self.height = self.space.height
        self.area = area(self.space.outline)
        self.bounds = bounds(self.space.outline)
        self.edges: tuple[Edge, ...] = edges(self.space.outline)
        self.temperature = likely_temperature(self.space.kind, rng)
        self.metal = rng.choice(_METALS)
        self.fixtures = [] if other is None else other.fixtures
        self.items = [
            item
            for item in plan.items
            if contains_rectangle(
                self.space.outline,
                (
                    item.position[0] - 0.01,
                    item.position[1] - 0.01,
                    item.position[0] + 0.01,
                    item.position[1] + 0.01,
                ),
            )
        ]
        self.gone: set[int] = set()
        """Places in the plan's items of small things that made way for a lamp."""
        self.sweeps = [s for h in holes(plan, space) if (s := door_sweep(plan, h)) is not None]
        overhead = ("beams", "obstacles")  # the latter: ducts, soffits and what stands in the way
        self.beams: list[Any] = [box for name in overhead for box in self.space.details.get(name, ())]
        self.columns: list[Any] = list(self.space.details.get("columns", ()))

    def shade(self) -> Surface:
        """Cloth or paint of a shade."""
        colour = self.rng.choice(_SHADES)
        return Surface("fabric", colour, roughness=0.9)

    def kelvin(self) -> float:
        """The room's colour temperature, as one bulb of it has it."""
        return round(min(max(self.temperature * self.rng.gauss(1.0, 0.03), 2000.0), 7000.0))

    def add(
        self,
        kind: str,
        group: str,
        position: Point3,
        size: Point3,
        power: float,
        *,
        turn: float = 0.0,
        kelvin: float | None = None,
        surfaces: tuple[Surface, ...] | None = None,
        **parameters: Any,
    ) -> None:
        """Puts a fixture into the plan, under a name of its own."""
        name = f"{kind}_{sum(f.kind == kind for f in self.fixtures)}"
        self.fixtures.append(
            Fixture(
                name,
                group,
                kind,
                self.index,
                (round(position[0], 4), round(position[1], 4), round(position[2], 4)),
                round(turn, 5),
                round(power, 1),
                kelvin if kelvin is not None else self.kelvin(),
                (round(size[0], 4), round(size[1], 4), round(size[2], 4)),
                True,
                surfaces if surfaces is not None else (self.metal, self.shade()),
                parameters,
            )
        )

    def clear(self, carrier: Item, around: Rectangle, height: float) -> bool:
        """Takes the small things off a piece of an item's top; False, and nothing taken, if larger ones stand
        or hang there.
        """
        top = carrier.position[2] + carrier.size[2]
        carriers = {item.supported_by for item in self.plan.items}
        taken = []
        for index, item in enumerate(self.plan.items):
            low, high = item.position[2], item.position[2] + item.size[2]
            if item is carrier or index in self.gone or high < top + 0.002 or low > top + height:
                continue
            if overlap(around, footprint(item)):
                owner = None if item.supported_by is None else self.plan.items[item.supported_by]
                if owner is not carrier or index in carriers or max(item.size) > 0.5:
                    return False
                taken.append(index)
        self.gone.update(taken)
        return True

    def under_ceiling(self, rectangle: Rectangle, drop: float) -> bool:
        """Whether something may hang down `drop` metres there: inside, no beam or furniture in its way."""
        if not contains_rectangle(self.space.outline, rectangle, 0.05):
            return False
        low = self.height - drop
        for x0, y0, x1, y1, z0, _ in self.beams:
            if z0 < self.height - 0.01 and overlap(rectangle, (x0, y0, x1, y1), 0.03):
                return False
        for x0, y0, x1, y1, *_ in self.columns:
            if overlap(rectangle, (x0, y0, x1, y1), 0.05):
                return False
        return all(
            item.position[2] + item.size[2] < low - 0.05 or not overlap(rectangle, footprint(item), 0.02)
            for item in self.items
        )

    def floor_free(self, centre: Point2, radius: float) -> bool:
        """Whether a round foot and its shade have a place on the floor."""
        x, y = centre
        rectangle = (x - radius, y - radius, x + radius, y + radius)
        if not contains_rectangle(self.space.outline, rectangle, 0.02):
            return False
        if any(overlap(rectangle, sweep) for sweep in self.sweeps):
            return False
        if any(overlap(rectangle, (c[0], c[1], c[2], c[3])) for c in self.columns):
            return False
        for item in self.items:
            flat = item.position[2] + item.size[2] < 0.06
            high = item.position[2] > 1.8
            if not flat and not high and overlap(rectangle, footprint(item), 0.02):
                return False
        for camera in self.plan.cameras:
            if math.hypot(camera.position[0] - x, camera.position[1] - y) < radius + 0.35:
                return False
        return all(
            f.kind != "floor_lamp" or math.hypot(f.position[0] - x, f.position[1] - y) > 2 * radius + 0.2
            for f in self.fixtures
        )
