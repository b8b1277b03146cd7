#!/usr/bin/env python3
"""`deepslam priors render`: same seed, same bytes, on one thread and on two; bad arguments say what is wrong."""
import ast
import hashlib
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]


def render(*arguments):
    return subprocess.run([PROGRAM, "priors", "render", "--no-catalogue", *map(str, arguments)], capture_output=True,
                          text=True, check=False)


def made(folder, *arguments):
    outcome = render("-o", folder, *arguments)
    assert outcome.returncode == 0, outcome.stderr
    return {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in sorted(folder.iterdir())}


def read_npy(file):
    """Header as NumPy documents it, and the values' bytes."""
    content = file.read_bytes()
    assert content[:8] == b"\x93NUMPY\x01\x00", file
    length = struct.unpack("<H", content[8:10])[0]
    assert (10 + length) % 64 == 0 and content[9 + length:10 + length] == b"\n", file
    head = ast.literal_eval(content[10:10 + length].decode())
    values = content[10 + length:]
    assert len(values) == math.prod(head["shape"]) * int(head["descr"][2]), (file, head)
    return head, values


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        few = ("--designs", 5, "--views", 3, "--class", "chair", "--class", "table", "--seed", 9)
        one = made(folder / "one", *few, "--threads", 1)
        two = made(folder / "two", *few, "--threads", 2)
        assert one == two, "bytes depend on the number of threads"
        other = made(folder / "other", *few[:-1], 10, "--threads", 2)
        assert one["colour.npy"] != other["colour.npy"], "the seed makes no difference"
        # Designs do not depend on how many are asked for.
        rest = made(folder / "rest", "--designs", 2, "--first-design", 3, "--views", 3, "--class", "chair", "--seed", 9)
        _, all_voxels = read_npy(folder / "one" / "voxels.npy")
        _, last_voxels = read_npy(folder / "rest" / "voxels.npy")
        assert all_voxels[3 * 32768:5 * 32768] == last_voxels and rest

        head = json.loads((folder / "one" / "training_views.json").read_text(encoding="utf-8"))
        assert head["format"] == "deepslam/training_views" and len(head["models"]) == 10
        assert {m["split"] for m in head["models"]} <= {"train", "validate"}
        for array, entry in head["arrays"].items():
            found, _ = read_npy(folder / "one" / f"{array}.npy")
            assert list(found["shape"]) == entry["shape"] and found["descr"] == entry["dtype"]
        _, model = read_npy(folder / "one" / "model.npy")
        assert list(struct.unpack("<30i", model)) == [n // 3 for n in range(30)]
        assert any(all_voxels) and not (folder / "one.partial").exists()

        sheet = render("--designs", 3, "--rows", 2, "--sheet", folder / "sheet.png")
        assert sheet.returncode == 0 and (folder / "sheet.png").read_bytes()[:4] == b"\x89PNG", sheet.stderr

        for arguments, code, part in (
                (("-o", folder / "one", "--designs", 1), 2, "not an empty folder"),
                (("--designs", 1), 2, "one of --output"),
                (("-o", folder / "x", "--designs", 0), 2, "no model"),
                (("-o", folder / "x", "--class", "lamp"), 2, "lamp"),
                (("-o", folder / "x", "--withheld-list", folder / "none.yaml", "--meshes", folder), 3, "none.yaml")):
            outcome = render(*arguments)
            assert outcome.returncode == code and part in outcome.stderr, (arguments, outcome)

        look = subprocess.run([PROGRAM, "priors", "look", folder / "none", folder / "one", "--sheet", folder / "look.png"],
                              capture_output=True, text=True, check=False)
        assert look.returncode == 3 and "one" in look.stderr and not (folder / "look.png").exists(), look
    print("priors command: fine")


if __name__ == "__main__":
    main()
