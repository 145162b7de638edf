"""Unpacks from wheels the files that a build with libtorch needs.

    python3 unpack.py cpu|cuda FOLDER WHEEL...
"""

from __future__ import annotations

import pathlib
import shutil
import sys
import zipfile

# Libraries for the processor: kernels, and the profiling libraries of graphics cards, which
# libtorch_cpu.so links.
LIBRARIES = {
    "libtorch_cpu.so",
    "libtorch.so",
    "libc10.so",
    "libgomp.so.1",
    "libcupti.so.13",
    "libcudart.so.13",
}


def destination(member: str) -> pathlib.PurePosixPath | None:
    """Path of a member of a wheel in the unpacked folder; None if it is not needed."""
    path = pathlib.PurePosixPath(member)
    if path.parts[:2] == ("torch", "include"):
        return path.relative_to("torch")
    # For graphics cards: all libraries loaded at run time, except torch's Python bindings.
    shared = ".so" in path.suffixes and not path.name.startswith(("libtorch_python", "libshm"))
    if path.parent.name == "lib" and (path.name in LIBRARIES or kind == "cuda" and shared):
        return pathlib.PurePosixPath("lib", path.name)
    return None


kind = sys.argv[1]
folder, *wheels = map(pathlib.Path, sys.argv[2:])
for wheel in wheels:
    with zipfile.ZipFile(wheel) as archive:
        for member in archive.infolist():
            where = destination(member.filename)
            if where is None or member.is_dir():
                continue
            target = folder / where
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(member) as source, target.open("wb") as out:
                shutil.copyfileobj(source, out, 1 << 20)
