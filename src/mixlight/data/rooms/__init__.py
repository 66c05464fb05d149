"""Procedural rooms: HDR panoramas without end, path traced, with the true light known exactly.

A seed becomes a `Plan` (plain data, no Blender), the plan becomes meshes and lights (`scene`), Blender
renders every light apart (`render`), and the light groups remix into any number of relightings (`remix`).
"""
