"""Training runs (docs/training.md)."""

from experiments.tables.cells import error_ratios
from experiments.tables.markdown import table
from experiments.tables.results import Json, Tables, measured

_COMPARED = ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse")


@measured("trials")
def trials(found: Json) -> str:
    """Validation of the training runs that led to the model in the box, at the step that each run chose."""
    rows = []
    for trial in found["trials"]:
        cells = [f"{trial['best'][cell]:.3f}" for cell in trial["best"]]
        step = (
            f"mean of {sum(row['averaged'] for row in trial['members'])} of {len(trial['members'])}"
            if "members" in trial
            else f"{trial['best_step']} of {trial['last_step']}"
        )
        rows.append([trial["run"], step, f"{trial['best_score']:.4f}", *cells])
    names = [cell.replace("/", " ") for cell in found["trials"][0]["best"]]
    return table(("run", "step", "score", *names), rows)


@measured("glow")
def glow(found: Json) -> str:
    """Few sources: the energy of the others given to them, against added to the ambient light."""
    cells = [
        (kind, cell)
        for kind in ("real", "rooms")
        for cell in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse")
    ]
    rows = []
    for name, entry in found["variants"].items():
        medians = [f"{entry[kind][cell]['median']:.3f}" for kind, cell in cells]
        rows.append([name, f"{entry['active']:.0f}", f"{100 * entry['kept']:.0f} %", *medians])
    names = [f"{kind} {cell.replace('_', ' ')}" for kind, cell in cells]
    return table(("variant and gain", "active anchors", "source energy kept", *names), rows)


@measured("retrained")
def retrained(found: Json) -> str:
    """Trainings that might go into the box: val, which decides, and test."""
    rows = []
    last = list(found["models"])[-1]
    for name, row in found["models"].items():
        camera, test = row["camera_on_val"], row["test_medians"]
        rows.append(
            [
                name,
                *(f"{row['val'][key]:.4f}" for key in ("score", "real/score", "rooms/score")),
                *(f"{camera[kind]['pitch_error_deg']:.1f}°" for kind in ("real", "rooms")),
                *(f"{test[c]:.3f}" for c in _COMPARED),
                *(["1"] * len(_COMPARED) if name == last else error_ratios(row["last_over_this"], _COMPARED)),
            ]
        )
    head = ("run", "val: score", "real", "rooms", "val: pitch, real", "pitch, rooms")
    tested = ("test: diffuse RMSE", "diffuse si-RMSE", "matte RMSE", "matte si-RMSE")
    ratios = (f"test: {last}'s diffuse RMSE over this one's", *tested[1:])
    return table((*head, *tested, *ratios), rows)


@measured("unseen")
def unseen(found: Json) -> str:
    """Ways of training, on real places that the network has not seen."""
    cells = ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse")
    rows = []
    for name, row in found["models"].items():
        over = row["ratio"]["diffuse_rmse"]
        low, high = over["interval_95"]
        rows.append(
            [
                name,
                *(f"{row['geometric_mean'][cell]:.3f}" for cell in cells),
                "1" if low == high else f"{over['ratio']:.2f} ({low:.2f}–{high:.2f})",
                " ".join(f"{score:.3f}" for score in row["val_score"]),
            ]
        )
    head = ("training", *(cell.replace("_", " ") for cell in cells), "diffuse rmse over the first's")
    made = found["provenance"]
    return (
        f"{made['n']} views of {found['panoramas']} panoramas ({found['places']} places); geometric means; "
        f"commit `{made['commit']}`.\n\n" + table((*head, "score on val"), rows)
    )


TABLES: Tables = {
    "unseen": unseen,
    "trials": trials,
    "glow": glow,
    "retrained": retrained,
}
