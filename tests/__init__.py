"""The tests, in the same tree as src/mixlight; every folder runs on its own."""
