"""Light made ready for other programs: one small module a target, behind `Rig` and the registry.

Nothing is imported before it is used: `registry` alone lists the targets without torch.
"""
