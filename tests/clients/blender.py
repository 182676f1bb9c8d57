"""Runs a snippet of docs/clients.md in Blender: blender -b --factory-startup --python blender.py -- CODE CALL FILE OUT

CALL(FILE) of the snippet in CODE gives an object. OUT gets the positions of its vertices as single-precision numbers:
first at rest, then as the modifiers and shape keys leave them."""

import runpy
import sys
import traceback
from array import array

import bpy
import numpy

if "bool" not in vars(numpy):
    # The glTF add-on of Blender 3.4 uses a name that Debian 12's numpy no longer has.
    numpy.bool = bool


def positions(mesh):
    numbers = array("f", bytes(12 * len(mesh.vertices)))
    mesh.vertices.foreach_get("co", numbers)
    return numbers


def main(code, call, file, out):
    for object in list(bpy.data.objects):
        bpy.data.objects.remove(object)
    scan = runpy.run_path(code)[call](file)
    # Shape keys leave the mesh alone at their basis.
    rest = positions(scan.data)
    evaluated = scan.evaluated_get(bpy.context.evaluated_depsgraph_get())
    displaced = positions(evaluated.to_mesh())
    with open(out, "wb") as stream:
        rest.tofile(stream)
        displaced.tofile(stream)


try:
    main(*sys.argv[sys.argv.index("--") + 1 :])
except Exception:
    # Blender would print it and end as if nothing had happened.
    traceback.print_exc()
    sys.stderr.flush()
    sys.exit(1)
