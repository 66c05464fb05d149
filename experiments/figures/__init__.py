"""The figures of docs/evaluation.md, one command each; each writes a PNG and a PDF."""
