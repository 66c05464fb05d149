"""Rewrites the measured tables of the documentation: `python -m experiments.tables`."""

from experiments.tables.pages import BLOCK, ROOT, filled, pages


def main() -> None:
    """Rewrite the blocks of all pages."""
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if BLOCK.search(text):
            page.write_text(filled(text), encoding="utf-8")
            print(page.relative_to(ROOT))


if __name__ == "__main__":
    main()
