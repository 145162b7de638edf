#!/usr/bin/env python3
"""Compares beads, travel and times of five parts between beadwork and PrusaSlicer 2.5.

    docs/bench/beads_beside_prusaslicer.py BEADWORK PARTS [--out DIR] [--runs N] [--json FILE]
                                           [--parts NAME,..] [--basis same,defaults] [--width MM,..]

BEADWORK is the binary, PARTS the folder 3mf of SlicerTestModels.
Needs `prusa-slicer`, Debian's package.
Prints tables in Markdown; --json also writes the figures.
Without a planner of beads in BEADWORK, PrusaSlicer is reported alone.

Both programs get the same bodies in the same positions: PrusaSlicer as a project that this script
writes, with one object, so that nothing is rearranged, and one volume and extruder for each
material.
yin_yang is laid flat.

Two bases:
- same: the same features in both: 2 perimeters, straight lines at 45 and 135 degrees, no solid
  layers, no gap fill, no thin walls (except heartgears), no skirt, no supports, no prime tower,
  seams where travel is short.
- defaults: what both print without further flags.
On both bases, layers are 0.25 mm high, lines are 0.5 mm apart where they are dense, and speeds,
accelerations and retraction are those of beadwork's default profile.
The whole comparison is made for each of PrusaSlicer's extrusion widths: by default the one whose
spacing = width - height (1 - pi/4) is 0.5 mm, and 0.5 mm, whose spacing is 0.446 mm.
The choice matters: its infill region begins closer to the outline if lines are narrower.
With a spacing of 0.446 mm it prints 837 infill beads on Bearing at 20 %, with one of 0.5 mm 1770.

beadwork prints in three ways: island by island with loops before infill (unjoined), with insets and
infill joined (joined), and in any order (free).
The last table compares the ratios with the figures that the project has set itself; bold figures
miss them.

Both programs of a pair are counted and timed by `beadwork eval beads --program`, and counted once
more, independently, by `count` below.
Seconds are the median of the wall-clock times of all runs, in turn, from the mesh to the file.
"""

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

from parts_for_slicers import by_material, placed, read_3mf, write_project

LAYER_MM, BEAD_MM, DIAMETER_MM = 0.25, 0.5, 1.75
CENTRE = (125.0, 105.0)
# Name, rotation about x in degrees, and whether PrusaSlicer prints thin walls.
PARTS = [("torus", 0, False), ("Bearing", 0, False), ("heartgears", 0, True),
         ("yin_yang", 90, False), ("8_extruders", 0, False)]
DENSITIES = [20, 100]
# Flags of beadwork for each way to print: island by island, with insets and infill joined, and in
# any order.
VARIANTS = {"unjoined": [], "joined": ["--join"], "free": ["--order", "free"]}
# Seconds that one run of either program may take.
LIMIT_S = 900

# Motion of both programs: the default profile of beadwork.
PRINT_MM_S, FIRST_LAYER_MM_S, TRAVEL_MM_S = 30, 20, 150
ACCELERATION, CORNER_MM_S, MAX_MM_S = 1000, 5, 200
RETRACT_MM, RETRACT_MM_S, RETRACT_BEYOND_MM = 0.8, 35, 2

# Features that are not part of the printed object, in PrusaSlicer's comments.
AROUND = {"Custom", "Skirt/Brim", "Wipe tower", "Support material", "Support material interface"}
GROUPS = {"External perimeter": "walls", "Perimeter": "walls", "Overhang perimeter": "walls",
          "Thin wall": "walls", "Gap fill": "gap_fill", "Internal infill": "infill",
          "Solid infill": "infill", "Top solid infill": "infill", "Bridge infill": "infill",
          "Ironing": "infill"}


def settings(basis, tools, density, thin_walls, width):
    """PrusaSlicer's configuration."""
    def each(value):
        return ",".join([str(value)] * tools)

    names = ["", "first_layer_", "perimeter_", "external_perimeter_", "infill_", "solid_infill_",
             "top_infill_"]
    lines = {f"{name}extrusion_width": width for name in names}
    speeds = ["perimeter", "small_perimeter", "external_perimeter", "infill", "solid_infill",
              "top_solid_infill", "gap_fill", "bridge", "support_material", "ironing"]
    lines |= {f"{name}_speed": PRINT_MM_S for name in speeds}
    kinds = ["default", "perimeter", "infill", "bridge", "first_layer"]
    lines |= {f"{name}_acceleration": 0 for name in kinds}
    lines |= {
        "layer_height": LAYER_MM, "first_layer_height": LAYER_MM, "nozzle_diameter": each(BEAD_MM),
        "filament_diameter": each(DIAMETER_MM), "extrusion_multiplier": each(1),
        "temperature": each(210), "first_layer_temperature": each(210), "cooling": each(0),
        "first_layer_speed": FIRST_LAYER_MM_S, "travel_speed": TRAVEL_MM_S,
        "max_volumetric_speed": 0, "machine_limits_usage": "ignore",
        "retract_length": each(RETRACT_MM), "retract_length_toolchange": each(RETRACT_MM),
        "retract_speed": each(RETRACT_MM_S), "deretract_speed": each(0),
        "retract_before_travel": each(RETRACT_BEYOND_MM), "retract_lift": each(0),
        "retract_layer_change": each(0), "wipe": each(0), "retract_restart_extra": each(0),
        "only_retract_when_crossing_perimeters": 0, "wipe_tower": 0,
        "single_extruder_multi_material": 0, "ooze_prevention": 0, "skirts": 0,
        "brim_type": "no_brim", "elefant_foot_compensation": 0, "gcode_flavor": "marlin2",
        "use_relative_e_distances": 1, "layer_gcode": "G92 E0", "start_gcode": "", "end_gcode": "",
        "bed_shape": "0x0,250x0,250x210,0x210", "support_material": 0,
    }
    if basis == "same":
        lines |= {
            "perimeters": 2, "perimeter_generator": "classic", "extra_perimeters": 0,
            "thin_walls": int(thin_walls), "gap_fill_enabled": 0, "overhangs": 0,
            "fill_density": f"{density}%", "fill_pattern": "rectilinear", "fill_angle": 45,
            "top_solid_layers": 0, "bottom_solid_layers": 0, "top_solid_min_thickness": 0,
            "bottom_solid_min_thickness": 0, "solid_infill_below_area": 0,
            "ensure_vertical_shell_thickness": 0,
        }
    return lines


def flags(basis, density, thin_walls):
    """The same for `beadwork plan`."""
    common = ["--layer", str(LAYER_MM), "--bead", str(BEAD_MM), "--purge", "0", "--tower", "none",
              "--centre", f"{CENTRE[0]},{CENTRE[1]}", "--bed", "250,210,210"]
    if basis == "defaults":
        return common
    walls = [] if thin_walls else ["--no-thin-walls"]
    return [*common, *walls, "--density", str(density), "--perimeters", "2", "--solid-layers", "0",
            "--pattern", "lines", "--seam", "nearest", "--no-gap-fill"]


def distance(a, b):
    return math.dist(a, b)


def count(path):
    """Beads and travel from the text alone: moves by G0 and G1, extrusion relative or absolute."""
    position, e, relative_e = [0.0, 0.0, 0.0], 0.0, False
    feature, layer, tool = "", -1, None
    open_bead = None  # the groups of the bead that may still go on
    gap = 0.0  # travel since its end
    travel = {"pending": 0.0, "sum": 0.0}
    beads, layers, retractions, pending_retractions, is_retracted = [], set(), 0, 0, False
    has_begun, extruded = False, 0.0
    for line in open(path, encoding="utf-8"):
        code, _, comment = line.partition(";")
        comment = comment.strip()
        if comment == "LAYER_CHANGE":
            layer += 1
        elif comment.startswith("TYPE:"):
            feature = comment[5:]
        words = code.split()
        if not words:
            continue
        name, values = words[0], {word[0]: word[1:] for word in words[1:] if word[0] in "XYZEF"}
        values = {axis: float(text or 0) for axis, text in values.items()}
        if name == "M83":
            relative_e = True
        elif name == "M82":
            relative_e = False
        elif name == "G92":
            e = values.get("E", e)
        elif re.fullmatch(r"T\d+", name):
            if name != tool:
                open_bead = None
            tool = name
        elif name in ("G0", "G1"):
            before = list(position)
            for axis, letter in enumerate("XYZ"):
                position[axis] = values.get(letter, position[axis])
            step = values.get("E", 0.0 if relative_e else e) - (0.0 if relative_e else e)
            if not relative_e:
                e = values.get("E", e)
            length = distance(before, position)
            if step < 0 and not is_retracted and has_begun:
                pending_retractions += 1
            if step != 0:
                is_retracted = step < 0
            is_part = step > 0 and length > 0 and layer >= 0 and feature not in AROUND
            if not is_part:
                gap += length
                travel["pending"] += 0.0 if step > 0 and length > 0 else length
                continue
            if has_begun:
                travel["sum"] += travel["pending"]
                retractions += pending_retractions
            travel["pending"], pending_retractions, has_begun = 0.0, 0, True
            extruded += length
            layers.add(layer)
            if open_bead is None or gap > 0.01:
                open_bead = set()
                beads.append(open_bead)
            open_bead.add(GROUPS.get(feature, "other"))
            gap = 0.0
    only = {group: sum(bead == {group} for bead in beads)
            for group in ("walls", "infill", "gap_fill", "other")}
    return {"layers": len(layers), "beads": len(beads), **only,
            "joined": sum(len(bead) > 1 for bead in beads), "retractions": retractions,
            "travel_mm": travel["sum"], "extrusion_mm": extruded}


def run(command):
    begin = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    return done, time.perf_counter() - begin


def slice_part(project, config, gcode):
    done, seconds = run(["prusa-slicer", "--export-gcode", "--dont-arrange", "--load", config,
                         "--output", gcode, project])
    if done.returncode or not os.path.exists(gcode):
        sys.exit(f"prusa-slicer failed on {project}: {(done.stdout + done.stderr)[-400:]}")
    return seconds


def plan_part(binary, path, rotation, extra, gcode):
    """Seconds, or the reason why there is no program."""
    done, seconds = run([binary, "plan", path, "--rotate", f"{rotation},0,0", *extra, "--out",
                         gcode])
    if done.returncode == 0:
        return seconds, None
    return None, (done.stderr.strip().splitlines() or ["unknown failure"])[-1]


def evaluated(binary, gcode):
    """The figures by `eval beads --program`, or `None` if BEADWORK does not have it."""
    done, _ = run([binary, "eval", "beads", "--program", gcode, "--json", "--acceleration",
                   str(ACCELERATION), "--square-corner", str(CORNER_MM_S), "--max-speed",
                   str(MAX_MM_S), "--filament-diameter", str(DIAMETER_MM)])
    return json.loads(done.stdout)["programs"][0] if done.returncode == 0 else None


def figures(binary, gcode, seconds):
    counted = count(gcode)
    official = evaluated(binary, gcode) or counted
    differing = [key for key, value in counted.items()
                 if not math.isclose(official[key], value, rel_tol=1e-4, abs_tol=0.5)]
    return official | {"wall_seconds": statistics.median(seconds), "recount_differs": differing}


def measure(args, folder, part, basis, density, width):
    name, rotation, thin_walls = part
    path = os.path.join(args.folder, f"{name}.3mf")
    meshes = by_material(placed(read_3mf(path), rotation, CENTRE))
    stem = os.path.join(folder, f"{name}-{basis}-{density}-{width}")
    project, config = f"{stem}.3mf", f"{stem}.ini"
    write_project(project, meshes)
    with open(config, "w", encoding="utf-8") as file:
        lines = settings(basis, len(meshes), density, thin_walls, width)
        file.writelines(f"{key} = {value}\n" for key, value in lines.items())
    theirs, missing = [], {}
    wanted = VARIANTS if basis == "same" else {"unjoined": []}
    times = {variant: [] for variant in wanted}
    for _ in range(args.runs):
        theirs.append(slice_part(project, config, f"{stem}-prusa.gcode"))
        for variant, more in wanted.items():
            if variant in missing:
                continue
            seconds, reason = plan_part(args.binary, path, rotation,
                                        flags(basis, density, thin_walls) + more,
                                        f"{stem}-{variant}.gcode")
            if seconds is None:
                missing[variant] = reason
            else:
                times[variant].append(seconds)
    slicer = figures(args.binary, f"{stem}-prusa.gcode", theirs)
    variants = {variant: figures(args.binary, f"{stem}-{variant}.gcode", times[variant])
                for variant in wanted if variant not in missing}
    return {"part": name, "width_mm": width, "basis": basis, "density": density, "materials": len(meshes),
            "prusaslicer": slicer, "beadwork": variants, "missing": missing}


RATIOS = [("beads", "beads"), ("infill", "infill beads"), ("travel_mm", "travel"),
          ("retractions", "retractions"), ("filament_mm3", "filament"),
          ("print_seconds", "printing time"), ("wall_seconds", "seconds to slice")]


def ratios(row):
    """Figures of beadwork divided by those of PrusaSlicer, for each variant."""
    def ratio(ours, theirs):
        return None if ours is None or not theirs else ours / theirs

    return {variant: {key: ratio(ours.get(key), row["prusaslicer"].get(key))
                      for key, _ in RATIOS} for variant, ours in row["beadwork"].items()}


def table(rows):
    def number(value, digits=0):
        return "-" if value is None else f"{value:.{digits}f}"

    lines = ["| basis | part | density | program | layers | beads | walls | infill | gap fill "
             "| other | joined | lifts | travel, m | retractions | extruded, m | filament, mm³ "
             "| printing time, s | to slice, s |", "|" + "---|" * 18]
    for row in rows:
        density = f"{row['density']} %" if row["basis"] == "same" else "-"
        for program, got in [("PrusaSlicer", row["prusaslicer"]), *row["beadwork"].items()]:
            mark = " (recount differs: " + ", ".join(got["recount_differs"]) + ")" \
                if got["recount_differs"] else ""
            cells = [number(got.get(key)) for key in ("layers", "beads", "walls", "infill",
                                                      "gap_fill", "other", "joined", "lifts")]
            cells += [number(got["travel_mm"] / 1000, 2), number(got["retractions"]),
                      number(got["extrusion_mm"] / 1000, 2), number(got.get("filament_mm3")),
                      number(got.get("print_seconds")), number(got["wall_seconds"], 2)]
            lines.append(f"| {row['basis']} | {row['part']} | {density} | {program}{mark} | "
                         + " | ".join(cells) + " |")
    with_ratios = [row for row in rows if row["beadwork"]]
    if with_ratios:
        lines += ["", "Ratios, beadwork to PrusaSlicer:", "",
                  "| basis | part | density | program | "
                  + " | ".join(title for _, title in RATIOS) + " |", "|" + "---|" * 11]
        for row in with_ratios:
            for variant, values in row["ratios"].items():
                cells = [number(values[key], 3) for key, _ in RATIOS]
                lines.append(f"| {row['basis']} | {row['part']} | {row['density']} % | {variant} | "
                             + " | ".join(cells) + " |")
    for row in rows:
        for variant, reason in row["missing"].items():
            lines += ["", f"No program: {row['part']}, {row['density']} %, {variant}: {reason}"]
    return "\n".join(lines)


def limits(part, density):
    """Maximum ratio for each figure: title, variant, key, limit."""
    is_hard = part in ("torus", "Bearing", "heartgears")
    joined = 0.38 if density == 20 else 0.48
    return [("infill beads", "unjoined", "infill", 0.75 if is_hard else 1.0),
            ("all beads", "unjoined", "beads", 0.90 if is_hard else 1.0),
            ("joined", "joined", "beads", joined),
            ("travel", "unjoined", "travel_mm", 0.66 if part == "8_extruders" else 0.60),
            ("travel, free", "free", "travel_mm", 0.50),
            ("retractions", "unjoined", "retractions", 0.66 if part == "8_extruders" else 0.60),
            ("time", "unjoined", "print_seconds", 0.97),
            ("time, joined", "joined", "print_seconds", 0.97),
            ("filament", "unjoined", "filament_mm3", 1.03),
            ("filament, joined", "joined", "filament_mm3", 1.03)]


def verdicts(rows):
    """Table of ratios beside their limits."""
    titles = [title for title, *_ in limits("", 20)]
    lines = ["Ratios (and the figures set); misses are bold:", "",
             "| part | density | " + " | ".join(titles) + " |", "|---|---|" + "---|" * len(titles)]
    kept = missed = 0
    for row in rows:
        if row["basis"] != "same" or not row["beadwork"]:
            continue
        cells = []
        for _, variant, key, limit in limits(row["part"], row["density"]):
            ratio = row["ratios"].get(variant, {}).get(key)
            is_kept = ratio is not None and ratio <= limit + 5e-4
            if key == "filament_mm3":
                is_kept = is_kept and ratio >= 0.97 - 5e-4
            kept, missed = kept + is_kept, missed + (not is_kept)
            text = "-" if ratio is None else f"{ratio:.3f}"
            cells.append(f"{text if is_kept else f'**{text}**'} ({limit:.2f})")
        lines.append(f"| {row['part']} | {row['density']} % | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", f"{kept} kept, {missed} missed."])


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", help="the binary beadwork")
    parser.add_argument("folder", help="folder of the 3MF files")
    parser.add_argument("--out", help="folder for projects and G-code; a temporary one by default")
    parser.add_argument("--runs", type=int, default=3, help="runs for the wall-clock time")
    parser.add_argument("--json", help="file for the figures")
    parser.add_argument("--parts", help="names of parts, separated by commas; all by default")
    parser.add_argument("--basis", default="same,defaults", help="same, defaults or both")
    parser.add_argument("--width", help="PrusaSlicer's extrusion widths in mm, separated by commas",
                        default=f"{BEAD_MM + LAYER_MM * (1 - math.pi / 4):.6f},{BEAD_MM}")
    args = parser.parse_args()
    args.width = [float(width) for width in args.width.split(",")]
    args.binary = os.path.abspath(args.binary)
    return args


def main():
    args = arguments()
    folder = args.out or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    help_text = subprocess.run(["prusa-slicer", "--help"], capture_output=True, text=True).stdout
    version = next(line for line in help_text.splitlines() if line.startswith("PrusaSlicer"))
    print(version.split(" based")[0] + "\n")
    names = args.parts.split(",") if args.parts else [name for name, _, _ in PARTS]
    all_rows = []
    for width in args.width:
        rows = []
        for basis in args.basis.split(","):
            for part in PARTS:
                if part[0] not in names:
                    continue
                for density in DENSITIES if basis == "same" else [20]:
                    row = measure(args, folder, part, basis, density, width)
                    rows.append(row | {"ratios": ratios(row)})
                    print(f"{width} {basis} {part[0]} {density}", file=sys.stderr)
        spacing = width - LAYER_MM * (1 - math.pi / 4)
        print(f"\nPrusaSlicer with a width of {width} mm, so a spacing of {spacing:.3f} mm:\n")
        print(table(rows))
        print(f"\n{verdicts(rows)}")
        all_rows += rows
    load = os.getloadavg()
    print(f"\nLoad of the machine at the end: {load[0]:.1f} (1 min), {load[2]:.1f} (15 min).")
    if args.json:
        with open(args.json, "w", encoding="utf-8") as file:
            json.dump({"prusaslicer": version, "runs": args.runs, "load": load,
                       "rows": all_rows}, file, indent=1)


main()
