"""Bakes ambient occlusion of a mesh in Blender: blender -b --factory-startup --python blender_ao.py -- MESH SIZE SAMPLES OUT

OUT gets SIZE x SIZE x 2 single-precision numbers, the first row at the top: the fraction of the hemisphere that is open, and 1 where
the texture coordinates of the mesh cover the texel."""

import sys
from pathlib import Path

import bpy
import numpy

# Blender does not look for modules beside the script.
sys.path.insert(0, str(Path(__file__).parent))
from in_blender import run


def main(mesh, size, samples, out):
    size = int(size)
    bpy.ops.wm.obj_import(filepath=mesh)
    scan = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = scan
    image = bpy.data.images.new("ao", size, size, alpha=True, float_buffer=True, is_data=True)
    image.generated_color = (0, 0, 0, 0)
    material = bpy.data.materials.new("ao")
    material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    # Blender bakes into the image of the active node.
    material.node_tree.nodes.active = node
    scan.data.materials.clear()
    scan.data.materials.append(material)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = int(samples)
    scene.cycles.use_denoising = False
    scene.world = bpy.data.worlds.new("ao")
    # Farther than any mesh of the tests is long.
    scene.world.light_settings.distance = 1e4
    bpy.ops.object.bake(type="AO", margin=0, use_clear=False)
    pixels = numpy.empty(4 * size * size, dtype=numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels.reshape(size, size, 4)[::-1, :, [0, 3]].tofile(out)


run(main)
