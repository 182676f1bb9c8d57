"""Runs a snippet of docs/clients.md in Blender: blender -b --factory-startup --python blender.py -- CODE CALL FILE OUT

CALL(FILE) of the snippet in CODE gives an object. OUT gets the positions of its vertices as single-precision numbers:
first at rest, then as the modifiers and shape keys leave them."""

import runpy
import sys
from array import array
from pathlib import Path

import bpy

# Blender does not look for modules beside the script.
sys.path.insert(0, str(Path(__file__).parent))
from in_blender import run


def positions(mesh):
    numbers = array("f", bytes(12 * len(mesh.vertices)))
    mesh.vertices.foreach_get("co", numbers)
    return numbers


def main(code, call, file, out):
    scan = runpy.run_path(code)[call](file)
    # Shape keys leave the mesh alone at their basis.
    rest = positions(scan.data)
    evaluated = scan.evaluated_get(bpy.context.evaluated_depsgraph_get())
    displaced = positions(evaluated.to_mesh())
    with open(out, "wb") as stream:
        rest.tofile(stream)
        displaced.tofile(stream)


run(main)
