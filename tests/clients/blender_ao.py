"""Blender bakes ambient occlusion of a mesh into its texture coordinates: MESH.obj SIDE SAMPLES OUT.f32, rows from the top."""

import sys

import bpy
import numpy as np

mesh, side, samples, out = sys.argv[sys.argv.index("--") + 1 :]
side = int(side)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=mesh)
thing = bpy.context.selected_objects[0]
bpy.context.view_layer.objects.active = thing
# Normals are blended as planish does: hard at edges of more than 30 degrees.
bpy.ops.object.shade_smooth()
image = bpy.data.images.new("occlusion", side, side, float_buffer=True)
image.colorspace_settings.name = "Non-Color"
material = bpy.data.materials.new("occlusion")
material.use_nodes = True
node = material.node_tree.nodes.new("ShaderNodeTexImage")
node.image = image
material.node_tree.nodes.active = node
thing.data.materials.clear()
thing.data.materials.append(material)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = int(samples)
scene.cycles.use_denoising = False
scene.world = bpy.data.worlds.new("world")
scene.world.light_settings.distance = 1e4
scene.render.bake.margin = 0
bpy.ops.object.bake(type="AO")
texels = np.empty(side * side * 4, dtype="<f4")
image.pixels.foreach_get(texels)
# Blender's rows go up.
texels.reshape(side, side, 4)[::-1, :, 0].tofile(out)
