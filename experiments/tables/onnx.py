"""The ONNX file's variants (docs/consumers/onnx.md)."""

from experiments.tables.markdown import table
from experiments.tables.results import Json, Tables, measured


@measured("onnx")
def onnx(found: Json) -> str:
    """Size, speed and accuracy of the ONNX file's variants."""
    rows = []
    for name, entry in found["variants"].items():
        error = entry["largest_output_error"]
        rows.append(
            [
                f"**`--precision {name}`**" if entry["offered"] else name,
                f"{entry['bytes'] / 1e6:.1f} MB",
                f"{entry['ms']['least']:.1f} ms",
                f"{entry['ms']['ratio']:.2f}",
                f"{entry['web_ms']['least']:.0f} ms" if "least" in entry.get("web_ms", {}) else "–",
                f"{error['ambient']:.1g}",
                f"{error['anchor_energy']:.1g}",
                "0 %" if abs(entry["cost"]) < 5e-5 else f"{100 * entry['cost']:+.2f} %",
            ]
        )
    head = ("variant", "file", "onnxruntime", "of float32", "onnxruntime-web", "ambient", "sources", "cost")
    return table(head, rows)


@measured("onnx")
def onnx_basis(found: Json) -> str:
    """What the ONNX variants were measured on."""
    made, model = found["provenance"], found["model"]
    return (
        f"Model `{model['name']}` (SHA-256 {model['sha256'][:12]}…), {made['n']} views of "
        f"{found['scenes']} scenes of the split `val`; commit `{made['commit']}`, "
        f"onnxruntime {made['onnxruntime']}, torch {made['torch']}; {made['machine']}.\n"
    )


TABLES: Tables = {
    "onnx": onnx,
    "onnx-basis": onnx_basis,
}
