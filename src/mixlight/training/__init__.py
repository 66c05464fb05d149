"""Training runs: a TOML config in, weights out, resumable at any step."""
