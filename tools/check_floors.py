#!/usr/bin/env python3
"""Walks the includes of all sources and proves that no floor includes one above it.

The table is that of ARCHITECTURE.md. Exits with 1 and a line for each include that is not allowed.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# floor: (folder, floors that it may include)
FLOORS = {
    "core": ("core", []),
    "hierarchy": ("hierarchy", ["core"]),
    "fields": ("extractor/fields", ["core"]),
    "raster": ("extractor/raster", ["core"]),
    "volume": ("extractor/volume", ["core", "fields", "raster"]),
    "elevation": ("extractor/elevation", ["core", "fields", "raster"]),
    "extractor": ("extractor/mesh", ["core", "hierarchy", "fields"]),
    "surface": ("engine/surface", ["core", "hierarchy", "fields", "extractor"]),
    "voxels": ("engine/voxels", ["core", "fields"]),
    "exchange": ("engine/exchange", ["core", "raster", "surface", "voxels"]),
    "tiles": (
        "engine/tiles",
        ["core", "hierarchy", "fields", "extractor", "surface", "exchange"],
    ),
    "sources": (
        "engine/sources",
        ["core", "hierarchy", "fields", "volume", "elevation", "voxels", "exchange"],
    ),
    "charts": ("charts", []),
    "gpu": ("engine/gpu", ["core"]),
    "render": (
        "engine/render",
        ["core", "hierarchy", "extractor", "surface", "voxels", "gpu", "shaders"],
    ),
    "bench": (
        "bench",
        [
            "core", "hierarchy", "fields", "volume", "extractor", "surface", "voxels", "exchange",
            "charts", "gpu", "render", "server",
        ],
    ),
    "server": (
        "server",
        [
            "core", "hierarchy", "fields", "volume", "elevation", "extractor", "surface", "voxels",
            "exchange", "sources", "gpu", "render",
        ],
    ),
}
# A library that only some places may name: pattern of the include, folders or files allowed
CONFINED = [
    (r"vtk", ["bench/peers/FlyingEdges.cpp"]),
    (r"embree3/", ["bench/peers/EmbreeRays.cpp"]),
    (r"tbb/", ["core/src/jobs"]),
    (
        r"openvdb/",
        [
            "extractor/volume/src/GridField.h",
            "extractor/volume/src/SparseBounds.h",
            "extractor/volume/src/SparsePyramid.h",
            "extractor/volume/src/MeshToVdb.cpp", "extractor/volume/src/VdbReader.cpp",
            "bench/peers/MeshToVolume.cpp", "bench/peers/VolumeToMesh.cpp",
        ],
    ),
    (r"itk", ["extractor/volume/src/ItkReader.cpp"]),
    (r"vulkan/", ["engine/gpu", "engine/render"]),
    (
        r"hwy/",
        [
            "extractor/fields/src",
            "extractor/volume/src",
            "extractor/elevation/src",
            "extractor/mesh/src",
            "engine/surface/src",
            "engine/voxels/src",
            "bench/src",
        ],
    ),
    (r"boost/", ["server/src/http"]),
    (r"meshoptimizer", ["server/src/stream/CellCodec.cpp"]),
    (r"prometheus/", ["server/src/Metrics.cpp"]),
    (r"spdlog/", ["server/src/Log.cpp"]),
    (r"tiff", ["extractor/raster/src/TiffFile.cpp"]),
]
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.M)


def main() -> int:
    wrong = []
    checked = 0
    for floor, (folder, below) in FLOORS.items():
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            checked += 1
            name = path.relative_to(ROOT).as_posix()
            for include in INCLUDE.findall(path.read_text()):
                if include.startswith("isofront/"):
                    other = include.split("/")[1]
                    if other != floor and other not in below:
                        wrong.append(f"{name}: {floor} may not include {include}")
                for pattern, places in CONFINED:
                    if re.match(pattern, include) and not any(name.startswith(p) for p in places):
                        wrong.append(f"{name}: only {', '.join(places)} may include {include}")
    if checked < 50:
        wrong.append(f"only {checked} files found: is the table of folders still true?")
    print("\n".join(wrong) if wrong else f"{checked} files include nothing from above")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
