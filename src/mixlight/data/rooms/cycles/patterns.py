"""Runs inside Blender: colour, relief and roughness of every kind of surface, from coordinates in metres.

Each function returns (colour, height in metres or None, roughness): sockets or plain values.
"""

import random


def dimmed(colour, share):
    """A darker colour."""
    return tuple(channel * share for channel in colour)


def paint(tree, s, place):
    """Roller paint: hardly uneven, a trace of texture."""
    cloud = tree.spread(tree.noise(place, 1.3, 3.0), 0.3, 0.7)
    colour = tree.mix(cloud, dimmed(s.colour, 0.94), s.colour)
    return colour, tree.math("MULTIPLY", tree.noise(place, 180.0, 1.0), 0.0004), s.roughness


def plaster(tree, s, place):
    """Trowelled: clouds and a coarse relief."""
    cloud = tree.spread(tree.noise(place, 2.5, 5.0, 0.6), 0.3, 0.7)
    colour = tree.mix(cloud, s.second or dimmed(s.colour, 0.86), s.colour)
    return colour, tree.math("MULTIPLY", tree.noise(place, 22.0, 4.0), 0.004), max(s.roughness, 0.7)


def wallpaper(tree, s, place):
    """Stripes, checks or a motif, by the seed."""
    choice = random.Random(s.seed)
    second = s.second or dimmed(s.colour, 0.84)
    kind = choice.choice(["stripes", "stripes", "motif", "texture"])
    if kind == "stripes":
        wave = tree.add("ShaderNodeTexWave", Vector=place, Scale=choice.uniform(1.0, 4.0), Distortion=0.0)
        share = tree.spread(wave.outputs[1], 0.48, 0.52)
    elif kind == "motif":
        cells = tree.add("ShaderNodeTexVoronoi", Vector=place, Scale=choice.uniform(4.0, 9.0), Randomness=0.0)
        share = tree.spread(cells.outputs["Distance"], 0.28, 0.3)
    else:
        share = tree.spread(tree.noise(tree.stretched(place, 120.0, 6.0), 1.0, 2.0), 0.35, 0.65)
    return tree.mix(share, s.colour, second), None, s.roughness


def grain(tree, place, fineness=1.0):
    """Wood grain along u, 0 to 1."""
    long = tree.stretched(place, 0.6 * fineness, 14.0 * fineness)
    wide = tree.noise(long, 1.6, 3.0, 0.8)
    fine = tree.noise(tree.stretched(place, 4.0, 160.0), 1.0, 2.0)
    return tree.spread(
        tree.math("ADD", tree.math("MULTIPLY", wide, 0.7), tree.math("MULTIPLY", fine, 0.3)), 0.3, 0.7
    )


def wood(tree, s, place):
    """One piece, grain along u."""
    share = grain(tree, place)
    colour = tree.mix(share, s.second or dimmed(s.colour, 0.62), s.colour)
    rough = tree.spread(share, 0.0, 1.0, min(s.roughness + 0.12, 1.0), s.roughness)
    return colour, tree.math("MULTIPLY", share, 0.0004), rough


def bricks(tree, place, width, height, gap, offset=0.5, every=2, smooth=0.1):
    """Courses of bricks: (tint of each one, 0 to 1; share of gap)."""
    node = tree.add(
        "ShaderNodeTexBrick",
        {"offset": offset, "offset_frequency": every},
        Vector=place, Color1=(0.0, 0.0, 0.0), Color2=(1.0, 1.0, 1.0), Mortar=(0.5, 0.5, 0.5), Scale=1.0,
        Mortar_Size=gap, Mortar_Smooth=smooth, Bias=0.0, Brick_Width=width, Row_Height=height,
    )  # fmt: skip
    return node.outputs["Color"], node.outputs["Fac"]


def planks(tree, s, place):
    """Boards .12 m wide and 1.4 m long, each its own tint and piece of grain."""
    tint, gap = bricks(tree, place, 1.4, 0.12, 0.002, 0.37, 2)
    moved = tree.add("ShaderNodeVectorMath", {"operation": "MULTIPLY_ADD"})
    tree.set(moved.inputs[0], tint)
    tree.set(moved.inputs[1], (7.3, 3.1, 0.0))
    tree.set(moved.inputs[2], place)
    share = grain(tree, moved.outputs[0])
    colour = tree.mix(share, s.second or dimmed(s.colour, 0.7), s.colour)
    colour = tree.mix(tree.math("MULTIPLY", tint, 0.55), colour, dimmed(s.colour, 0.45))
    colour = tree.mix(gap, colour, dimmed(s.colour, 0.12))
    worn = tree.spread(
        tree.noise(place, 1.7, 3.0), 0.3, 0.7, max(s.roughness - 0.08, 0.05), min(s.roughness + 0.12, 1.0)
    )
    return colour, tree.math("MULTIPLY", gap, -0.0012), worn


def carpet(tree, s, place):
    """Pile: dark between the tufts, trodden in places."""
    tufts = tree.noise(place, 260.0, 1.0)
    trodden = tree.spread(tree.noise(place, 2.0, 2.0), 0.3, 0.7, 0.0, 0.25)
    colour = tree.mix(tree.spread(tufts, 0.3, 0.7), s.second or dimmed(s.colour, 0.6), s.colour)
    colour = tree.mix(trodden, colour, dimmed(s.colour, 0.75))
    return colour, tree.math("MULTIPLY", tufts, 0.004), 1.0


def tile(tree, s, place):
    """Square tiles of .3 m with grout."""
    tint, gap = bricks(tree, place, 0.3, 0.3, 0.0022, 0.0)
    mottled = tree.spread(tree.noise(place, 6.0, 3.0), 0.3, 0.7, 0.0, 0.35)
    colour = tree.mix(mottled, s.colour, dimmed(s.colour, 0.9))
    colour = tree.mix(tree.math("MULTIPLY", tint, 0.12), colour, dimmed(s.colour, 0.7))
    colour = tree.mix(gap, colour, s.second or dimmed(s.colour, 0.55))
    rough = tree.spread(gap, 0.0, 1.0, s.roughness, 0.9)
    return colour, tree.math("MULTIPLY", gap, -0.0015), rough


def stone(tree, s, place):
    """Marble and granite: veins in clouds."""
    second = s.second or dimmed(s.colour, 0.55)
    veins = tree.math("ABSOLUTE", tree.math("SUBTRACT", tree.noise(place, 2.2, 5.0, 1.4), 0.5))
    clouds = tree.spread(tree.noise(place, 4.0, 4.0), 0.3, 0.75, 0.0, 0.35)
    colour = tree.mix(clouds, s.colour, second)
    colour = tree.mix(tree.spread(veins, 0.0, 0.035, 0.35, 0.0), colour, dimmed(second, 0.7))
    return colour, None, s.roughness


def brick(tree, s, place):
    """Bricks of .22 by .07 m with mortar."""
    tint, gap = bricks(tree, place, 0.22, 0.07, 0.006, 0.5, 2, 0.3)
    rough = tree.noise(place, 60.0, 3.0)
    colour = tree.mix(tint, s.colour, dimmed(s.colour, 0.6))
    colour = tree.mix(tree.spread(rough, 0.3, 0.7, 0.0, 0.3), colour, dimmed(s.colour, 0.45))
    colour = tree.mix(gap, colour, s.second or (0.42, 0.4, 0.37))
    height = tree.math("SUBTRACT", tree.math("MULTIPLY", rough, 0.002), tree.math("MULTIPLY", gap, 0.006))
    return colour, height, max(s.roughness, 0.8)


def concrete(tree, s, place):
    """Stains of every size."""
    stains = tree.spread(tree.noise(place, 1.1, 8.0, 0.4), 0.25, 0.75)
    pores = tree.noise(place, 90.0, 2.0)
    colour = tree.mix(stains, s.second or dimmed(s.colour, 0.72), s.colour)
    return (
        colour,
        tree.math("MULTIPLY", pores, 0.001),
        tree.spread(stains, 0.0, 1.0, s.roughness, max(s.roughness - 0.15, 0.1)),
    )


def metal(tree, s, place):
    """Brushed along u, smudged."""
    smudge = tree.spread(tree.noise(tree.stretched(place, 2.0, 30.0), 1.0, 2.0), 0.3, 0.7)
    return s.colour, None, tree.spread(smudge, 0.0, 1.0, s.roughness, min(s.roughness * 1.3 + 0.03, 1.0))


def plain(tree, s, place):
    """One colour."""
    return s.colour, None, s.roughness


def fabric(tree, s, place):
    """Weave; with a second colour stripes, checks or flecks, by the seed."""
    threads = tree.noise(place, 220.0, 1.0)
    colour = tree.mix(tree.spread(threads, 0.3, 0.7), dimmed(s.colour, 0.7), s.colour)
    if s.second:
        choice = random.Random(s.seed)
        kind = choice.choice(["stripes", "checks", "flecks"])
        if kind == "flecks":
            share = tree.spread(tree.noise(place, choice.uniform(8.0, 30.0), 2.0), 0.48, 0.54)
        else:
            scale = choice.uniform(1.5, 5.0)
            bands = [
                tree.add(
                    "ShaderNodeTexWave", {"bands_direction": axis}, Vector=place, Scale=scale, Distortion=0.0
                )
                for axis in ("XY" if kind == "checks" else "X")
            ]
            shares = [tree.spread(band.outputs[1], 0.47, 0.53, 0.0, 1.0 / len(bands)) for band in bands]
            share = shares[0] if len(shares) == 1 else tree.math("ADD", *shares)
        colour = tree.mix(share, colour, s.second)
    return colour, tree.math("MULTIPLY", threads, 0.002), max(s.roughness, 0.75)


def leather(tree, s, place):
    """Creased, worn lighter in places."""
    cells = tree.add("ShaderNodeTexVoronoi", {"feature": "SMOOTH_F1"}, Vector=place, Scale=130.0)
    worn = tree.spread(tree.noise(place, 5.0, 3.0), 0.35, 0.7)
    colour = tree.mix(worn, dimmed(s.colour, 0.75), s.colour)
    return colour, tree.math("MULTIPLY", cells.outputs["Distance"], 0.0015), s.roughness


def plant(tree, s, place):
    """Leaves that differ."""
    share = tree.spread(tree.noise(place, 9.0, 2.0), 0.3, 0.7)
    return tree.mix(share, s.second or dimmed(s.colour, 0.5), s.colour), None, s.roughness


def outdoors(tree, s, place):
    """Ground and facades outside: large stains."""
    share = tree.spread(tree.noise(place, 0.35, 6.0), 0.3, 0.7)
    return tree.mix(share, s.second or dimmed(s.colour, 0.6), s.colour), None, 0.9


def picture(tree, s, place):
    """A print or painting, made up from the seed; coordinates run from 0 to 1."""
    choice = random.Random(s.seed)
    base, accent = s.colour, s.second or tuple(choice.uniform(0.02, 0.8) for _ in range(3))
    third = tuple(choice.uniform(0.02, 0.7) for _ in range(3))
    kind = choice.choice(["landscape", "blots", "blocks", "waves", "photo"])
    upward = tree.add("ShaderNodeSeparateXYZ", Vector=place).outputs[1]
    if kind == "landscape":
        ridge = tree.math("ADD", upward, tree.math("MULTIPLY", tree.noise(place, 3.0, 5.0), -0.35))
        colour = tree.mix(tree.spread(ridge, 0.18, 0.22), accent, base)
        far = tree.math("ADD", upward, tree.math("MULTIPLY", tree.noise(place, 5.0, 3.0), -0.25))
        colour = tree.mix(tree.spread(far, 0.02, 0.04), third, colour)
    elif kind == "blots":
        shares = [
            tree.spread(tree.noise(place, choice.uniform(1.5, 5.0), 3.0, 1.0), 0.5, 0.53) for _ in range(2)
        ]
        colour = tree.mix(shares[1], tree.mix(shares[0], base, accent), third)
    elif kind == "blocks":
        tint, gap = bricks(tree, place, choice.uniform(0.2, 0.6), choice.uniform(0.15, 0.5), 0.012, 0.3)
        colour = tree.mix(gap, tree.mix(tint, base, accent), third)
    elif kind == "waves":
        wave = tree.add(
            "ShaderNodeTexWave", Vector=place, Scale=choice.uniform(0.7, 2.5), Distortion=6.0, Detail=2.0
        )
        colour = tree.mix(wave.outputs[1], base, accent)
    else:
        tones = tree.spread(tree.noise(place, choice.uniform(2.0, 4.0), 8.0, 0.5), 0.32, 0.68)
        colour = tree.mix(tones, tree.mix(0.7, accent, (0.01, 0.01, 0.01)), base)
    return colour, None, s.roughness


def unknown(kind):
    """The error for a kind that has no shader."""
    return ValueError(f"expected a surface of {', '.join(sorted(KINDS))}, received {kind!r}")


KINDS = {
    "paint": paint, "plaster": plaster, "wallpaper": wallpaper, "wood": wood, "planks": planks,
    "carpet": carpet, "tile": tile, "stone": stone, "brick": brick, "concrete": concrete, "metal": metal,
    "plastic": plain, "fabric": fabric, "leather": leather, "glass": plain, "mirror": plain,
    "translucent": plain, "paper": plain, "picture": picture, "plant": plant, "skin": plain,
    "outdoors": outdoors,
}  # fmt: skip
"""Surface.kind -> pattern."""
