#!/usr/bin/env python3
"""Checks which module includes which, and that heavy libraries stay in the .cc files that may hold them.

The table below is the structure of the project; docs/architecture.md draws it. Run by ctest:
    scripts/check_layers.py [REPOSITORY]
"""
import pathlib
import re
import sys

VOCABULARY = {"core", "geometry", "frames", "scene", "shape"}
ALGORITHM = VOCABULARY
MODULES = {
    "core": set(),
    "geometry": {"core"},
    "frames": {"core", "geometry"},
    "scene": {"core", "geometry", "frames"},
    "shape": {"core", "geometry", "frames", "scene"},
    # image files in memory to pixels and back; the decoder of videos, a module that is loaded and not linked
    "image_codec": {"core"},
    "video": set(),
    # files in, files out
    "dataset": VOCABULARY | {"image_codec", "video"},
    "formats": VOCABULARY | {"dataset"},
    "layouts": VOCABULARY | {"image_codec", "dataset", "formats"},
    "convert": VOCABULARY | {"image_codec", "dataset", "formats"},
    "storage": {"core"},
    "library": VOCABULARY,
    # text or bytes to values and back
    "artifact": VOCABULARY,
    "class_table": VOCABULARY,
    # algorithms: value in, value out; none knows another, but for tracking, which goes from frame to frame by alignment
    "alignment": ALGORITHM,
    "tracking": ALGORITHM | {"alignment"},
    "ground": ALGORITHM,
    "detect": ALGORITHM,
    "segment": ALGORITHM,
    "associate": ALGORITHM,
    "instances": ALGORITHM,
    "observe": ALGORITHM,
    "propose": ALGORITHM,
    "registration": ALGORITHM,
    "select": ALGORITHM,
    "refine": ALGORITHM,
    "loop": ALGORITHM,
    "graph": ALGORITHM,
    "overrides": ALGORITHM,
    "mesh": ALGORITHM,
    "fuse": ALGORITHM,
    "layout": ALGORITHM,
    "gltf": ALGORITHM,
    "usd": ALGORITHM,
    "convex": ALGORITHM,
    "simulator": ALGORITHM,
    "render": ALGORITHM,
    "eval": ALGORITHM,
    "report": ALGORITHM | {"image_codec"},
    "synth": VOCABULARY | {"image_codec", "render"},
    "furniture": {"core", "geometry", "scene"},
    # training views of the shape networks: drawn by the ray caster, cut out as the networks see objects
    "priors": VOCABULARY | {"render", "furniture", "propose"},
    # composition: joins algorithms, in memory
    "mapping": VOCABULARY | {"alignment", "tracking", "loop", "graph"},
    "modelling": VOCABULARY | {"observe", "propose", "registration", "select", "refine", "loop", "graph", "mapping"},
    "presentation": VOCABULARY | {"mesh", "fuse", "layout", "gltf", "usd", "convex", "simulator", "render", "report"},
    # control
    "pipeline": VOCABULARY | {"artifact", "storage"},
}
# composition: joins algorithms on interfaces, in memory
MODULES["discovery"] = ALGORITHM | {"instances", "associate", "segment"}
MODULES["stages"] = set(MODULES) - {"synth", "furniture", "priors", "video"}
# Many runs: lists, plans, states, processes, other schedulers. It knows nothing of what a run does.
MODULES["batch"] = {"core", "artifact", "storage"}
TOOLS = set(MODULES) - {"video"}

# Modules that may touch the disk.
FILE_MODULES = {"dataset", "formats", "layouts", "convert", "storage", "library", "pipeline", "stages", "batch"}

# Third-party include prefix -> modules whose .cc files may include it. Never in a header.
FENCES = {
    "opencv2/": {"video", "detect", "loop", "report", "synth"},
    "ceres/": {"graph", "registration", "ground", "refine"},
    "CGAL/": {"mesh", "layout", "convex"},
    "boost/": {"layout"},
    "OpenMesh/": {"mesh", "gltf"},
    "draco/": {"gltf"},
    "tiny_gltf.h": {"gltf"},
    "tiny_obj_loader.h": {"library", "synth"},
    "open3d/": {"fuse"},
    "Open3D/": {"fuse"},
    "meshoptimizer.h": {"fuse"},
    "embree3/": {"render"},
    "onnxruntime": {"detect", "propose"},
    "google/protobuf": set(),
    "onnx_excerpt.pb.h": {"detect"},
    "nlohmann/": {"artifact", "gltf", "pipeline", "presentation", "report", "stages", "eval", "library", "detect", "tools",
                  "layouts", "convert"},
    "png.h": {"image_codec"},
    "jpeglib.h": {"image_codec"},
    "OpenEXR/": {"image_codec"},
    "tiffio.h": {"image_codec"},
    "sqlite3.h": {"formats"},
    "webp/": {"image_codec"},
    "zlib.h": {"formats", "image_codec"},
    "blosc.h": {"dataset"},
    "yaml-cpp/": {"dataset", "layouts", "pipeline", "synth", "artifact", "class_table"},
    "CLI/": {"tools"},
    "spdlog/": {"tools", "pipeline"},
    "nanoflann.hpp": {"associate", "shape", "registration", "loop", "eval", "mesh", "select", "segment", "observe"},
    "tbb/": {"core"},
    "openssl/": {"core"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]', re.MULTILINE)


def check_file(path, module, allowed, faults):
    text = path.read_text(encoding="utf-8")
    header = path.suffix == ".h"
    for name in INCLUDE.findall(text):
        if name.startswith("deepslam/"):
            target = name.split("/")[1]
            if target != module and target not in allowed:
                faults.append(f"{path}: module {module} may not include module {target} ({name})")
            continue
        if name == "fstream" and module not in FILE_MODULES | {"tools"}:
            faults.append(f"{path}: module {module} may not touch the disk ({name})")
        for prefix, modules in FENCES.items():
            if name.startswith(prefix):
                if header:
                    faults.append(f"{path}: {name} may not stand in a header")
                elif module not in modules:
                    faults.append(f"{path}: {name} is fenced off from module {module}")


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    faults = []
    count = 0
    source = root / "src" / "deepslam"
    for folder in sorted(p for p in source.iterdir() if p.is_dir()):
        files = sorted(f for f in folder.rglob("*") if f.suffix in {".h", ".cc"})
        if files and folder.name not in MODULES:
            faults.append(f"{folder}: not a module of the table in scripts/check_layers.py")
            continue
        for path in files:
            count += 1
            check_file(path, folder.name, MODULES[folder.name], faults)
    for path in sorted((root / "tools").glob("*.[hc]*")):
        if path.suffix in {".h", ".cc"}:
            count += 1
            check_file(path, "tools", TOOLS, faults)
    if count == 0:
        faults.append(f"{root}: no sources found")
    for fault in faults:
        print(fault)
    print(f"{count} files, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
