"""Light turned about any axis (docs/editing.md)."""

from experiments.tables.markdown import percent, table
from experiments.tables.results import Json, Tables, measured


@measured("turning")
def turning(found: Json) -> str:
    """What a turn by any angle costs, by method."""
    cells = {
        "off_deg": ("direction off", _degrees),
        "spread_deg": ("spread", _degrees),
        "energy": ("energy off", _percent_above_rounding),
        "diffuse": ("diffuse sphere", _percent_above_rounding),
        "matte": ("matte sphere", _percent_above_rounding),
        "mirror": ("mirror sphere", _percent_above_rounding),
    }
    rows = [
        [name, *(form(entry[cell]["median"]) for cell, (_, form) in cells.items())]
        for name, entry in found["methods"].items()
    ]
    about = (
        f"Medians over {found['panoramas']} fitted indoor panoramas and "
        f"{len(found['turns_deg'])} turns each; spheres: RMSE over the sphere's own root mean square.\n"
    )
    return "\n".join([about, table(("lobes", *(shown for shown, _ in cells.values())), rows)])


TABLES: Tables = {
    "turning": turning,
}


def _degrees(value: float) -> str:
    return f"{value:.1f}°"


def _percent_above_rounding(value: float) -> str:
    return percent(value) if value > 1e-5 else "< 0.001 %"
