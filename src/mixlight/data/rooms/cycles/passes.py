"""Runs inside Blender: light groups in one pass, each without its noise, in one file."""

from pathlib import Path

import bpy

NEW = bpy.app.version >= (5, 0)
"""The compositor is a node group of its own, and its nodes' options are inputs."""

PREFIX, WHOLE = "Combined_", "whole"


def groups(scene, names):
    """Declare the light groups."""
    layer = scene.view_layers[0]
    for name in names:
        layer.lightgroups.add(name=name)
    layer.use_pass_z = True
    layer.cycles.denoising_store_passes = True


def compositor(scene, names, folder, denoise):
    """Nodes that denoise every group and write them with the depth; returns the node that writes.

    Albedo and normals are denoised once and serve all groups. Beside a group that was denoised stands, as
    `noisy-GROUP`, what it was before. Without groups the whole picture is written, as `whole`.
    """
    tree = _tree(scene)
    layers = tree.nodes.new("CompositorNodeRLayers")
    layers.scene = scene
    albedo, normal = layers.outputs["Denoising Albedo"], layers.outputs["Denoising Normal"]
    if denoise:
        albedo = _denoised(tree, albedo, hdr=False)
        normal = _denoised(tree, normal, hdr=False)
    output = _output(tree, folder)
    _slot(tree, output, "FLOAT", "depth", layers.outputs["Depth"])
    for name in names or [WHOLE]:
        noisy = layers.outputs[PREFIX + name if names else "Image"]
        if denoise:
            _slot(tree, output, "RGBA", f"noisy-{name}", noisy)
        made = _denoised(tree, noisy, albedo, normal) if denoise else noisy
        _slot(tree, output, "RGBA", name, made)
    return output


def name_output(output, stem):
    """Set the name of the next file, without its suffix and number."""
    if NEW:
        output.file_name = stem
    else:
        output.base_path = str(Path(output.base_path).parent / stem)


def _tree(scene):
    if NEW:
        scene.compositing_node_group = bpy.data.node_groups.new("groups", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def _denoised(tree, picture, albedo=None, normal=None, hdr=True):
    node = tree.nodes.new("CompositorNodeDenoise")
    if NEW:
        node.inputs["HDR"].default_value = hdr
        node.inputs["Prefilter"].default_value = "None"
        node.inputs["Quality"].default_value = "Balanced"
    else:
        node.use_hdr, node.prefilter, node.quality = hdr, "NONE", "BALANCED"
    tree.links.new(picture, node.inputs["Image"])
    if albedo is not None:
        tree.links.new(albedo, node.inputs["Albedo"])
        tree.links.new(normal, node.inputs["Normal"])
    return node.outputs[0]


def _output(tree, folder):
    node = tree.nodes.new("CompositorNodeOutputFile")
    form = node.format
    if NEW:
        form.media_type = "MULTI_LAYER_IMAGE"
        node.directory, node.file_name = str(folder), "camera"
    else:
        node.base_path = str(Path(folder) / "camera")
    form.file_format = "OPEN_EXR_MULTILAYER"
    form.color_depth, form.exr_codec = "32", "NONE"
    node.save_as_render = False
    if not NEW:
        node.layer_slots.clear()
    return node


def _slot(tree, node, kind, name, socket):
    if NEW:
        node.file_output_items.new(kind, name)
    else:
        node.layer_slots.new(name)
    tree.links.new(socket, node.inputs[name])
