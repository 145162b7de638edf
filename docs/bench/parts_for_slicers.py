"""Parts of 3MF files as other slicers read them, for the scripts beside this file."""

import math
import re
import xml.etree.ElementTree as ElementTree
import zipfile

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
IDENTITY = (1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0)


def transform(text):
    """The twelve numbers of a transform: three rows of a matrix, and the translation."""
    return tuple(float(word) for word in text.split()) if text else IDENTITY


def apply(m, point):
    x, y, z = point
    return tuple(x * m[axis] + y * m[3 + axis] + z * m[6 + axis] + m[9 + axis]
                 for axis in range(3))


def volume(vertices, triangles):
    """Volume in mm3; negative if the surface is inside out."""
    sixfold = 0.0
    for triangle in triangles:
        a, b, c = (vertices[corner] for corner in triangle)
        sixfold += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]))
    return sixfold / 6


def read_3mf(path):
    """The bodies of the build, as they lie: lists of vertices and of triangles, and a material.

    Reads what SlicerTestModels contains: meshes, components and their transforms.
    Bodies of one base material share it; a body without a material has its own.
    Bodies that are inside out, some of them by a mirroring transform, are turned.
    """
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    tag = f"{{{CORE}}}"
    objects = {element.get("id"): element for element in root.iter(f"{tag}object")}
    bodies = []

    def add(number, matrices):
        element = objects[number]
        mesh = element.find(f"{tag}mesh")
        if mesh is not None:
            vertices = [tuple(float(vertex.get(axis)) for axis in "xyz")
                        for vertex in mesh.iter(f"{tag}vertex")]
            triangles = [tuple(int(triangle.get(corner)) for corner in ("v1", "v2", "v3"))
                         for triangle in mesh.iter(f"{tag}triangle")]
            for matrix in matrices:
                vertices = [apply(matrix, vertex) for vertex in vertices]
            if volume(vertices, triangles) < 0:
                triangles = [(a, c, b) for a, b, c in triangles]
            stated = element.get("pid") and (element.get("pid"), element.get("pindex"))
            bodies.append((vertices, triangles, stated or len(bodies)))
        for component in element.iter(f"{tag}component"):
            add(component.get("objectid"), [transform(component.get("transform"))] + matrices)

    for item in root.iter(f"{tag}item"):
        add(item.get("objectid"), [transform(item.get("transform"))])
    return bodies


def placed(bodies, rotation_x=0.0, centre=(125.0, 105.0)):
    """Bodies turned about x by degrees, centred on a point of the bed, and standing on it."""
    sin, cos = math.sin(math.radians(rotation_x)), math.cos(math.radians(rotation_x))
    turned = [([(x, cos * y - sin * z, sin * y + cos * z) for x, y, z in vertices],
               triangles, material) for vertices, triangles, material in bodies]
    used = [vertices[corner] for vertices, triangles, _ in turned
            for triangle in triangles for corner in triangle]
    low, high = ([pick(point[axis] for point in used) for axis in range(3)] for pick in (min, max))
    move = [centre[0] - (low[0] + high[0]) / 2, centre[1] - (low[1] + high[1]) / 2, -low[2]]
    return [([tuple(p + q for p, q in zip(vertex, move)) for vertex in vertices],
             triangles, material) for vertices, triangles, material in turned]


def by_material(bodies):
    """One mesh for each material, in order of first use: vertices and triangles.

    Equal vertices of a body are merged, as readers of STL do: PrusaSlicer takes the topology of a
    3MF file as it is.
    """
    groups = {}
    for vertices, triangles, material in bodies:
        all_vertices, all_triangles = groups.setdefault(material, ([], []))
        number_of = {}
        for triangle in triangles:
            corners = []
            for corner in triangle:
                point = tuple(round(value, 5) for value in vertices[corner])
                if point not in number_of:
                    number_of[point] = len(all_vertices)
                    all_vertices.append(point)
                corners.append(number_of[point])
            if len(set(corners)) == 3:
                all_triangles.append(tuple(corners))
    return list(groups.values())


def write_project(path, meshes):
    """Writes a project of PrusaSlicer: one object, whose volume N has extruder N."""
    vertices, triangles, volumes = [], [], []
    for number, (own_vertices, own_triangles) in enumerate(meshes, 1):
        first = len(vertices)
        vertices += own_vertices
        begin = len(triangles)
        triangles += [tuple(first + corner for corner in triangle) for triangle in own_triangles]
        volumes.append(
            f'<volume firstid="{begin}" lastid="{len(triangles) - 1}">'
            f'<metadata type="volume" key="name" value="body {number}"/>'
            '<metadata type="volume" key="volume_type" value="ModelPart"/>'
            f'<metadata type="volume" key="extruder" value="{number}"/></volume>')
    text = [f'<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xmlns="{CORE}" '
            'xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06">'
            '<metadata name="slic3rpe:Version3mf">1</metadata>'
            '<resources><object id="1" type="model"><mesh><vertices>']
    text += [f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in vertices]
    text.append("</vertices><triangles>")
    text += [f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles]
    text.append('</triangles></mesh></object></resources>'
                '<build><item objectid="1" printable="1"/></build></model>')
    objects = ('<?xml version="1.0"?><config><object id="1" instances_count="1">'
               '<metadata type="object" key="name" value="part"/>'
               f'{"".join(volumes)}</object></config>')
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
        archive.writestr("Metadata/Slic3r_PE_model.config", objects)
