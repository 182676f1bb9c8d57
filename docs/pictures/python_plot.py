"""Draws the picture of docs/python.md: what `planish.denoise(…).plot()` shows of the duck. Needs the package and matplotlib."""

import sys
from pathlib import Path

import matplotlib
import planish

matplotlib.use("Agg")
folder = Path(__file__).resolve().parent
duck = planish.read(folder.parents[1] / "data" / "duck_noisy.obj")
axes = duck.denoise().plot()
axes.view_init(elev=20, azim=-60, vertical_axis="y")
axes.figure.savefig(sys.argv[1] if len(sys.argv) > 1 else folder / "python_plot.png", dpi=110, bbox_inches="tight")
