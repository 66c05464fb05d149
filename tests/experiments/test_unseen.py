"""Networks are scored on places that they have not seen, and on no others."""

from pathlib import Path
from typing import Any

import pytest

from experiments.unseen import FOLDS, halves, unseen, without
from mixlight.data.panoramas import PanoramaRecord, select

RECORDS = [
    PanoramaRecord(f"{category}-{k}", Path("none.hdr"), split, category, f"place-{category}-{k // 2}")
    for category in ("indoor", "studio", "covered", "outdoor")
    for split, numbers in (("train", range(6)), ("val", range(6, 8)), ("test", range(8, 10)))
    for k in numbers
]
PLACES = {record.group for record in select(RECORDS, "train", ("indoor", "studio", "covered"))}


def card(tables: list[str], room_only: bool = False, **more: Any) -> dict[str, Any]:
    categories = {"room": 3} if room_only else {"indoor": 2, "room": 3}
    return {"name": "a", "data": {"tables": tables, "by_category": categories}, **more}


def test_halves_share_no_place_and_hold_all() -> None:
    found = halves(RECORDS)
    assert set(found) == set(FOLDS)
    assert found["A"] | found["B"] == PLACES
    assert not found["A"] & found["B"]
    assert abs(len(found["A"]) - len(found["B"])) <= 1
    assert halves(list(reversed(RECORDS))) == found


@pytest.mark.parametrize("fold", FOLDS)
def test_a_table_lacks_its_half_and_all_of_test(fold: str) -> None:
    kept = without(RECORDS, fold)
    assert {r.group for r in select(kept, "train") if r.category != "outdoor"} == PLACES - halves(RECORDS)[
        fold
    ]
    assert len(select(kept, "train", ["outdoor"])) == 6
    assert select(kept, "val") == select(RECORDS, "val")
    assert not select(kept, "test")


def test_what_a_model_has_not_seen() -> None:
    folds = halves(RECORDS)
    assert unseen(card(["panoramas.csv", "rooms.csv"], room_only=True), folds) == PLACES
    assert unseen(card(["without-A.csv", "rooms.csv"]), folds) == folds["A"]
    of_rooms = card(["panoramas.csv"], room_only=True)
    assert unseen(card(["without-B.csv"], started_from=of_rooms), folds) == folds["B"]
    assert unseen(card(["without-B.csv"], started_from=card(["without-A.csv"])), folds) == set()
    for tables in (["panoramas.csv", "rooms.csv"], ["without-A.csv", "without-B.csv"]):
        with pytest.raises(ValueError, match="expected rooms alone or a table without one half"):
            unseen(card(tables), folds)
