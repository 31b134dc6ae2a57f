#!/usr/bin/env python3
"""Draws stewart.svg: one period of the sample `stewart`, as `assur run` computes it.

    docs/pictures/stewart.py build/assur > docs/pictures/stewart.svg
"""
import csv
import io
import math
import subprocess
import sys

FRAMES, SECONDS = 48, 6  # of the picture; the motion repeats after 2 pi s
WIDTH, HEIGHT = 760, 360
LEGS = range(1, 7)


def postures(assur):
    """Points by name, one dictionary for each frame; m."""
    names = [f"{p}{k}" for k in LEGS for p in "ABP"] + ["O"]
    text = subprocess.run(
        [assur, "run", "stewart", "--outputs", ",".join(f"{n}.position" for n in names), "--dt",
         repr(2 * math.pi / FRAMES), "--steps", str(FRAMES), "--csv", "-", "--quiet"],
        check=True, stdout=subprocess.PIPE, text=True).stdout
    return [{n: tuple(float(row[f"{n}.{c}"]) for c in "xyz") for n in names} for row in csv.DictReader(io.StringIO(text))]


def on_picture(p):
    """Seen from the front and a little from above."""
    turn, tilt, scale = math.radians(-68), math.radians(22), 340
    x = p[0] * math.cos(turn) - p[1] * math.sin(turn)
    y = p[0] * math.sin(turn) + p[1] * math.cos(turn)
    up = p[2] * math.cos(tilt) + y * math.sin(tilt)
    return f"{WIDTH / 2 + scale * x:.1f},{HEIGHT - 95 - scale * up:.1f}"


def depth(p):
    turn = math.radians(-68)
    return p[0] * math.sin(turn) + p[1] * math.cos(turn)


def moving(tag, paths, style):
    """A polygon or polyline through points that move: `paths` has the points of each frame."""
    frames = [" ".join(map(on_picture, path)) for path in paths]
    return (f'<{tag} points="{frames[0]}" {style}><animate attributeName="points" dur="{SECONDS}s" '
            f'repeatCount="indefinite" values="{";".join(frames)}"/></{tag}>')


def main():
    frames = postures(sys.argv[1])
    first = frames[0]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
           'fill="none" stroke-linecap="round" stroke-linejoin="round">',
           "<title>A Stewart platform in motion: six handles, six rods, one terminal</title>",
           f'<rect width="{WIDTH}" height="{HEIGHT}" rx="8" fill="#f7f8fa"/>',
           f'<polygon points="{" ".join(on_picture(first[f"A{k}"]) for k in LEGS)}" fill="#d5dae1" stroke="#8b95a3"/>']
    for k in sorted(LEGS, key=lambda k: -depth(first[f"A{k}"])):  # those behind first
        path = " ".join(on_picture(f[f"B{k}"]) for f in frames)
        out.append(f'<polyline points="{path}" stroke="#e2a24b" stroke-dasharray="2 5"/>')
        out.append(moving("polyline", [[f[f"A{k}"], f[f"B{k}"]] for f in frames], 'stroke="#c8641c" stroke-width="7"'))
        out.append(moving("polyline", [[f[f"B{k}"], f[f"P{k}"]] for f in frames], 'stroke="#3d5a80" stroke-width="4"'))
    out.append(moving("polygon", [[f[f"P{k}"] for k in LEGS] for f in frames],
                      'fill="#5b8fc7" fill-opacity="0.75" stroke="#1d3557" stroke-width="3"'))
    path = " ".join(on_picture(f["O"]) for f in frames)
    out.append(f'<polyline points="{path}" stroke="#1d3557" stroke-dasharray="2 5"/>')
    out.append("</svg>")
    print("\n".join(out))


main()
