#!/usr/bin/env python3
"""Packs what a training on another machine needs, unpacks it there, and says what that machine lacks (scripts/train/gpu.sh).

    gpu_kit.py pack CLASS --program DEEPSLAM --out FILE.tar.xz [--meshes FOLDER] [--limit-mib 64]
    gpu_kit.py unpack FILE.tar.xz --out FOLDER
    gpu_kit.py check [--cpu]

The archive holds the products' meshes (deepslam priors pack), the program that renders views of them (deepslam-views) with
every library it loads, the C library and its loader among them: nothing of ours has to be installed there. Python with
PyTorch for CUDA has to be there; it does not fit.
"""
import argparse
import importlib
import importlib.metadata
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
FORMAT, VERSION = "deepslam/training_kit", 1
LOADER = "ld-linux-x86-64.so.2"
MIB = 2**20
NO_GPU = ("PyTorch {} sees no CUDA device here. Run this where there is one (nvidia-smi lists it), with a PyTorch built for CUDA; "
          "--cpu tries everything on the processor, with small batches")
# Imported name -> package, as in requirements.txt.
PACKAGES = {"torch": "torch", "numpy": "numpy", "scipy": "scipy", "onnx": "onnx", "onnxruntime": "onnxruntime",
            "matplotlib": "matplotlib", "yaml": "pyyaml"}


def libraries_of(program):
    """Files of the libraries that a program loads, by the name they are looked for under."""
    listed = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=True).stdout
    if "not found" in listed:
        raise SystemExit(f"{program}: {re.findall(r'(.*) => not found', listed)} are not found; build it on this machine")
    found = {name: pathlib.Path(path) for name, path in re.findall(r"(\S+) => (/\S+)", listed)}
    loader = re.search(r"(/\S*ld-linux\S*)", listed)
    if not loader:
        raise SystemExit(f"{program}: its loader is not found in what ldd says of it")
    return dict(found, **{LOADER: pathlib.Path(loader.group(1))})


def program_of(kit):
    """The command that starts the renderer of an unpacked kit, whatever C library the machine has."""
    return [str(kit / "lib" / LOADER), "--library-path", str(kit / "lib"), str(kit / "bin/deepslam-views")]


def tracked_bytes(folder):
    """What a copy of the working tree weighs without ignored files."""
    listed = subprocess.run(["git", "-C", str(folder), "ls-files", "-z"], capture_output=True, check=False)
    files = [folder / name.decode() for name in listed.stdout.split(b"\0") if name]
    return sum(file.stat().st_size for file in files if file.is_file())


def check_size(archive, tree_bytes, limit_mib):
    """How large all is together; ends where that is over the limit."""
    size = archive.stat().st_size
    line = f"{archive}: {size / MIB:.1f} MiB, with the working tree's files {(size + tree_bytes) / MIB:.1f} MiB"
    if size + tree_bytes > limit_mib * MIB:
        raise SystemExit(f"{line}, more than {limit_mib} MiB; leave --meshes out, or raise --limit-mib if more can be carried")
    print(line)


def copy_program(program, folder):
    (folder / "bin").mkdir()
    (folder / "lib").mkdir()
    subprocess.run(["strip", "-o", str(folder / "bin/deepslam-views"), str(program)], check=True)
    for name, file in libraries_of(program).items():
        shutil.copy(file, folder / "lib" / name)


def pack(arguments):
    views = arguments.program.parent / "deepslam-views"
    if not views.exists():
        raise SystemExit(f"{views} is missing; build target deepslam_views")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        copy_program(views, folder)
        meshes = [part for place in arguments.meshes for part in ("--meshes", place)]
        outcome = subprocess.run([str(arguments.program), "priors", "pack", "--class", arguments.class_name, *meshes,
                                  "-o", str(folder / "models.pack")], cwd=HERE.parents[1], check=False)
        if outcome.returncode:
            raise SystemExit(outcome.returncode)
        head = {"format": FORMAT, "version": VERSION, "class": arguments.class_name}
        (folder / "kit.json").write_text(json.dumps(head), encoding="utf-8")
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        aside = arguments.out.with_name(arguments.out.name + ".partial")
        with tarfile.open(aside, "w:xz") as tar:
            for file in sorted(folder.rglob("*")):
                tar.add(file, file.relative_to(folder), recursive=False)
    aside.replace(arguments.out)
    check_size(arguments.out, tracked_bytes(HERE.parents[1]), arguments.limit_mib)


def head_of(folder, class_name=None):
    try:
        head = json.loads((folder / "kit.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise SystemExit(f"{folder}: no training kit ({fault}); make one with scripts/train/gpu.sh pack CLASS") from None
    if head.get("format") != FORMAT or head.get("version") != VERSION:
        raise SystemExit(f"{folder}: {head.get('format')} of version {head.get('version')}, wanted {FORMAT} of version {VERSION}; pack it anew")
    if class_name and head.get("class") != class_name:
        raise SystemExit(f"{folder}: a kit for {head.get('class')}, not for {class_name}")
    return head


def unpack(arguments):
    if not arguments.archive.exists():
        raise SystemExit(f"{arguments.archive} is missing; make it with scripts/train/gpu.sh pack CLASS where the catalogues are")
    aside = arguments.out.with_name(arguments.out.name + ".partial")
    shutil.rmtree(aside, ignore_errors=True)
    try:
        with tarfile.open(arguments.archive, "r:xz") as tar:
            tar.extractall(aside, filter="data")
    except (tarfile.TarError, EOFError, OSError) as fault:
        raise SystemExit(f"{arguments.archive}: cannot be unpacked ({fault}); pack it anew") from None
    head_of(aside, arguments.class_name)
    shutil.rmtree(arguments.out, ignore_errors=True)
    aside.rename(arguments.out)
    runs = subprocess.run([*program_of(arguments.out), "--help"], capture_output=True, text=True, check=False)
    if runs.returncode:
        raise SystemExit(f"{arguments.out}: the renderer does not run here: {(runs.stderr or runs.stdout).strip()[-300:]}")


def check(arguments):
    """Ends with what is missing, all of it."""
    missing = []
    for module, package in PACKAGES.items():
        try:
            importlib.import_module(module)
        except ImportError as fault:
            missing.append(f"{package} ({fault})")
    if missing:
        raise SystemExit(f"{sys.executable} lacks {', '.join(missing)}. Name a Python that has them by PYTHON=..., or install "
                         f"scripts/train/requirements.txt")
    versions = ", ".join(f"{package} {importlib.metadata.version(package)}" for package in PACKAGES.values())
    import torch
    if arguments.cpu:
        print(f"{versions}; on the processor")
        return
    if not torch.cuda.is_available():
        raise SystemExit(NO_GPU.format(torch.__version__))
    memory = torch.cuda.get_device_properties(0).total_memory / 2**30
    print(f"{versions}; {torch.cuda.get_device_name(0)}, {memory:.0f} GiB, bf16 {torch.cuda.is_bf16_supported()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    packs = commands.add_parser("pack")
    packs.add_argument("class_name", metavar="CLASS")
    packs.add_argument("--program", type=pathlib.Path, required=True)
    packs.add_argument("--meshes", action="append", default=[])
    packs.add_argument("--limit-mib", type=float, default=64)
    packs.add_argument("--out", type=pathlib.Path, required=True)
    packs.set_defaults(run=pack)
    unpacks = commands.add_parser("unpack")
    unpacks.add_argument("archive", type=pathlib.Path)
    unpacks.add_argument("--class", dest="class_name")
    unpacks.add_argument("--out", type=pathlib.Path, required=True)
    unpacks.set_defaults(run=unpack)
    checks = commands.add_parser("check")
    checks.add_argument("--cpu", action="store_true")
    checks.set_defaults(run=check)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
