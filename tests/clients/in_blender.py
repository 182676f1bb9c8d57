"""What every script of the tests does in Blender: an empty scene, and an end that the caller sees."""

import sys
import traceback

import bpy
import numpy

if "bool" not in vars(numpy):
    # The glTF add-on of Blender 3.4 uses a name that Debian 12's numpy no longer has.
    numpy.bool = bool


def run(main):
    """Calls a function with the arguments after `--`, in a scene without objects."""
    for object in list(bpy.data.objects):
        bpy.data.objects.remove(object)
    try:
        main(*sys.argv[sys.argv.index("--") + 1 :])
    except Exception:
        # Blender would print it and end as if nothing had happened.
        traceback.print_exc()
        sys.stderr.flush()
        sys.exit(1)
