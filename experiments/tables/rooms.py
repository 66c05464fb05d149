"""Rendered rooms: what they teach, how like real ones they are, what they cost to keep (docs/rooms.md)."""

from experiments.tables.markdown import QUARTILES, interval, percent, plain, quartiles, table
from experiments.tables.results import Json, Tables, measured
from mixlight.data.rooms.stats import LABELS


@measured("rooms")
def rooms(found: Json) -> str:
    """Networks trained on real panoramas, on rooms and on both, on the same real test photos."""
    rows = []
    for entry in found["conditions"]:
        row = [entry["label"], str(entry["real"]), str(entry["rooms"]), str(len(entry["seeds"]))]
        for cell in ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse"):
            number = entry["cells"][cell]
            row.append(interval(number["error"], number["interval_95"], 3))
        number = entry["cells"]["diffuse_rmse"]
        row.append(interval(number["ratio"], number["ratio_interval_95"]) if "ratio" in number else "1")
        row.append(" ".join(f"{score:.3f}" for score in entry["validation"]))
        rows.append(row)
    about = (
        f"Protocol {found['provenance']['protocol']}, {found['split']} split: {found['views']} photos of "
        f"{len(found['panoramas'])} panoramas ({', '.join(found['categories'])}); commit "
        f"`{found['provenance']['commit'][:10]}`; {found['provenance']['machine']}.\n"
    )
    head = (
        *("trained on", "real panoramas", "panoramas of rooms", "seeds"),
        *("diffuse RMSE", "diffuse si-RMSE", "matte RMSE", "diffuse RMSE over real only's"),
        "score on val, by seed",
    )
    return "\n".join([about, table(head, rows)])


@measured("room_statistics")
def room_statistics(found: Json) -> str:
    """The light of rendered rooms beside that of real interiors."""
    rows = []
    for name, entry in found["statistics"].items():
        spans = [quartiles(*entry[side][1:4]) for side in ("rooms", "reference")]
        rows.append([LABELS[name], *spans, entry["median"]])
    head = (
        QUARTILES,
        f"{found['panoramas']} relightings of {found['rooms']} rooms",
        found["reference"]["name"],
        "the rooms' median",
    )
    made = found["set"]
    about = (
        f"Rooms of the seeds {made['seeds'][0]} to {made['seeds'][1]}, {made['width']}x{made['width'] // 2}, "
        f"{made['cameras']} camera each, {made['samples']} paths a pixel, rendered by `{made['commit']}`; "
        f"{found['recipes']} relightings each, drawn by `{found['provenance']['commit'][:7]}`.\n"
    )
    return "\n".join([about, table(head, rows)])


@measured("room_storage")
def room_storage(found: Json) -> str:
    """What each way to store light groups costs: median and 95th percentile."""
    keys = ("pixels", "energy", "sources", "ambient", "diffuse", "matte", "mirror")

    def share(value: float) -> str:
        return percent(value) if value >= 1e-4 else "< 0.01 %"

    rows = [
        [name, plain(cells["megabytes"]["median"], 2)]
        + [f"{share(cells[key]['median'])} ({share(cells[key]['p95'])})" for key in keys]
        for name, cells in found["variants"].items()
    ]
    return table(["storage", "MB a position", *keys], rows)


@measured("brightness")
def brightness(found: Json) -> str:
    """How much brighter than a photo the light around it is."""
    rows = []
    for name, row in found["groups"].items():
        deviation = f"{row['standard_deviation']:.2f}"
        rows.append([name, str(row["panoramas"]), quartiles(*row["quartiles"]), deviation])
    head = ("panoramas", "number", QUARTILES, "standard deviation")
    return f"Commit `{found['provenance']['commit'][:10]}`.\n\n" + table(head, rows)


TABLES: Tables = {
    "rooms": rooms,
    "room-statistics": room_statistics,
    "room_storage": room_storage,
    "brightness": brightness,
}
