"""Neural networks that estimate light."""
