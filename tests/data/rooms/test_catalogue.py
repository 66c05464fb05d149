"""The catalogue of the library: what it finds, what it refuses, and the text that names the makers."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from mixlight.data.rooms.attribution import attribution
from mixlight.data.rooms.catalogue import Catalogue, CatalogueError, Entry, library_folder
from mixlight.data.rooms.plan import Item

SOFA = Entry(
    "sofa-1", "sofa", (2.0, 0.9, 0.8), title="Sofa", creator="A. Maker", licence="CC-BY-3.0", source="Set"
)
CUP = Entry("cup-1", "cup", (0.1, 0.1, 0.1), textured=True, title="Cup", licence="CC0-1.0", source="Set")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    (tmp_path / "furniture.blend").write_bytes(b"BLENDER")
    Catalogue(tmp_path / "furniture.blend", (SOFA, CUP), {"package": "test"}).save(tmp_path)
    return tmp_path


def item(piece: str, **changes: object) -> Item:
    given: dict[str, object] = {
        "position": (1.0, 2.0, 0.5),
        "turn": math.pi / 2,
        "size": (4.0, 0.9, 0.8),
    } | changes
    return Item("sofa", piece, **given)  # type: ignore[arg-type]


def test_what_was_saved_is_loaded(library: Path) -> None:
    loaded = Catalogue.load(library)
    assert loaded.entries == (SOFA, CUP)
    assert loaded.blend == library / "furniture.blend"
    assert loaded.origin == {"package": "test"}


def test_objects_are_found_by_kind_and_by_name(library: Path) -> None:
    loaded = Catalogue.load(library)
    assert loaded.of("sofa") == (SOFA,)
    assert loaded.of("bed") == ()
    assert loaded.entry("library:cup-1") == CUP
    assert loaded.used([item("library:cup-1"), item("own:sofa"), item("library:cup-1")]) == (CUP,)
    with pytest.raises(CatalogueError, match="another library"):
        loaded.entry("library:piano")


def test_an_object_goes_where_its_item_stands(library: Path) -> None:
    """Twice as wide as the object, turned a quarter, at (1, 2, 0.5): its right end is at y = 4."""
    matrix = Catalogue.load(library).matrix(item("library:sofa-1"))
    assert matrix @ [1.0, 0.0, 0.0, 1.0] == pytest.approx([1.0, 4.0, 0.5, 1.0])
    assert matrix @ [0.0, -0.45, 0.8, 1.0] == pytest.approx([1.45, 2.0, 1.3, 1.0])
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(2.0)


def test_the_users_library_is_found_or_not(
    library: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert library_folder() == tmp_path / "data" / "mixlight" / "rooms"
    assert Catalogue.find() is None
    library_folder().parent.mkdir(parents=True)
    library_folder().symlink_to(library)
    found = Catalogue.find()
    assert found is not None
    assert found.entries == (SOFA, CUP)
    monkeypatch.setenv("XDG_DATA_HOME", "relative")
    assert library_folder().is_absolute()


def test_a_damaged_library_says_what_to_run(library: Path) -> None:
    path = library / "catalogue.json"
    whole = path.read_text(encoding="utf-8")
    for broken in ("{", "[]", "{}", whole.replace('"kind": "sofa"', '"kind": "spaceship"'), whole[:200]):
        path.write_text(broken, encoding="utf-8")
        with pytest.raises(CatalogueError):
            Catalogue.load(library)
    path.write_text(whole.replace('"version": 1', '"version": 99'), encoding="utf-8")
    with pytest.raises(CatalogueError, match=r"expected version 1, received 99; run `mixlight rooms assets`"):
        Catalogue.load(library)
    path.write_text(whole, encoding="utf-8")
    (library / "furniture.blend").unlink()
    with pytest.raises(CatalogueError, match="missing"):
        Catalogue.load(library)


def test_no_library_says_so(tmp_path: Path) -> None:
    with pytest.raises(CatalogueError, match="received none"):
        Catalogue.load(tmp_path)


def test_two_objects_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CatalogueError, match="two of one name"):
        Catalogue(tmp_path / "x.blend", (SOFA, SOFA))


def test_the_catalogue_is_plain_json(library: Path) -> None:
    document = json.loads((library / "catalogue.json").read_text(encoding="utf-8"))
    assert document["objects"][0]["size"] == [2.0, 0.9, 0.8]


def test_makers_are_named_with_their_licence() -> None:
    text = attribution([SOFA, CUP, SOFA], skies=["hill", "beach", "hill"])
    assert "  Sofa, by A. Maker\n" in text
    assert "Set, CC-BY-3.0 <https://creativecommons.org/licenses/by/3.0/>:" in text
    assert "3D models (2)" in text
    assert text.index("  beach\n") < text.index("  hill\n")
    assert text == attribution([CUP, SOFA], skies=["beach", "hill"])


def test_a_set_of_our_own_pieces_names_nobody() -> None:
    assert "3D models" not in attribution([])
