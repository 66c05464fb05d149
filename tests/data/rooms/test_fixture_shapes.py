"""Bodies of lamps: their faces give the power that the plan says, in the right place and direction."""

import math
from typing import Any

import numpy as np
import pytest

from mixlight.data.rooms import shapes
from mixlight.data.rooms.fixture_shapes import fixture_parts, mesh_area, parts
from mixlight.data.rooms.make_plan import make_plan
from mixlight.data.rooms.mesh import Emission, Mesh
from mixlight.data.rooms.plan import Fixture
from mixlight.image.temperature import black_body
from tests.data.rooms.lit import fixture, lit_plan

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

VARIANTS: list[tuple[str, dict[str, Any]]] = [
    ("panel", {"size": (0.6, 0.6, 0.01)}),
    ("tube", {"size": (1.2, 0.13, 0.026), "parameters": {"style": "batten", "drop": 0.4}}),
    ("tube", {"size": (1.2, 0.06, 0.026), "parameters": {"style": "batten"}}),
    ("tube", {"size": (1.5, 0.08, 0.026), "parameters": {"style": "linear", "drop": 0.4}}),
    ("downlight", {"size": (0.1, 0.1, 0.005)}),
    ("track", {"size": (1.5, 0.12, 0.12), "parameters": {"heads": [[-0.5, 0.4, 0.0], [0.5, 0.6, 3.0]]}}),
    *(("pendant", {"parameters": {"shade": s}}) for s in ("drum", "globe", "paper", "bare", "cone", "bowl")),
    ("pendant", {"size": (0.9, 0.9, 0.1), "parameters": {"shade": "chandelier", "arms": 5}}),
    ("flush", {"size": (0.4, 0.4, 0.08), "parameters": {"style": "dome"}}),
    ("flush", {"size": (0.4, 0.4, 0.08)}),
    *(("sconce", {"parameters": {"style": s, "gap": 0.12}}) for s in ("updown", "globe", "drum", "bar")),
    *(("floor_lamp", {"parameters": {"shade": s}}) for s in ("drum", "bowl", "paper", "cone")),
    ("table_lamp", {"parameters": {"shade": "drum", "painted": 1}}),
    ("table_lamp", {"size": (0.18, 0.18, 0.12), "parameters": {"shade": "cone", "desk": True}}),
    ("under_cabinet", {"size": (0.8, 0.03, 0.01)}),
    ("screen", {"size": (0.5, 0.001, 0.3), "parameters": {"seed": 5}}),
    ("candle", {"size": (0.01, 0.01, 0.036), "power": 12.0, "temperature": 2000.0}),
    ("neighbour", {"size": (0.3, 0.3, 0.08)}),
]
IDS = [f"{kind}-{given.get('parameters', {}).get('shade') or n}" for n, (kind, given) in enumerate(VARIANTS)]


def emitters(made: Fixture) -> list[tuple[Mesh, Emission]]:
    return [(p.mesh, p.material) for p in fixture_parts(made) if isinstance(p.material, Emission)]


def lumens(mesh: Mesh, emission: Emission) -> float:
    """Power of a Lambertian face: pi L A on each side that shines, 683 lm in a unit."""
    luminance = float(np.array(emission.radiance) @ LUMINANCE)
    return 683 * math.pi * luminance * mesh_area(mesh) * (2 if emission.two_sided else 1)


@pytest.mark.parametrize(("kind", "given"), VARIANTS, ids=IDS)
def test_the_faces_give_the_power(kind: str, given: dict[str, Any]) -> None:
    made = fixture("a", "g", kind, **given)
    total = sum(lumens(mesh, emission) for mesh, emission in emitters(made))
    assert total == pytest.approx(made.power, rel=1e-6)
    assert {emission.group for _, emission in emitters(made)} == {"g"}
    for _, emission in emitters(made):
        assert min(emission.radiance) > 0
        assert all(0 <= r < 1 for r in emission.reflectance)


@pytest.mark.parametrize(("kind", "given"), VARIANTS, ids=IDS)
def test_light_comes_from_where_the_plan_says(kind: str, given: dict[str, Any]) -> None:
    """The middle of all emitted light lies within the stated size around the stated position."""
    made = fixture("a", "g", kind, **given)
    points, powers = [], []
    for mesh, emission in emitters(made):
        points.append(mesh.vertices[np.unique(mesh.faces[mesh.faces >= 0])].mean(0))
        powers.append(lumens(mesh, emission))
    middle = np.average(points, axis=0, weights=powers)
    assert np.abs(middle - made.position).max() < 0.5 * max(made.size) + 0.02


@pytest.mark.parametrize(("kind", "given"), VARIANTS, ids=IDS)
def test_meshes_are_sane(kind: str, given: dict[str, Any]) -> None:
    made = fixture("a", "g", kind, **given)
    faces = 0
    for part in fixture_parts(made):
        assert np.isfinite(part.mesh.vertices).all()
        assert part.mesh.faces.max() < len(part.mesh.vertices)
        assert mesh_area(part.mesh) > 0
        faces += len(part.mesh.faces)
    assert faces < 8000


def facing(mesh: Mesh) -> np.ndarray:
    """Area-weighted normals of a mesh's faces."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("kind", ["panel", "downlight", "under_cabinet"])
def test_flat_lamps_shine_down(kind: str) -> None:
    for mesh, emission in emitters(fixture("a", "g", kind, size=(0.6, 0.6, 0.01))):
        assert not emission.two_sided
        assert (facing(mesh)[:, 2] < 0).all()


def test_a_bowl_shines_up() -> None:
    made = fixture("a", "g", "floor_lamp", parameters={"shade": "bowl"})
    for mesh, _ in emitters(made):
        assert (facing(mesh)[:, 2] > 0).all()


def test_globes_shine_outward() -> None:
    made = fixture("a", "g", "pendant", parameters={"shade": "globe"})
    for mesh, _ in emitters(made):
        outward = mesh.vertices[mesh.faces[:, :3]].mean(1) - made.position
        assert ((facing(mesh) * outward).sum(1) > 0).all()


def test_a_screen_looks_along_its_turn() -> None:
    made = fixture("a", "g", "screen", size=(0.5, 0.001, 0.3), turn=math.pi / 2)
    for mesh, _ in emitters(made):
        assert (facing(mesh)[:, 0] > 0).all()  # -y turned a quarter to the left is +x


def test_a_lamp_has_the_colour_of_its_temperature() -> None:
    for mesh, emission in emitters(fixture("a", "g", "panel", size=(0.6, 0.6, 0.01), temperature=4000.0)):
        colour = np.array(emission.radiance)
        np.testing.assert_allclose(colour / (colour @ LUMINANCE), black_body(4000.0), rtol=1e-4)
        assert mesh_area(mesh) == pytest.approx(0.36)


def test_a_turned_lamp_turns_about_its_position() -> None:
    straight = fixture_parts(fixture("a", "g", "tube", size=(1.2, 0.1, 0.03)))
    turned = fixture_parts(fixture("a", "g", "tube", size=(1.2, 0.1, 0.03), turn=math.pi / 2))
    for one, other in zip(straight, turned, strict=True):
        x, y, z = (one.mesh.vertices - (1.0, 2.0, 2.2)).T
        np.testing.assert_allclose(other.mesh.vertices, np.stack((1 - y, 2 + x, 2.2 + z), -1), atol=1e-9)


def test_all_lamps_of_a_plan_take_part_whether_on_or_off() -> None:
    plan = lit_plan()
    shining = {p.material.group for p in parts(plan) if isinstance(p.material, Emission)}
    assert shining == {"ceiling", "floor_lamp_1", "table_lamp_1"}


def test_power_holds_for_whole_plans() -> None:
    for seed, kind in enumerate(("living", "shop", "office")):
        plan = make_plan(seed, kind=kind, cameras=1)
        total = sum(lumens(p.mesh, p.material) for p in parts(plan) if isinstance(p.material, Emission))
        assert total == pytest.approx(sum(f.power for f in plan.fixtures), rel=1e-6)


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="torch"):
        fixture_parts(fixture("a", "g", "torch"))


def test_area_counts_triangles_and_quads() -> None:
    assert mesh_area(shapes.box((0, 0, 0), (1, 2, 3))) == pytest.approx(22)
    assert mesh_area(shapes.sphere(1.0, segments=64, rings=32)) == pytest.approx(4 * math.pi, rel=0.01)
