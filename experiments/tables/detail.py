"""The photo's own pixels in the map (docs/detail.md)."""

from experiments.tables.markdown import interval, table
from experiments.tables.results import Json, Tables, measured

CELLS = {
    "diffuse_rmse": "diffuse RMSE",
    "matte_rmse": "matte RMSE",
    "mirror_rmse": "mirror RMSE",
    "mirror_si_rmse": "mirror si-RMSE",
    "mirror_shown": "mirror as a screen shows it",
    "mirror_seen_shown": "the same, where it reflects what the photo shows",
}
"""Errors that are shown, and what the tables call them."""


@measured("detail")
def detail(found: Json) -> str:
    """The photo in the map: errors of the spheres with and without it, on test."""
    test = found["test"]
    entry = test["with the photo"]["shipped"]
    rows = []
    for cell, shown in CELLS.items():
        ratio = entry["ratio"][cell]
        rows.append(
            [
                shown,
                f"{test['without'][cell]:.3f}",
                f"{entry['median'][cell]:.3f}",
                _ratio(ratio),
                f"{100 * ratio['views that gain']:.0f} %",
            ]
        )
    head = ("error", "without: median", "with: median", "with / without", "views that gain")
    about = (
        f"N = {test['views']} photos of {test['panoramas']} indoor test panoramas; model "
        f"`{found['provenance']['model']}`, the camera's pose as the model found it; commit "
        f"`{found['provenance']['commit'][:10]}`.\n"
    )
    return "\n".join([about, table(head, rows)])


@measured("detail")
def detail_variants(found: Json) -> str:
    """What was chosen between, on val."""
    cells = ("diffuse_rmse", "matte_rmse", "mirror_rmse", "mirror_si_rmse", "mirror_seen_shown")
    rows = []
    for kind, group in found["validation"].items():
        for name, entry in group["with the photo"].items():
            shown = f"**{name}**" if name == "shipped" else name
            ratios = [_ratio(entry["ratio"][cell]) for cell in cells]
            rows.append([f"{group['views']} views of {group['panoramas']} {kind}", shown, *ratios])
    return table(("validation", "variant", *(CELLS[cell] for cell in cells)), rows)


TABLES: Tables = {
    "detail": detail,
    "detail-variants": detail_variants,
}


def _ratio(entry: Json) -> str:
    return interval(entry["ratio"], entry["interval_95"], 3)
