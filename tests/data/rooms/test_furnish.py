"""Furnished rooms: nothing enters anything else, ways and windows stay free, and rooms are full of things."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from mixlight.data.rooms.catalogue import KINDS, Catalogue, Entry
from mixlight.data.rooms.furnish import furnish
from mixlight.data.rooms.furnish.ground import Block, block_of, overlaps
from mixlight.data.rooms.furnish.tops import tops_of
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.make_plan import stream
from mixlight.data.rooms.outline import contains, door_sweep, edges, holes
from mixlight.data.rooms.pieces import PIECES
from mixlight.data.rooms.plan import KINDS as SPACES
from mixlight.data.rooms.plan import Item, Plan, Sky

SKY = Sky("day", None, 0.0, 10_000.0, (0.75, 0.87, 1.0), None)
SEEDS = range(10)

LIBRARY = Catalogue(
    Path("furniture.blend"),
    (
        Entry("a-sofa", "sofa", (1.9, 0.85, 0.8)),
        Entry("b-sofa", "sofa", (2.3, 0.9, 0.8)),
        Entry("c-desk", "desk", (1.4, 0.6, 1.05), top=0.74),
        Entry("d-desk", "desk", (1.2, 0.6, 0.74)),
        Entry("e-cup", "cup", (0.1, 0.1, 0.1), textured=True),
        Entry("f-tv", "wall_tv", (1.0, 0.1, 0.6), elevation=1.0),
        Entry("g-cat", "pet", (0.2, 0.35, 0.45)),
    ),
)


def empty_plan(seed: int, kind: str | None = None) -> Plan:
    building = draw_building(stream(seed, "layout"), kind)
    return Plan(seed, tuple(building.spaces), tuple(building.openings), (), (), SKY, ())


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    kinds = list(SPACES)
    return [
        furnish(empty_plan(seed, kinds[seed % len(kinds)]), Random(seed), LIBRARY if seed % 2 == 0 else None)
        for seed in SEEDS
    ]


def solids(plan: Plan) -> list[tuple[int, Block]]:
    """What stands or hangs by itself and is more than a carpet."""
    return [
        (i, block_of(item))
        for i, item in enumerate(plan.items)
        if item.supported_by is None and item.size[2] > 0.022
    ]


def test_nothing_enters_anything_else(plans: list[Plan]) -> None:
    """Chairs alone may stand with their fronts under a table or a desk."""
    seats = {"chair", "office_chair", "bar_stool", "stool"}
    under = {"table", "round_table", "desk", "island", "bar_table", "workbench"}
    for plan in plans:
        found = solids(plan)
        for n, (i, a) in enumerate(found):
            for j, b in found[n + 1 :]:
                kinds = {plan.items[i].kind, plan.items[j].kind}
                if kinds & seats and kinds & under:
                    continue
                assert not overlaps(a, b), (plan.seed, plan.items[i], plan.items[j])


def test_things_are_inside_a_room_and_under_its_ceiling(plans: list[Plan]) -> None:
    for plan in plans:
        for item in plan.items:
            x, y, z = item.position
            homes = [space for space in plan.spaces if contains(space.outline, (x, y))]
            assert homes, item
            assert z + item.size[2] <= homes[0].height + 1e-6, item
            if item.supported_by is None and item.size[2] > 0.022:
                for corner in block_of(item).corners:
                    inner = [c + (m - c) * 2e-3 for c, m in zip(corner, (x, y), strict=True)]
                    assert contains(homes[0].outline, (inner[0], inner[1])), (plan.seed, item)


def test_what_lies_on_something_lies_on_it(plans: list[Plan]) -> None:
    for plan in plans:
        for i, item in enumerate(plan.items):
            if item.supported_by is None:
                continue
            assert item.supported_by < i
            base = plan.items[item.supported_by]
            heights = [base.position[2] + top.height for top in tops_of(base)]
            assert min(abs(item.position[2] - height) for height in heights) < 1e-3, (item, base)
            dx, dy = item.position[0] - base.position[0], item.position[1] - base.position[1]
            c, s = math.cos(base.turn), math.sin(base.turn)
            assert abs(c * dx + s * dy) <= base.size[0] / 2 + 1e-3
            assert abs(-s * dx + c * dy) <= base.size[1] / 2 + 1e-3


def test_small_things_do_not_enter_each_other(plans: list[Plan]) -> None:
    for plan in plans:
        by_base: dict[int, list[Item]] = {}
        for item in plan.items:
            if item.supported_by is not None:
                by_base.setdefault(item.supported_by, []).append(item)
        for items in by_base.values():
            for n, a in enumerate(items):
                for b in items[n + 1 :]:
                    assert not overlaps(block_of(a), block_of(b)), (plan.seed, a, b)


def test_doors_open_and_people_can_pass(plans: list[Plan]) -> None:
    for plan in plans:
        for space in range(len(plan.spaces)):
            for hole in holes(plan, space):
                sweep = door_sweep(plan, hole)
                if sweep is None:
                    continue
                way = Block.over(sweep, 0.03, 1.9)
                for i, block in solids(plan):
                    if plan.items[i].kind in ("office_chair", "chair") or plan.items[i].position[2] > 0.3:
                        continue  # a chair is pushed aside; what hangs beside a door is thin
                    assert not overlaps(way, block), (plan.seed, plan.items[i], hole)


def test_windows_are_not_blocked(plans: list[Plan]) -> None:
    checked = 0
    for plan in plans:
        for space in range(len(plan.spaces)):
            walls = edges(plan.spaces[space].outline)
            for hole in holes(plan, space):
                if hole.opening.kind != "window":
                    continue
                pane = walls[hole.edge].rectangle(hole.start, hole.end, 0.0, 0.09)
                glass = Block.over(pane, max(hole.bottom, 0.03), hole.top)
                for _, block in solids(plan):
                    checked += 1
                    assert not overlaps(glass, block), (plan.seed, hole, block)
    assert checked > 100


def test_the_same_state_gives_the_same_furniture() -> None:
    plan = empty_plan(4, "living")
    assert furnish(plan, Random(9)) == furnish(plan, Random(9))
    assert furnish(plan, Random(9)) != furnish(plan, Random(10))


def test_without_a_library_everything_is_ours() -> None:
    plan = furnish(empty_plan(2, "living"), Random(2))
    assert all(item.piece.removeprefix("own:") in PIECES for item in plan.items)


def test_the_library_takes_part() -> None:
    pieces = Counter(
        item.piece
        for seed in range(6)
        for item in furnish(empty_plan(seed, "living"), Random(seed), LIBRARY).items
    )
    used = [piece for piece in pieces if piece.startswith("library:")]
    assert "library:a-sofa" in used
    assert {"library:b-sofa", "library:d-desk"} & set(used)
    assert any(piece == "own:sofa" for piece in pieces)


def test_things_stand_where_the_library_says() -> None:
    """On a desk with a rack, they stand on the board and not on the rack."""
    desk = Item(
        "desk",
        "library:c-desk",
        (0, 0, 0),
        0.0,
        (1.4, 0.6, 1.05),
        parameters={"tops": [[-0.7, -0.3, 0.7, 0.3, 0.74, 1.0]]},
    )
    assert [top.height for top in tops_of(desk)] == [0.74]


@pytest.mark.parametrize(
    ("kind", "least", "needs"),
    [
        ("living", 45, {"sofa", "armchair"}),
        ("bedroom", 25, {"bed", "child_bed"}),
        ("office", 30, {"desk"}),
        ("kitchen", 25, {"kitchen"}),
        ("bathroom", 12, {"toilet", "bath", "shower", "basin", "vanity"}),
        ("hall", 50, {"table", "sofa", "shelf", "chair", "armchair", "display_table", "bench"}),
        ("corridor", 12, {"shoes", "shoe_rack", "bench", "plant", "box", "hooks", "chair", "console"}),
        ("shop", 60, {"counter", "shop_rack", "shelf", "clothes_rack"}),
        ("workshop", 30, {"workbench"}),
    ],
)  # fmt: skip
def test_rooms_of_a_kind_hold_what_makes_them_one(kind: str, least: int, needs: set[str]) -> None:
    """The median room is as full as lived-in rooms are, and most have what their kind is for."""
    counts, fitting = [], 0
    for seed in range(3):
        plan = empty_plan(seed, kind)
        alone = replace(
            plan,
            spaces=plan.spaces[:1],
            openings=tuple(o for o in plan.openings if o.space == 0 and o.leads is None),
        )
        items = furnish(alone, Random(seed)).items
        counts.append(len(items))
        fitting += bool({item.kind for item in items} & needs)
    assert sorted(counts)[1] >= least, counts
    assert fitting >= 2


def test_a_tidy_and_a_messy_room_differ() -> None:
    """The number of small things varies from room to room."""
    plan = empty_plan(3, "living")
    counts = [
        sum(item.supported_by is not None for item in furnish(plan, Random(seed)).items) for seed in range(6)
    ]
    assert max(counts) > 1.3 * min(counts), counts


def test_every_kind_that_is_used_is_known(plans: list[Plan]) -> None:
    assert {item.kind for plan in plans for item in plan.items} <= KINDS.keys()
