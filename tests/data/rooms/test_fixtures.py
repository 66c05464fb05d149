"""Lamps of many seeds: in the room, not in each other, of believable power, switched as people do."""

import dataclasses
import math
import random
from collections import Counter

import pytest

from mixlight.data.rooms.fixture_site import footprint
from mixlight.data.rooms.fixtures import light, place_fixtures
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.make_plan import make_plan, stream
from mixlight.data.rooms.outline import contains, overlap
from mixlight.data.rooms.plan import KINDS, Item, Plan, Sky
from mixlight.data.rooms.plan_json import plain
from mixlight.data.rooms.switches import chance_on, likely_temperature, likely_times
from tests.data.rooms.lit import lit_plan

NIGHT = Sky("night", None, 0.0, 3.0, (1.0, 1.0, 1.0), None)
HANGING = ("panel", "tube", "downlight", "track", "pendant", "flush", "neighbour")


def empty_building(seed: int, kind: str) -> Plan:
    """Walls and openings without furniture, which costs most of a plan's time."""
    building = draw_building(stream(seed, "layout"), kind)
    return Plan(seed, tuple(building.spaces), tuple(building.openings), (), (), NIGHT, ())


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    """Furnished rooms, two of each kind."""
    return [make_plan(seed, kind=kind, cameras=1) for seed, kind in enumerate((*KINDS, *KINDS))]


@pytest.fixture(scope="module")
def bare() -> list[Plan]:
    """Twelve buildings of each kind without furniture, lit."""
    return [light(empty_building(seed, kind), random.Random(seed)) for seed in range(12) for kind in KINDS]


def test_light_is_a_function_of_the_generator() -> None:
    plan = empty_building(3, "living")
    assert light(plan, random.Random(5)) == light(plan, random.Random(5))
    assert light(plan, random.Random(5)) != light(plan, random.Random(6))


def test_every_lamp_is_inside_its_space(plans: list[Plan], bare: list[Plan]) -> None:
    for plan in (*plans, *bare):
        for fixture in plan.fixtures:
            space = plan.spaces[fixture.space]
            x, y, z = fixture.position
            assert contains(space.outline, (x, y)), (plan.seed, fixture)
            assert z - fixture.size[2] / 2 - 1e-6 > 0.0, (plan.seed, fixture)
            assert z + fixture.size[2] / 2 < space.height + 0.03, (plan.seed, fixture)


def test_names_and_groups(plans: list[Plan], bare: list[Plan]) -> None:
    for plan in (*plans, *bare):
        names = [fixture.name for fixture in plan.fixtures]
        assert len(set(names)) == len(names)
        groups = {fixture.group for fixture in plan.fixtures}
        assert len(groups) <= 11
        assert all(name.replace("_", "").isalnum() and name.isascii() for name in groups | set(names))
        assert not groups & {"sky", "sun", "panorama", "depth"}
        for group in groups:
            members = [fixture for fixture in plan.fixtures if fixture.group == group]
            assert len({fixture.on for fixture in members}) == 1


def test_powers_and_temperatures_are_those_of_real_lamps(plans: list[Plan], bare: list[Plan]) -> None:
    limits = {
        "panel": (1200, 5500), "tube": (1000, 6000), "downlight": (250, 1800), "track": (600, 80000),
        "pendant": (300, 6000), "flush": (500, 3000), "sconce": (250, 900), "floor_lamp": (350, 2500),
        "table_lamp": (180, 700), "under_cabinet": (30, 1200), "screen": (1, 1500), "candle": (12, 12),
        "neighbour": (400, 3500),
    }  # fmt: skip
    for plan in (*plans, *bare):
        for fixture in plan.fixtures:
            low, high = limits[fixture.kind]
            assert low <= fixture.power <= high, (plan.seed, fixture)
            assert 2000 <= fixture.temperature <= 8000
            assert min(fixture.size) > 0


def test_hanging_lamps_keep_clear_of_furniture_and_beams(plans: list[Plan]) -> None:
    for plan in plans:
        things = [(footprint(item), item.position[2], item.position[2] + item.size[2]) for item in plan.items]
        for x0, y0, x1, y1, z0, z1 in plan.spaces[0].details.get("columns", ()):
            things.append(((x0, y0, x1, y1), z0, z1))
        for fixture in plan.fixtures:
            if fixture.kind not in HANGING or fixture.space:
                continue
            (x, y, z), (w, d, h) = fixture.position, fixture.size
            if abs(math.sin(fixture.turn)) > 0.5:
                w, d = d, w
            around = (x - w / 2, y - d / 2, x + w / 2, y + d / 2)
            for rectangle, low, high in things:
                apart = low > z + h / 2 - 0.01 or high < z - h / 2 + 0.01
                assert apart or not overlap(around, rectangle), (plan.seed, fixture)


def test_floor_lamps_stand_free(plans: list[Plan]) -> None:
    for plan in plans:
        for fixture in plan.fixtures:
            if fixture.kind != "floor_lamp":
                continue
            x, y, _ = fixture.position
            foot = (x - 0.14, y - 0.14, x + 0.14, y + 0.14)
            for item in plan.items:
                flat = item.position[2] + item.size[2] < 0.06 or item.position[2] > 1.8
                assert flat or not overlap(foot, footprint(item)), (plan.seed, fixture, item)


def test_table_lamps_stand_on_something(plans: list[Plan]) -> None:
    found = 0
    for plan in plans:
        for fixture in plan.fixtures:
            if fixture.kind != "table_lamp":
                continue
            found += 1
            foot = fixture.position[2] - fixture.parameters["height"]
            x, y, _ = fixture.position
            below = [
                item
                for item in plan.items
                if abs(item.position[2] + item.size[2] - foot) < 1e-3
                and overlap((x, y, x, y), footprint(item), 0.01)
            ]
            assert below, (plan.seed, fixture)
    assert found


def test_small_things_make_way_for_lamps() -> None:
    table = Item("nightstand", "own:nightstand", (2.0, 3.0, 0.0), 0.0, (0.4, 0.4, 0.5))
    cup = Item("cup", "own:cup", (2.0, 3.0, 0.5), 0.0, (0.38, 0.38, 0.1), supported_by=0)
    book = Item("book", "own:book", (0.5, 4.5, 0.0), 0.0, (0.2, 0.2, 0.05))
    bench = Item("bench", "own:bench", (3.5, 1.0, 0.0), 0.0, (0.3, 0.3, 0.2))
    vase = Item("vase", "own:vase", (3.5, 1.0, 0.2), 0.0, (0.1, 0.1, 0.2), supported_by=3)
    lit = lit_plan(items=(table, cup, book, bench, vase), fixtures=(), cameras=())
    lit = dataclasses.replace(lit, spaces=(dataclasses.replace(lit.spaces[0], kind="bedroom"),))
    stood = 0
    for seed in range(20):
        made = place_fixtures(lit, random.Random(seed))
        lamps = [f for f in made.fixtures if f.kind == "table_lamp"]
        stood += bool(lamps)
        kinds = [item.kind for item in made.items]
        assert ("cup" in kinds) == (not lamps)
        (kept,) = (item for item in made.items if item.kind == "vase")
        assert made.items[kept.supported_by or 0].kind == "bench"
    assert stood > 10


def test_no_room_stays_dark(bare: list[Plan], plans: list[Plan]) -> None:
    for plan in (*bare, *plans):
        windows = any(o.kind == "window" and o.leads is None and o.space == 0 for o in plan.openings)
        if windows and plan.sky.time == "day":
            continue
        assert any(f.on and f.space == 0 and f.kind not in ("screen", "candle") for f in plan.fixtures), (
            plan.seed
        )


def test_lamps_are_rarer_by_day(bare: list[Plan]) -> None:
    counts: dict[str, Counter[bool]] = {"day": Counter(), "night": Counter()}
    for plan in bare:
        if plan.sky.time != "dusk" and plan.spaces[0].kind in ("living", "bedroom", "kitchen"):
            counts[plan.sky.time].update({f.group: f.on for f in plan.fixtures}.values())
    share = {time: c[True] / c.total() for time, c in counts.items()}
    assert share["day"] < 0.45 < share["night"]


def test_every_kind_of_room_has_its_light(bare: list[Plan]) -> None:
    kinds = {kind: Counter[str]() for kind in KINDS}
    for plan in bare:
        kinds[plan.spaces[0].kind].update({f.kind for f in plan.fixtures if f.space == 0})
    assert kinds["office"]["panel"] >= 3
    assert kinds["workshop"]["tube"] >= 3
    assert kinds["shop"]["track"] >= 2
    assert kinds["bathroom"]["sconce"] >= 3
    for kind in ("living", "bedroom"):
        assert not kinds[kind]["panel"]
        assert not kinds[kind]["tube"]
    assert kinds["living"]["floor_lamp"] >= 3


def test_a_screen_lies_on_the_glass_of_a_monitor() -> None:
    monitor = Item("monitor", "own:monitor", (2.0, 3.0, 0.75), math.pi / 2, (0.6, 0.19, 0.45))
    television = Item("wall_tv", "library:tv", (2.0, 3.0, 1.2), 0.0, (1.2, 0.06, 0.7))
    stand = Item("tv", "library:old", (2.0, 3.0, 1.2), 0.0, (1.2, 0.3, 0.7))
    seen = Counter[str]()
    for seed in range(30):
        plan = lit_plan(items=(monitor, television, stand), fixtures=(), cameras=())
        for fixture in place_fixtures(plan, random.Random(seed)).fixtures:
            if fixture.kind == "screen":
                item = monitor if fixture.turn else television
                seen[item.kind] += 1
                assert fixture.size[0] < item.size[0]
                assert fixture.size[2] < item.size[2]
                if item is monitor:  # it faces +X after a quarter turn to the left
                    assert fixture.position[0] == pytest.approx(2.0 + 0.019, abs=1e-3)
                    assert fixture.position[1] == pytest.approx(3.0)
                else:
                    assert fixture.position[1] == pytest.approx(3.0 - 0.032, abs=1e-3)
    assert set(seen) == {"monitor", "wall_tv"}


def test_a_plan_with_light_is_plain(bare: list[Plan]) -> None:
    for plan in bare[:20]:
        assert plain(plan) == plain(plain(plan))
        assert dataclasses.asdict(plain(plan))["fixtures"] == tuple(
            dataclasses.asdict(f) for f in plain(plan).fixtures
        )


@pytest.mark.parametrize("kind", KINDS)
def test_habits(kind: str) -> None:
    assert sum(likely_times(kind)) == pytest.approx(1.0)
    for fixture in ("panel", "pendant", "floor_lamp", "screen", "neighbour"):
        day, dusk, night = (chance_on(fixture, kind, time) for time in ("day", "dusk", "night"))
        assert 0 < day <= dusk <= night < 1
    assert 2000 <= likely_temperature(kind, random.Random(0)) <= 6500
