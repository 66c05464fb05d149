"""Light as ambient harmonics and sparse sources: what each choice of the method costs (docs/method.md)."""

from experiments.tables.cells import CELL_NAMES, error_ratios, medians
from experiments.tables.markdown import number, percent, spread, table
from experiments.tables.results import Json, Tables, made_on, measured


@measured("representation")
def basis(found: Json) -> str:
    """What was measured on what."""
    count = found["panoramas"]
    by_split = ", ".join(f"{len(scenes)} {split}" for split, scenes in count["scenes"].items())
    return (
        f"N = {count['views']} views of {count['count']} panoramas ({by_split}); "
        f"{made_on(found['provenance'])}.\n"
    )


@measured("representation")
def facts(found: Json) -> str:
    """Single numbers: what a simplification does before any sphere is rendered."""
    projection, normaliser, clamping = found["projection"], found["normaliser"], found["clamping"]
    plain = projection["Gram matrix, 4 pi / (w h), one pole for both"]
    intensity, sparse_layer, exposed = found["intensity"], found["sparse layer"], found["exposure"]
    fitted = found["separation"]["top_fraction 0.05"]
    rows = [
        (
            "Gram matrix under 4π/(wh) Σ (the harmonics' pole at the panorama's), diagonal",
            f"{number(plain['smallest on the diagonal'])} to {number(plain['largest on the diagonal'])}",
        ),
        ("the same, largest off the diagonal", number(plain["largest off the diagonal"])),
        (
            "source energy under the plain sum, over the true one",
            spread(projection["source energy without over with solid angle"]),
        ),
        ("q with e^(−2s) over q with e^(−2/s), s = 0.0025", f"{normaliser['factor']:.1f}"),
        (
            "integral of one lobe of v = 1 on 128×256, not rescaled",
            f"{normaliser['integral of a lobe on 128x256 with q']:.5f}",
        ),
        (
            "energy of the fit against that of the panorama, largest error",
            percent(fitted["energy error of the fit"]["max"]),
        ),
        ("E from its 5 % to its 95 % quantile, decades", number(intensity["decades of E from p5 to p95"])),
        ("E² likewise, decades", number(intensity["decades of E squared from p5 to p95"])),
        ("length of R = T/E²", spread(intensity["length of R = T / E squared"])),
        (
            "energy in the wrong colour with one colour for all anchors",
            spread(found["colour"]["misplaced"], percent),
        ),
        (
            "sphere where the ambient expansion is negative in a channel",
            spread(clamping["share of the sphere"], percent),
        ),
        ("energy that clamping adds", spread(clamping["energy added"], percent)),
        (
            "sum of `literal` on standard normal scores",
            spread(sparse_layer["sum of the literal mode on standard normal scores"]),
        ),
        (
            "largest change that `masked` makes after a softmax",
            f"{sparse_layer['largest change after a softmax']:.1g}",
        ),
        (
            "light target over truth when the gain is taken after the curve x^(1/2.4)",
            spread(exposed["target over truth"]),
        ),
        (
            "the same, largest over smallest among the views of one panorama",
            spread(exposed["largest over smallest among the views of one panorama"]),
        ),
    ]
    return table(("what", "measured: median (5 % to 95 % quantile), or the value"), rows)


@measured("representation")
def separation(found: Json) -> str:
    """Share, anchors and lights of each rule."""
    rows = []
    for name, entry in found["separation"].items():
        if "spheres" in entry:
            rows.append(
                [
                    f"`{name.split()[0]}` {float(name.split()[1]):.0%}".replace("%", " %"),
                    spread(entry["share of the sphere"], percent),
                    percent(entry["share of the energy"]["median"]),
                    f"{entry['active anchors']['median']:.0f}",
                    f"{entry['lights']['median']:.0f}",
                    *medians(entry["spheres"]),
                ]
            )
    return table(("rule", "of the sphere", "of the energy", "anchors", "lights", *CELL_NAMES), rows)


@measured("representation")
def decision(found: Json) -> str:
    """The two rules against each other, on the same views."""
    found = found["separation"]
    key = "error ratio of top_fraction 0.05 to max_fraction 0.05"
    rows = [
        ["a colour for each anchor (`mixlight fit`)", *error_ratios(found[key])],
        ["one colour for all (as the network predicts)", *error_ratios(found["one colour"][key])],
    ]
    return table(("error of `top_fraction` / error of `max_fraction`", *CELL_NAMES), rows)


@measured("representation")
def ratios(found: Json) -> str:
    """What each simplification does to the spheres."""
    rows = [
        [
            "ambient light summed without solid angle",
            found["projection"]["error ratio, ambient without to with"],
        ],
        ["nothing weighted by solid angle", found["projection"]["error ratio, nothing with to all with"]],
        ["one colour for all anchors", found["colour"]["error ratio of one colour to per anchor"]],
        ["negative ambient lobes clamped", found["clamping"]["error ratio, clamped to negative kept"]],
        ["... and the rest dimmed to keep the energy", found["clamping"]["error ratio, rescaled to clamped"]],
    ]
    return table(
        ("change", *CELL_NAMES),
        [[str(name), *error_ratios(cells)] for name, cells in rows if isinstance(cells, dict)],
    )


@measured("representation")
def degree(found: Json) -> str:
    """Ambient light of other degrees."""
    found = found["ambient degree"]
    names = {
        "degree 1": "degree 1 (4 coefficients)",
        "degree 2": "**degree 2 (9)**",
        "degree 3": "degree 3 (16)",
        "degree 4": "degree 4 (25)",
        "degree 2 without any source": "degree 2 and no sources at all",
    }
    return table(
        ("ambient light", *CELL_NAMES),
        [[shown, *medians(found[f"spheres, {key}"])] for key, shown in names.items()],
    )


@measured("representation")
def sparse(found: Json) -> str:
    """The sparse layer's modes on noisy distributions."""
    found = found["sparse layer"]
    rows = []
    for sigma in (key for key in found if key.startswith("sigma")):
        for mode, entry in found[sigma].items():
            rows.append(
                [
                    sigma.removeprefix("sigma "),
                    f"`{mode}`",
                    f"{entry['sum']['mean']:.3f} ({entry['sum']['max']:.3f})",
                    f"{entry['active anchors']['median']:.0f}",
                    number(entry["squared error"]["mean"]),
                    number(entry["transport"]["mean"]),
                ]
            )
    head = ("noise σ", "mode", "sum: mean (largest)", "active anchors", "squared error", "transport (rad)")
    return table(head, rows)


@measured("representation")
def transport(found: Json) -> str:
    """A unit light on a wrong anchor."""
    found = found["transport"]
    sinkhorn, released = found["Sinkhorn divergence (radians)"], found["EMLight as released"]
    rows = [
        [name, number(entry["next"]["median"]), number(entry["antipode"]["median"])]
        for name, entry in (("EMLight's loss as released", released), ("Sinkhorn divergence", sinkhorn))
    ]
    return table(("all light moved", "to the next anchor", "to the antipode"), rows)


TABLES: Tables = {
    "basis": basis,
    "facts": facts,
    "separation": separation,
    "decision": decision,
    "ratios": ratios,
    "degree": degree,
    "sparse": sparse,
    "transport": transport,
}
