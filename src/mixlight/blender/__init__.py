"""Blender as a separate program, for everything that needs it: inserting, rooms, evaluation."""
