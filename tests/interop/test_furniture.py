"""Models become a library in Blender itself."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mixlight.blender.program import run
from mixlight.data.rooms.assets import install
from tests.data.rooms.test_assets import collection, debian
from tests.interop.blenders import VERSIONS, blender_python

pytestmark = pytest.mark.interop

PROBE = """
import json, sys
import bpy
arguments = sys.argv[sys.argv.index("--") + 1 :]
with bpy.data.libraries.load(arguments[0]) as (there, here):
    here.objects = list(there.objects)
found = {}
for made in here.objects:
    corners = [list(vertex.co) for vertex in made.data.vertices]
    images = [
        node.image.name
        for slot in made.material_slots
        for node in slot.material.node_tree.nodes
        if node.type == "TEX_IMAGE"
    ]
    low, high = (list(f(c) for c in zip(*corners)) for f in (min, max))
    found[made.name] = {"low": low, "high": high, "images": images}
with open(arguments[1], "w") as file:
    json.dump(found, file)
"""

CUBE_WITH_PICTURE = "mtllib bed1.mtl\n" + "".join(
    f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)
) + "vt 0 0\nusemtl a\nf 1/1 2/1 4/1 3/1\nf 5/1 7/1 8/1 6/1\nf 1/1 5/1 6/1 2/1\n"  # fmt: skip
MATERIAL = "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd missing.png\n"


@pytest.mark.parametrize("version", VERSIONS)
def test_models_stand_on_their_origin_in_metres(version: str, tmp_path: Path) -> None:
    """A bed with a picture that is missing (it goes) and a screen that is turned."""
    blender = blender_python(version)
    package = tmp_path / "sweethome3d-furniture_1.8-1_all.deb"
    extra = {"scopia/bed1/bed1.obj": CUBE_WITH_PICTURE, "scopia/bed1/bed1.mtl": MATERIAL}
    package.write_bytes(debian(collection(extra)))
    made = install(package, tmp_path / "rooms", blender=blender, timeout=600)
    assert {entry.name for entry in made.entries} == {"scopia-bed1", "scopia-wall-flat-tv"}
    assert not any(entry.textured for entry in made.entries)
    script, answer = tmp_path / "probe.py", tmp_path / "found.json"
    script.write_text(PROBE)
    run(script, [made.blend, answer], timeout=600, blender=blender)
    found = json.loads(answer.read_text())
    for entry in made.entries:
        width, depth, height = entry.size
        assert found[entry.name]["low"] == pytest.approx([-width / 2, -depth / 2, 0.0], abs=1e-4)
        assert found[entry.name]["high"] == pytest.approx([width / 2, depth / 2, height], abs=1e-4)
        assert found[entry.name]["images"] == []
