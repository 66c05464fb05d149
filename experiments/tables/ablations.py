"""Ablations and what they say of the paper's claims and of the baselines' (docs/ablations.md)."""

from experiments.tables.cells import CELL_NAMES, CELLS
from experiments.tables.markdown import interval, table
from experiments.tables.results import Json, Table, Tables, measured, read
from mixlight.evaluation import ablation_report
from mixlight.evaluation.ablation_report import decided
from mixlight.evaluation.baselines import BASELINES, verdict

CONFIRM = (
    ("baselines", "Gardner19, as published", "Gardner19 (Table 1)"),
    ("baselines", "EMLight, as published", "EMLight, regression stage (Table 1)"),
    ("baselines", "Gardner19, tuned", "Gardner19, tuned"),
    ("baselines", "Gardner19 with our render loss", "Gardner19 with our render loss"),
    ("baselines", "EMLight with our losses", "EMLight with our losses"),
    ("combinations", "SGG (9 SG + 128 SG)", "SGG (Table 2)"),
    ("combinations", "SHH (SH2 + SH6)", "SHH (Table 2)"),
    ("combinations", "SGH (9 SG + SH6)", "SGH (Table 2)"),
    ("sparse", "sparsemax", "sparsemax instead of SLSparsemax (Table 3)"),
    ("sparse", "softmax", "no sparse layer: softmax (Table 3)"),
    ("sparse", "none", "no sparse layer: clamped scores (Table 3)"),
    ("representation", "SGG (9 SG + 128 SG)", "SGG, given the truth"),
    ("representation", "SHH (SH2 + SH6)", "SHH, given the truth"),
    ("representation", "SGH (9 SG + SH6)", "SGH, given the truth"),
)
"""Experiment and variant of each comparison of the paper, and how the table calls it."""


def ablation(name: str, kind: str, part: str = "whole") -> Table:
    """A table of an ablation's results: `medians`, `ratios` or `basis`."""

    @measured(f"ablations/{name}")
    def made(found: Json) -> str:
        if kind == "basis":
            return ablation_report.basis(found) + "\n"
        return str(getattr(ablation_report, kind)(found, part))

    return made


def confirmed() -> str:
    """What each of the paper's comparisons comes to here: the other's error over MixLight's, cell by cell."""
    rows = []
    for experiment, variant, label in CONFIRM:
        result = read(f"ablations/{experiment}")
        if result is None:
            return ""
        cells = result["variants"][variant]["parts"]["whole"]
        entries = []
        for cell in CELLS:
            found, side = cells["ratio_to_reference"][cell], decided(cells, cell)
            word = {1: "yes", -1: "**no**", 0: "open"}[side]
            entries.append(f"{word}: {interval(found['ratio'], found['interval_95'])}")
        rows.append([label, *entries])
    return table(("MixLight is better than", *CELL_NAMES), rows)


def claims() -> str:
    """The baselines' own claims, and what our data says of them."""
    rows = []
    for baseline in BASELINES.values():
        for claim in baseline.claims:
            result = read(f"ablations/{claim.experiment}")
            if result is None:
                return ""
            found = [verdict(result, claim, cell) for cell in claim.cells]
            words = ", ".join(
                f"{found.count(word)} {word}"
                for word in ("confirmed", "open", "contradicted")
                if word in found
            )
            rows.append([baseline.title, claim.says, f"`{claim.experiment}`", words])
    return table(("paper", "claim", "experiment", "of four errors (diffuse and matte)"), rows)


TABLES: Tables = {
    "confirmed": confirmed,
    "claims": claims,
    **{
        f"ablation-{name.replace('_', '-')}-{kind}": ablation(name, kind)
        for name in (
            "representation",
            "combinations",
            "sparse",
            "losses",
            "baselines",
            "counts",
            "counts_anchors",
            "tuning_mixlight",
            "tuning_gardner19",
            "tuning_emlight",
        )
        for kind in ("medians", "ratios", "basis")
    },
    **{
        f"ablation-{name}-{part}": ablation(name, "medians", part)
        for name in ("representation", "combinations")
        for part in ("ambient", "sources")
    },
}
