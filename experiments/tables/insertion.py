"""Objects put into photos (docs/insert.md)."""

from experiments.tables.markdown import number, table
from experiments.tables.results import Json, Tables, measured


@measured("insert")
def insertion(found: Json) -> str:
    """Objects in photos, under the estimate against under the true panorama."""
    rows = [
        [
            f"`{scene}`",
            row["object"],
            *(number(row[f"object_{name}"]) for name in ("rmse", "si_rmse", "rms_of_truth")),
            number(row["object_mean_over_true_mean"]),
            number(row["shadow_rmse"]),
            number(row["shadow_sum_over_true_sum"]),
        ]
        for scene, row in found["scenes"].items()
    ]
    head = (
        *("photo", "object", "object RMSE", "si-RMSE", "rms of the true one", "brightness over true"),
        *("shadow RMSE", "depth over true"),
    )
    return table(head, rows)


@measured("insert")
def insertion_basis(found: Json) -> str:
    """What the insertions were measured on."""
    weights, made = found.get("model_commit", "as shipped"), found["provenance"]
    return (
        f"Model `{found['model']}` ({weights}), {found['samples']} samples, seed {made['seed']}; "
        f"commit `{made['commit']}`.\n"
    )


TABLES: Tables = {
    "insertion": insertion,
    "insertion-basis": insertion_basis,
}
