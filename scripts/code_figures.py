#!/usr/bin/env python3
"""Figures of the code: long functions, long files, lines and files per module, the size of `stages`.

    scripts/code_figures.py [REPOSITORY]            prints them
    scripts/code_figures.py --check [REPOSITORY]    fails where a limit below is passed

Functions are measured by lizard 1.24.3, which `scripts/setup.sh --tests` installs (or `pip install lizard==1.24.3`). Without it
the other figures are printed, and --check ends with 77 where these have no fault: it could not look at all.
"""
import argparse
import glob
import os
import pathlib
import re
import sys

MAX_FUNCTION_LINES = 60
MAX_FILE_LINES = 500
MAX_MODULE_FILES = 45
MAX_STAGES_LINES = 4499
LIZARD = "1.24.3"
UNKNOWN = 77  # what ctest takes for a test that was not run
NUM_LONGEST = 10  # printed

# Functions that may be longer, and why. A pattern is matched against the whole of "module::Function" (tools: "tools::...").
REASONS = [
    (r"shape::SampleField", "three loops over one batch, compiled for wide vectors inside its callers"),
    (r"stages::DescribeRetired", "one line of code per option that there was: a table"),
    (r".*::Describe", "one line of code per option: a table"),
    (r"stages::MakePlan", "the whole chain on one page"),
    (r"tools::Add[A-Z]\w*", "one line of code per option of a command: a table"),
]


def cache_folder():
    return os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")


def module_of(path, root):
    parts = path.relative_to(root).parts
    return parts[2] if parts[:2] == ("src", "deepslam") else parts[0]


def source_files(root):
    files = [f for f in (root / "src" / "deepslam").rglob("*") if f.suffix in {".h", ".cc"}]
    files += [f for f in (root / "tools").rglob("*") if f.suffix in {".h", ".cc"}]
    return sorted(files)


def count_lines(path):
    return path.read_text(encoding="utf-8").count("\n")


def long_functions(files, root):
    """(lines, "module::Function", path:line), longest first; None without lizard."""
    try:
        sys.path += glob.glob(os.path.join(cache_folder(), "deepslam", "python", f"lizard-{LIZARD}"))
        import lizard
    except ImportError:
        return None
    if lizard.version != LIZARD:
        print(f"lizard is {lizard.version}, these figures are of {LIZARD}", file=sys.stderr)
    found = []
    for path in files:
        for function in lizard.analyze_file(str(path)).function_list:
            if function.length > MAX_FUNCTION_LINES:
                name = f"{module_of(path, root)}::{function.name.split('::')[-1]}"
                place = f"{path.relative_to(root)}:{function.start_line}"
                found.append((function.length, name, place))
    return sorted(found, key=lambda row: (-row[0], row[2]))


def reason_for(name):
    return next((reason for pattern, reason in REASONS if re.fullmatch(pattern, name)), None)


def modules_of(files, root):
    """module -> (files, lines)"""
    modules = {}
    for path in files:
        module = module_of(path, root)
        num_files, num_lines = modules.get(module, (0, 0))
        modules[module] = (num_files + 1, num_lines + count_lines(path))
    return modules


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="fail where a limit is passed")
    parser.add_argument("repository", nargs="?", default=".")
    arguments = parser.parse_args()
    root = pathlib.Path(arguments.repository).resolve()
    files = source_files(root)
    if not files:
        print(f"{root}: no sources found", file=sys.stderr)
        return 1
    faults = []

    functions = long_functions(files, root)
    print(f"Functions over {MAX_FUNCTION_LINES} lines")
    if functions is None:
        print(f"  not measured: lizard is not installed (pip install lizard=={LIZARD})")
    for lines, name, place in functions or []:
        reason = reason_for(name)
        print(f"  {lines:5}  {name:45} {place:55} {reason or '-'}")
        if reason is None:
            faults.append(f"{place}: {name} has {lines} lines and no reason in scripts/code_figures.py")

    by_length = sorted(((count_lines(f), f.relative_to(root)) for f in files), key=lambda row: (-row[0], row[1]))
    print(f"\nLongest files (limit {MAX_FILE_LINES})")
    for lines, path in by_length[:NUM_LONGEST]:
        print(f"  {lines:5}  {path}")
    faults += [f"{path}: {lines} lines" for lines, path in by_length if lines > MAX_FILE_LINES]

    modules = modules_of(files, root)
    print(f"\nModules (limit {MAX_MODULE_FILES} files)\n  files  lines  module")
    for module, (num_files, num_lines) in sorted(modules.items()):
        print(f"  {num_files:5}  {num_lines:5}  {module}")
        if num_files > MAX_MODULE_FILES and module != "tools":  # commands, one or two files each
            faults.append(f"module {module}: {num_files} files")
    stages_lines = modules.get("stages", (0, 0))[1]
    if stages_lines > MAX_STAGES_LINES:
        faults.append(f"module stages: {stages_lines} lines, at most {MAX_STAGES_LINES}")
    print(f"  {len(files):5}  {sum(lines for _, lines in modules.values()):5}  all")

    if arguments.check:
        print()
        for fault in faults:
            print(fault)
        print(f"{len(faults)} faults")
        if faults:
            return 1
        return UNKNOWN if functions is None else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
