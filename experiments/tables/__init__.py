"""The measured tables of the documentation, so that no number in them is typed by hand.

    python -m experiments.tables

One module a subject; the `TABLES` of each names its tables as the pages do, and `pages` puts them there.
"""
