#!/usr/bin/env python3
"""Reads G-code of beadwork with two parsers of other authors, and compares their totals.

    pip install gcode-lib==1.1.13 gcodeparser==0.3.0
    docs/bench/parse_gcode.py BEADWORK PARTS [--parts NAME,..] [-- FLAGS OF plan]

BEADWORK is the binary, PARTS the folder 3mf of SlicerTestModels.
Plans three parts, and compares filament, extents and the number of extrusion moves of each program:
- gcode-lib follows positions and extrusion itself (its `advance_state`),
- gcodeparser reads the lines, and the few lines of `of_gcodeparser` follow them,
- `beadwork eval beads --program` counts them.
Exit code 1 if a figure differs.

Flags after -- replace those of `plan`, which print beads by default; with --objective tools they print cells.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

import gcode_lib
import gcodeparser

PARTS = [("torus", 0), ("Bearing", 0), ("yin_yang", 90)]
FLAGS = ["--purge", "0", "--tower", "none"]
DIAMETER_MM = 1.75
# Features whose moves `eval beads` does not count.
AROUND = {"Custom", "Wipe tower", "Skirt/Brim", "Support material"}


class Sums:
    """Sums over the extrusion moves of the part."""

    def __init__(self):
        self.moves, self.filament_mm, self.length_mm = 0, 0.0, 0.0
        self.low, self.high = [math.inf, math.inf], [-math.inf, -math.inf]
        self.feature, self.has_layer = "", False

    def comment(self, text):
        if text == "LAYER_CHANGE":
            self.has_layer = True
        elif text.startswith("TYPE:"):
            self.feature = text[5:]

    def move(self, before, after, filament_mm):
        length = math.dist(before, after)
        if filament_mm <= 0 or length == 0 or not self.has_layer or self.feature in AROUND:
            return
        self.moves += 1
        self.filament_mm += filament_mm
        self.length_mm += length
        for point in (before, after):
            for axis in range(2):
                self.low[axis] = min(self.low[axis], point[axis])
                self.high[axis] = max(self.high[axis], point[axis])

    def figures(self):
        area = math.pi * DIAMETER_MM ** 2 / 4
        return {"moves": self.moves, "filament, mm³": self.filament_mm * area,
                "extruded, mm": self.length_mm, "left": self.low[0], "right": self.high[0],
                "front": self.low[1], "back": self.high[1]}


def of_gcode_lib(path):
    sums, state = Sums(), gcode_lib.ModalState()
    for line in gcode_lib.load(path).lines:
        sums.comment(line.comment.lstrip(";").strip())
        before, filament = (state.x, state.y, state.z), state.e
        gcode_lib.advance_state(state, line)
        if line.is_move:
            sums.move(before, (state.x, state.y, state.z), state.e - filament)
    return sums.figures()


def of_gcodeparser(path):
    sums, position, filament, is_relative = Sums(), [0.0] * 3, 0.0, False
    with open(path, encoding="utf-8") as file:
        for line in gcodeparser.parse_gcode_lines(file, include_comments=True):
            sums.comment(line.comment)
            if line.command in (("M", 82), ("M", 83)):
                is_relative = line.command == ("M", 83)
            elif line.command == ("G", 92):
                filament = float(line.get_param("E", default=filament))
            elif line.type == gcodeparser.Commands.MOVE:
                before = list(position)
                position = [float(line.get_param(axis, default=old))
                            for axis, old in zip("XYZ", position)]
                if is_relative:
                    step = float(line.get_param("E", default=0.0))
                else:
                    step = float(line.get_param("E", default=filament)) - filament
                    filament += step
                sums.move(before, position, step)
    return sums.figures()


def of_beadwork(binary, path):
    done = subprocess.run([binary, "eval", "beads", "--program", path, "--json",
                           "--filament-diameter", str(DIAMETER_MM)],
                          capture_output=True, text=True, check=True)
    counts = json.loads(done.stdout)["programs"][0]
    (left, front), (right, back) = counts["bounds_mm"]
    return {"moves": counts["extrusion_moves"], "filament, mm³": counts["filament_mm3"],
            "extruded, mm": counts["extrusion_mm"], "left": left, "right": right, "front": front,
            "back": back}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", help="the binary beadwork")
    parser.add_argument("folder", help="folder of the 3MF files")
    parser.add_argument("--parts", help="names of parts, separated by commas")
    parser.add_argument("flags", nargs="*", help="flags of plan, after --")
    args = parser.parse_args()
    binary, folder = os.path.abspath(args.binary), tempfile.mkdtemp()
    names = args.parts.split(",") if args.parts else [name for name, _ in PARTS]
    differs = False
    for name in names:
        path = os.path.join(folder, f"{name}.gcode")
        turn = f"{dict(PARTS).get(name, 0)},0,0"
        subprocess.run([binary, "plan", os.path.join(args.folder, f"{name}.3mf"), "--rotate", turn,
                        *(args.flags or FLAGS), "--out", path],
                       capture_output=True, text=True, check=True)
        ours = of_beadwork(binary, path)
        programs = {"beadwork": ours, "gcode-lib": of_gcode_lib(path),
                    "gcodeparser": of_gcodeparser(path)}
        if name == names[0]:
            print("| part | parser | " + " | ".join(ours) + " |\n" + "|---" * (len(ours) + 2) + "|")
        for program, figures in programs.items():
            cells = [f"{value:.3f}" if isinstance(value, float) else str(value)
                     for value in figures.values()]
            print(f"| {name} | {program} | " + " | ".join(cells) + " |")
            differs |= any(not math.isclose(value, ours[key], rel_tol=1e-9, abs_tol=1e-6)
                           for key, value in figures.items())
    print("\n" + ("Figures differ." if differs else "All figures agree."))
    sys.exit(differs)


main()
