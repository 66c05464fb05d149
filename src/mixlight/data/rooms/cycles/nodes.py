"""Runs inside Blender: shader nodes in a few words."""

import bpy


class Tree:
    """A material's or world's nodes; inputs are set to values or linked to outputs, by name or number."""

    def __init__(self, owner):
        if not owner.node_tree:
            owner.use_nodes = True  # deprecated where every material has nodes from the start
        self.tree = owner.node_tree
        self.tree.nodes.clear()

    def add(self, kind, settings=None, **inputs):
        """A node of the kind; `settings` are its properties, the rest its inputs (`_` stands for a blank)."""
        node = self.tree.nodes.new(kind)
        for name, value in (settings or {}).items():
            setattr(node, name, value)
        for name, value in inputs.items():
            self.set(node.inputs[name.replace("_", " ")], value)
        return node

    def set(self, socket, value):
        """Link an output to the input, or give it a value."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif socket.type == "RGBA" and len(value) == 3:
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value

    def math(self, operation, *values):
        """The result of an operation on numbers."""
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            self.set(socket, value)
        return node.outputs[0]

    def mix(self, share, first, second, blend="MIX"):
        """A colour between two; `share` is the second's."""
        node = self.tree.nodes.new("ShaderNodeMixRGB")
        node.blend_type = blend
        for socket, value in zip(node.inputs, (share, first, second), strict=True):
            self.set(socket, value)
        return node.outputs[0]

    def spread(self, value, low, high, at_low=0.0, at_high=1.0):
        """A number mapped from [low, high] to [at_low, at_high], and held at the ends."""
        node = self.tree.nodes.new("ShaderNodeMapRange")
        node.clamp = True
        for socket, number in zip(node.inputs, (value, low, high, at_low, at_high), strict=False):
            self.set(socket, number)
        return node.outputs[0]

    def noise(self, place, scale, detail=2.0, distortion=0.0):
        """Noise around .5, `scale` bumps a metre."""
        node = self.add("ShaderNodeTexNoise", Vector=place, Scale=scale, Detail=detail, Distortion=distortion)
        return node.outputs[0]

    def stretched(self, place, along, across):
        """Coordinates multiplied along u and across it."""
        node = self.add("ShaderNodeVectorMath", {"operation": "MULTIPLY"})
        self.set(node.inputs[0], place)
        self.set(node.inputs[1], (along, across, 1.0))
        return node.outputs[0]

    def surface(self, shader):
        """Make it the output."""
        kind = "ShaderNodeOutputWorld" if self.is_world else "ShaderNodeOutputMaterial"
        output = self.tree.nodes.new(kind)
        self.tree.links.new(shader, output.inputs["Surface"])

    is_world = False
