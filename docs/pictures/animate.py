#!/usr/bin/env python3
"""Joins pictures into an animation that goes to and fro: animate.py OUT.gif LEFT.png… -- RIGHT.png…

Left and right pictures stand side by side, as many of each; below them a slider shows λ from 0 to 1. Needs Pillow, which
tests/python/requirements.txt has.
"""

import sys

from PIL import Image, ImageDraw, ImageFont

FOOT = 34
# Milliseconds of a step of λ, and of its ends.
STEP, REST = 90, 1300
# Fewer shades make a smaller file.
COLOURS = 200


def frame(left, right, strength):
    pictures = [Image.open(path).convert("RGB") for path in (left, right)]
    width, height = pictures[0].size
    joined = Image.new("RGB", (2 * width, height + FOOT), "white")
    for i, picture in enumerate(pictures):
        joined.paste(picture, (i * width, 0))
    draw = ImageDraw.Draw(joined)
    start, end, middle = width // 2, width * 3 // 2, height + FOOT // 2
    knob = start + strength * (end - start)
    draw.line([start, middle, end, middle], fill="#b0b0b0", width=3)
    draw.line([start, middle, knob, middle], fill="#404040", width=3)
    draw.ellipse([knob - 8, middle - 8, knob + 8, middle + 8], fill="#404040")
    font = ImageFont.load_default(17)
    draw.text((start - 16, middle), "noisy", fill="#404040", font=font, anchor="rm")
    draw.text((end + 16, middle), "denoised", fill="#404040", font=font, anchor="lm")
    return joined


def main():
    out, *paths = sys.argv[1:]
    middle = paths.index("--")
    pairs = list(zip(paths[:middle], paths[middle + 1 :], strict=True))
    frames = [frame(*pair, i / (len(pairs) - 1)) for i, pair in enumerate(pairs)]
    # One palette, so that nothing flickers, and the background costs nothing.
    sheet = Image.new("RGB", (frames[0].width, frames[0].height * 2))
    sheet.paste(frames[0], (0, 0))
    sheet.paste(frames[-1], (0, frames[0].height))
    palette = sheet.quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in frames]
    frames = frames + frames[-2:0:-1]
    times = [REST if i in (0, len(pairs) - 1) else STEP for i in range(len(frames))]
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=True, disposal=1)


main()
