"""Panoramas with their splits, the light in them, and the photos a camera takes of them."""
