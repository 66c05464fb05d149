"""Runs inside Blender: one material for each kind of surface, and for what shines."""

import random
from types import SimpleNamespace

import bpy
import patterns
from nodes import Tree


def material(given, name):
    """The material of a surface or an emission, as the scene's JSON describes it."""
    made = bpy.data.materials.new(name)
    tree = Tree(made)
    if "radiance" in given:
        tree.surface(emission(tree, made, given))
    else:
        s = SimpleNamespace(**given)
        s.colour = tuple(s.colour)
        s.second = tuple(s.second) if s.second else None
        tree.surface(SHADERS.get(s.kind, opaque)(tree, s))
    return made


def emission(tree, made, given):
    """What shines, over the diffuse face that shows when it is off; one-sided things are white behind."""
    strength = max(given["radiance"])
    colour = [channel / strength for channel in given["radiance"]] if strength > 0 else (1.0, 1.0, 1.0)
    shines = tree.add("ShaderNodeEmission", Color=colour, Strength=strength).outputs[0]
    made.cycles.emission_sampling = "FRONT_BACK" if given["two_sided"] else "FRONT"
    if max(given["reflectance"]) > 0:
        face = tree.add("ShaderNodeBsdfDiffuse", Color=given["reflectance"]).outputs[0]
        both = tree.add("ShaderNodeAddShader")
        tree.set(both.inputs[0], shines)
        tree.set(both.inputs[1], face)
        shines = both.outputs[0]
    if given["two_sided"]:
        return shines
    behind = tree.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    return mixed(tree, behind, shines, tree.add("ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7)).outputs[0])


def place(tree, s):
    """Coordinates in metres, turned, scaled and moved as the surface says."""
    uv = tree.add("ShaderNodeTexCoord").outputs["UV"]
    if s.kind == "picture":
        return uv
    choice = random.Random(s.seed)
    where = (choice.uniform(-20.0, 20.0), choice.uniform(-20.0, 20.0), choice.uniform(-20.0, 20.0))
    scale = 1.0 / s.scale
    return tree.add(
        "ShaderNodeMapping", Vector=uv, Location=where, Rotation=(0.0, 0.0, s.turn), Scale=(scale, scale, 1.0)
    ).outputs[0]


def pattern(tree, s):
    """Colour, normal and roughness of the surface's kind."""
    make = patterns.KINDS.get(s.kind)
    if make is None:
        raise patterns.unknown(s.kind)
    colour, height, roughness = make(tree, s, place(tree, s))
    normal = None
    if height is not None and s.bump > 0:
        normal = tree.add("ShaderNodeBump", Strength=s.bump, Distance=1.0, Height=height).outputs[0]
    return colour, normal, roughness


def opaque(tree, s):
    """Most things."""
    colour, normal, roughness = pattern(tree, s)
    inputs = {"Base_Color": colour, "Roughness": roughness, "Metallic": s.metallic}
    if normal is not None:
        inputs["Normal"] = normal
    if s.kind == "metal":
        inputs["Metallic"] = s.metallic or 1.0
    if s.kind in ("carpet", "fabric"):
        inputs["Specular_IOR_Level"] = 0.1
    elif s.kind in ("brick", "concrete", "plaster", "outdoors", "paper"):
        inputs["Specular_IOR_Level"] = 0.25
    return tree.add("ShaderNodeBsdfPrincipled", **inputs).outputs[0]


def translucent(tree, s):
    """Curtains and shades: the transmitted share of the light is scattered, except for what passes between
    the threads, (1 - roughness)^2 of it, straight.
    """
    straight = s.transmission * (1.0 - s.roughness) ** 2
    scattered = s.transmission - straight
    through = scattered / (1.0 - straight) if straight < 1.0 else 0.0
    cloth = mixed(
        tree,
        through,
        tree.add("ShaderNodeBsdfDiffuse", Color=s.colour).outputs[0],
        tree.add("ShaderNodeBsdfTranslucent", Color=s.colour).outputs[0],
    )
    return cloth if straight <= 0 else mixed(tree, straight, cloth, clear(tree, (1.0, 1.0, 1.0)))


def leaf(tree, s):
    """A third of what a leaf does not absorb comes out at its other side."""
    colour, _, roughness = pattern(tree, s)
    gloss = tree.add("ShaderNodeBsdfPrincipled", Base_Color=colour, Roughness=roughness).outputs[0]
    return mixed(tree, 0.35, gloss, tree.add("ShaderNodeBsdfTranslucent", Color=colour).outputs[0])


def glass(tree, s):
    """A thin pane: light passes straight (so that windows can be sampled), and a little is mirrored.

    Both faces of a pane mirror: 2r / (1 + r) of the light, where r is Fresnel's share for one.
    """
    one = tree.add("ShaderNodeFresnel", IOR=1.45).outputs[0]
    both = tree.math("DIVIDE", tree.math("MULTIPLY", one, 2.0), tree.math("ADD", one, 1.0))
    mirrored = tree.add(
        "ShaderNodeBsdfGlossy", Color=(1.0, 1.0, 1.0), Roughness=min(s.roughness, 0.02)
    ).outputs[0]
    through = clear(tree, s.colour)
    if s.roughness > 0.3:  # frosted
        through = mixed(tree, 0.8, through, tree.add("ShaderNodeBsdfTranslucent", Color=s.colour).outputs[0])
    return mixed(tree, both, through, mirrored)


def mirror(tree, s):
    """Silvered glass."""
    return tree.add("ShaderNodeBsdfGlossy", Color=s.colour, Roughness=min(s.roughness, 0.02)).outputs[0]


def clear(tree, colour):
    """Light goes straight on."""
    return tree.add("ShaderNodeBsdfTransparent", Color=colour).outputs[0]


def mixed(tree, share, first, second):
    """Two shaders; `share` is the second's."""
    node = tree.add("ShaderNodeMixShader")
    for socket, value in zip(node.inputs, (share, first, second), strict=True):
        tree.set(socket, value)
    return node.outputs[0]


SHADERS = {"translucent": translucent, "glass": glass, "mirror": mirror, "plant": leaf}
"""Kinds that are more than a pattern on something opaque."""
