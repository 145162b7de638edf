#!/usr/bin/env python3
"""Compares the filament of painted projects between beadwork and PrusaSlicer.

    docs/bench/painted_slicer.py BEADWORK [FOLDER]

Writes four painted projects to FOLDER (a temporary one by default), plans them with BEADWORK,
slices them with `prusa-slicer` (Debian's package), and prints the volume of each tool.
Exit code 1 if a volume differs by more than 3 %.

Both programs print the same layers, all of them solid: PrusaSlicer with one perimeter, 100 %
infill, and without a wipe tower, a skirt or retraction.
Four top and bottom layers give colours of horizontal faces the depth of 1 mm that they have in
beadwork.
"""

import json
import math
import os
import re
import subprocess
import sys
import tempfile
import zipfile

LAYER_MM, WIDTH_MM, DIAMETER_MM = 0.25, 0.5, 1.75
COLOURS = ["#FF0000", "#00FF00", "#0000FF", "#FFFF00"]
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
SLIC3R = "http://schemas.slic3r.org/3mf/2017/06"


def prism(outline, height):
    """Vertices and triangles of an outline extruded along z."""
    n = len(outline)
    vertices = [(x, y, 0.0) for x, y in outline] + [(x, y, height) for x, y in outline]
    triangles = []
    for i in range(n):
        j = (i + 1) % n
        triangles += [(i, j, n + j), (i, n + j, n + i)]
    for i in range(1, n - 1):
        triangles += [(0, i + 1, i), (n, n + i, n + i + 1)]
    return vertices, triangles


def middle(a, b):
    return tuple((p + q) / 2 for p, q in zip(a, b))


def state_digits(state):
    return f"{state << 2:X}" if state < 3 else f"{state - 3:X}C"


def paint(corners, colour, depth):
    """The string of a triangle whose points have the filament `colour(x, y, z)`, to a depth."""
    a, b, c = corners
    ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
    centre = tuple(sum(axis) / 3 for axis in zip(a, b, c))
    around = [tuple(0.98 * p + 0.02 * q for p, q in zip(point, centre))
              for point in (a, b, c, ab, bc, ca)]
    states = {colour(*point) for point in around + [centre]}
    if depth == 0 or len(states) == 1:
        return state_digits(colour(*centre))
    children = [(a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca)]
    return "".join(paint(child, colour, depth - 1) for child in children) + "3"


def projects():
    """Name, mesh, filament of points of the surface, and depth of the paint."""
    box = [(0, 0), (40, 0), (40, 30), (0, 30)]
    # No layer is cut exactly where triangles of the paint end: heights are no round numbers.
    yield "halves", prism(box, 9.87), lambda x, y, z: 1 if x < 17 else 2, 6
    disc = [(20 + 18 * math.cos(math.tau * i / 24), 20 + 18 * math.sin(math.tau * i / 24))
            for i in range(24)]
    yield "sectors", prism(disc, 7.87), lambda x, y, z: (
        1 + int((math.atan2(y - 20, x - 20) + math.pi + 0.1) / math.tau * 3) % 3), 5
    yield "bands", prism(box, 9.87), lambda x, y, z: 1 if x < 11 else 2 if x < 29 else 3, 6
    yield "stripes", prism(box, 19.87), lambda x, y, z: 1 + int((x + y + 2 * z) / 18) % 4, 6


def settings(count):
    """The settings of PrusaSlicer, for a number of extruders."""
    same = lambda value: ",".join([str(value)] * count)
    widths = ["", "first_layer_", "perimeter_", "external_perimeter_", "infill_", "solid_infill_",
              "top_infill_", "support_material_"]
    lines = {f"{name}extrusion_width": WIDTH_MM for name in widths}
    lines |= {
        "nozzle_diameter": same(WIDTH_MM), "filament_diameter": same(DIAMETER_MM),
        "extruder_colour": ";".join(COLOURS[:count]), "filament_colour": ";".join(COLOURS[:count]),
        "temperature": same(210), "first_layer_temperature": same(210),
        "extrusion_multiplier": same(1), "retract_length": same(0),
        "retract_length_toolchange": same(0), "layer_height": LAYER_MM,
        "first_layer_height": LAYER_MM, "perimeters": 1, "fill_density": "100%",
        "fill_pattern": "rectilinear", "top_solid_layers": 4, "bottom_solid_layers": 4,
        "skirts": 0, "brim_width": 0, "wipe_tower": 0, "single_extruder_multi_material": 0,
        "elefant_foot_compensation": 0, "bed_shape": "0x0,250x0,250x210,0x210",
        "gcode_flavor": "marlin2", "use_relative_e_distances": 1, "layer_gcode": "G92 E0",
    }
    return lines


def write(path, mesh, colour, depth, count):
    vertices, triangles = mesh
    text = [f'<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xmlns="{CORE}" '
            f'xmlns:slic3rpe="{SLIC3R}"><metadata name="slic3rpe:Version3mf">1</metadata>'
            '<metadata name="slic3rpe:MmPaintingVersion">1</metadata>'
            '<resources><object id="1" type="model"><mesh><vertices>']
    text += [f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in vertices]
    text.append("</vertices><triangles>")
    for triangle in triangles:
        corners = [vertices[corner] for corner in triangle]
        digits = paint(corners, colour, depth)
        a, b, c = triangle
        text.append(f'<triangle v1="{a}" v2="{b}" v3="{c}" slic3rpe:mmu_segmentation="{digits}"/>')
    text.append('</triangles></mesh></object></resources><build><item objectid="1" '
                'transform="1 0 0 0 1 0 0 0 1 100 80 0" printable="1"/></build></model>')
    config = "".join(f"; {key} = {value}\n" for key, value in settings(count).items())
    objects = ('<?xml version="1.0"?><config><object id="1" instances_count="1">'
               '<metadata type="object" key="name" value="part"/>'
               f'<volume firstid="0" lastid="{len(triangles) - 1}"><metadata type="volume" '
               'key="volume_type" value="ModelPart"/></volume></object></config>')
    rels = ('<?xml version="1.0"?><Relationships '
            'xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
            '<Relationship Target="/3D/3dmodel.model" Id="rel-1" '
            'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
    types = ('<?xml version="1.0"?><Types '
             'xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
             '<Default Extension="rels" '
             'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
             '<Default Extension="model" '
             'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", types)
        archive.writestr("_rels/.rels", rels)
        archive.writestr("3D/3dmodel.model", "".join(text))
        archive.writestr("Metadata/Slic3r_PE.config", config)
        archive.writestr("Metadata/Slic3r_PE_model.config", objects)


def of_beadwork(binary, path):
    """Volume in mm3 of each tool, by the number of the filament."""
    run = subprocess.run(
        [binary, "plan", path, "--objective", "tools", "--json", "--purge", "0", "--tower", "none",
         "--bead", str(WIDTH_MM), "--layer", str(LAYER_MM)],
        capture_output=True, text=True, check=True)
    plan = json.loads(run.stdout)
    numbers = [int(re.match(r"filament (\d+)", name)[1]) for name in plan["materials"]]
    return {number: tool["volume_mm3"] for number, tool in zip(numbers, plan["tools"])}


def of_slicer(path, gcode):
    subprocess.run(["prusa-slicer", "--export-gcode", "--output", gcode, path],
                   capture_output=True, text=True, check=True)
    text = open(gcode, encoding="utf-8").read()
    length = re.search(r"; filament used \[mm\] = (.*)", text)
    area = math.pi * (DIAMETER_MM / 2) ** 2
    lengths = [float(word) for word in length[1].split(",")]
    return {number: mm * area for number, mm in enumerate(lengths, 1) if mm > 0}


def main():
    binary = os.path.abspath(sys.argv[1])
    folder = sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp()
    lines = subprocess.run(["prusa-slicer", "--help"], capture_output=True, text=True).stdout
    print(next(line for line in lines.splitlines() if line.startswith("PrusaSlicer")))
    print("| project | filament | beadwork, mm³ | PrusaSlicer, mm³ | difference, % |")
    print("|---|---|---|---|---|")
    worst = 0.0
    for name, mesh, colour, depth in projects():
        path = os.path.join(folder, f"{name}.3mf")
        write(path, mesh, colour, depth, 4)
        ours = of_beadwork(binary, path)
        theirs = of_slicer(path, os.path.join(folder, f"{name}.gcode"))
        for number in sorted(ours | theirs):
            own, other = ours.get(number, 0.0), theirs.get(number, 0.0)
            share = 100 * (own - other) / max(own, other)
            worst = max(worst, abs(share))
            print(f"| {name} | {number} | {own:.0f} | {other:.0f} | {share:+.2f} |")
    print(f"largest difference: {worst:.2f} %")
    sys.exit(worst > 3.0)


main()
