"""A small room with lamps, sky and sun, without a renderer."""

from pathlib import Path

import numpy as np

from mixlight.data.rooms.plan import Camera, Fixture, Opening, Plan, Sky, Space, Surface
from mixlight.data.rooms.plan_json import surface_document
from mixlight.data.rooms.store import group_names, room_document, write_camera, write_document

PAINT = Surface("paint")
WINDOW = {"frame": surface_document(PAINT), "metal": surface_document(PAINT)}


def fixture(name: str, group: str, kind: str = "pendant", **fields: object) -> Fixture:
    given = {
        "space": 0,
        "position": (1.0, 2.0, 2.2),
        "turn": 0.0,
        "power": 800.0,
        "temperature": 2700.0,
        "size": (0.3, 0.3, 0.25),
    } | fields
    return Fixture(name, group, kind, **given)  # type: ignore[arg-type]


def lit_plan(**fields: object) -> Plan:
    """Two lamps on, one off, a sunny window."""
    given = {
        "seed": 7,
        "spaces": (Space("living", ((0, 0), (4, 0), (4, 5), (0, 5)), 2.6, (PAINT,) * 4, PAINT, PAINT),),
        "openings": (Opening("window", 0, 2, 1.0, 3.0, 0.9, 2.2, details=WINDOW),),
        "items": (),
        "fixtures": (
            fixture("pendant_0", "ceiling"),
            fixture("floor_lamp_0", "floor_lamp_1", "floor_lamp", position=(3.5, 4.5, 1.4)),
            fixture("table_lamp_0", "table_lamp_1", "table_lamp", position=(0.4, 0.4, 0.9), on=False),
        ),
        "sky": Sky("day", None, 0.0, 9000.0, (0.7, 0.9, 1.5), (0.0, 0.8, 0.6), 60000.0),
        "cameras": (Camera(0, (2.0, 2.0, 1.5), 0.0), Camera(0, (1.0, 1.0, 1.4), 1.0)),
    } | fields
    return Plan(**given)  # type: ignore[arg-type]


def pictures(plan: Plan, height: int = 32, seed: int = 0) -> dict[str, np.ndarray]:
    """Random light of every group: a wide range, one bright spot each."""
    generator = np.random.default_rng(seed)
    found = {}
    for name in group_names(plan):
        pixels = np.exp(generator.normal(-2, 1.5, (height, 2 * height, 3)))
        pixels[generator.integers(height), generator.integers(2 * height)] *= 200
        found[name] = pixels.astype(np.float32)
    return found


def write_room(folder: Path, plan: Plan, *, codec: str = "zip", height: int = 32) -> list[Path]:
    """A room as the renderer leaves it; returns its camera files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"camera-{k}.exr" for k in range(len(plan.cameras))]
    on = {f.group: f.on for f in plan.fixtures}
    depth = np.full((height, 2 * height), 2.5, np.float32)
    depth[0] = np.inf
    for k, path in enumerate(files):
        light = pictures(plan, height, k)
        write_camera(path, light, depth, document="room.json", camera=k, on=on, codec=codec)
    write_document(folder / "room.json", room_document(plan, [path.name for path in files]))
    return files
