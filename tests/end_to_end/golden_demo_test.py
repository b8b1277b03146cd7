#!/usr/bin/env python3
"""The demo's run against a recorded one, by what it means: camera poses, objects, scores. Builds by other compilers, and changes
that ought to change nothing, have to stay within the tolerances below.

    golden_demo_test.py DEEPSLAM REPOSITORY [--record] [--workspace DIR]

Renders configs/scenes/demo_room.yaml and runs it with default options; --workspace names a finished run instead. --record writes
tests/end_to_end/golden_demo.json anew: for changes that are meant, with the reason in the commit.
Exit 77: catalogues, furniture library or weights are not installed.
"""
import argparse
import copy
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import captures
import rigid

SKIPPED = 77
# What two good runs may differ by: tracking repeats to millimetres, so its bounds are those of a voxel of the fused room and of the
# angle that moves a point 2 m away by as much; an object may settle in a neighbouring minimum of its depth's noise.
POSITION_M, ROTATION_DEG = 0.02, 0.6
CENTRE_M, SIZE_M, HEADING_DEG, CONFIDENCE = 0.05, 0.05, 10.0, 0.1
GROUND_M, GROUND_DEG = 0.02, 0.6


def angle_deg(a, b):
    """Between two rotations as quaternions x y z w."""
    dot = abs(sum(p * q for p, q in zip(a, b)) / (math.hypot(*a) * math.hypot(*b)))
    return math.degrees(2 * math.acos(min(1.0, dot)))


def heading_deg(thing):
    rotation = rigid.rotation_of(thing["rotation_xyzw"])
    return math.degrees(math.atan2(rotation[1][0], rotation[0][0]))


def heading_gap_deg(a, b, fold):
    """Of things that look alike after a turn by 360 / fold degrees."""
    period = 360 / fold
    gap = abs(heading_deg(a) - heading_deg(b)) % period
    return min(gap, period - gap)


def read_poses(file):
    poses = {}
    for line in file.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            time, *numbers = line.split()
            poses[f"{float(time):.3f}"] = [round(float(number), 5) for number in numbers]
    return poses


def summary_of(workspace):
    """What is compared, of a finished run. Poses are those of the keyframes, in the final world."""
    found = json.loads((workspace / "export" / "map.json").read_text())
    objects = [{"class": o["class"], "confidence": o["confidence"], "source": o["source"], "size_m": o["size_m"],
                "translation_m": o["world_from_object"]["translation_m"],
                "rotation_xyzw": o["world_from_object"]["rotation_xyzw"]} for o in found["objects"]]
    return {"verdict": found["verdict"], "ground": found["ground_world"], "objects": objects,
            "keyframes": read_poses(workspace / "optimize" / "keyframes.tum"),
            "frames": read_poses(workspace / "optimize" / "trajectory.tum")}


def without_frames(summary):
    """As recorded: every frame's pose is compared at the recorded keyframes' times."""
    return {key: value for key, value in summary.items() if key != "frames"}


def pose_faults(golden, found):
    for time, pose in golden["keyframes"].items():
        if time not in found["frames"]:
            yield f"no pose at {time} s"
            continue
        other = found["frames"][time]
        gap = math.dist(pose[:3], other[:3])
        turn = angle_deg(pose[3:], other[3:])
        if gap > POSITION_M or turn > ROTATION_DEG:
            yield f"camera at {time} s is {1000 * gap:.0f} mm and {turn:.2f} deg from where it was"


def object_faults(golden, found):
    left = list(found["objects"])
    for was in golden["objects"]:
        alike = [o for o in left if o["class"] == was["class"]]
        if not alike:
            yield f"a {was['class']} is missing that stood at {was['translation_m']}"
            continue
        now = min(alike, key=lambda o: math.dist(o["translation_m"], was["translation_m"]))
        left.remove(now)
        name = f"{was['class']} at {was['translation_m']}"
        if (gap := math.dist(now["translation_m"], was["translation_m"])) > CENTRE_M:
            yield f"{name} moved by {1000 * gap:.0f} mm"
        # A table turned by a right angle has its sides exchanged: heading first, then sides.
        fold = 2 if was["class"] == "table" else 1
        if (turn := heading_gap_deg(was, now, fold)) > HEADING_DEG:
            yield f"{name} turned by {turn:.0f} deg"
        if (worst := max(abs(a - b) for a, b in zip(was["size_m"], now["size_m"]))) > SIZE_M:
            yield f"{name} has another size, by {1000 * worst:.0f} mm"
        if (gap := abs(was["confidence"] - now["confidence"])) > CONFIDENCE:
            yield f"{name} has confidence {now['confidence']:.2f}, it had {was['confidence']:.2f}"
    for more in left:
        yield f"a {more['class']} at {more['translation_m']} is new"


def ground_faults(golden, found):
    was, now = golden["ground"], found["ground"]
    if abs(was["d_m"] - now["d_m"]) > GROUND_M:
        yield f"the ground is at {now['d_m']} m, it was at {was['d_m']} m"
    dot = sum(a * b for a, b in zip(was["normal"], now["normal"]))
    if (tilt := math.degrees(math.acos(max(-1.0, min(1.0, dot))))) > GROUND_DEG:
        yield f"the ground is tilted by {tilt:.2f} deg"


def faults(golden, found):
    if golden["verdict"] != found["verdict"]:
        yield f"verdict is {found['verdict']}, it was {golden['verdict']}"
    yield from ground_faults(golden, found)
    yield from pose_faults(golden, found)
    yield from object_faults(golden, found)


def check_that_changes_are_seen(golden):
    """The comparison itself: equal to itself, and a fault for each thing that is changed."""
    found = {**golden, "frames": golden["keyframes"]}
    assert not list(faults(golden, found)), "a run differs from itself"

    def changed(change, *words):
        other = copy.deepcopy(found)
        change(other)
        said = list(faults(golden, other))
        assert any(all(word in fault for word in words) for fault in said), f"{words} was not said, but {said}"
    time = list(golden["keyframes"])[-1]
    changed(lambda r: r["frames"][time].__setitem__(0, r["frames"][time][0] + 0.03), "camera at", "mm")
    changed(lambda r: r["frames"].pop(time), "no pose at")
    changed(lambda r: r["objects"].pop(), "missing")
    changed(lambda r: r["objects"].append({**r["objects"][0], "translation_m": [9, 9, 0]}), "new")
    changed(lambda r: r["objects"][0]["translation_m"].__setitem__(1, r["objects"][0]["translation_m"][1] + 0.08), "moved")
    changed(lambda r: r["objects"][0]["size_m"].__setitem__(2, r["objects"][0]["size_m"][2] + 0.08), "size")
    changed(lambda r: r["objects"][0].__setitem__("confidence", r["objects"][0]["confidence"] - 0.2), "confidence")
    changed(lambda r: r["objects"][0].__setitem__("class", "bed"), "missing")
    changed(lambda r: r["ground"].__setitem__("d_m", r["ground"]["d_m"] + 0.05), "ground")
    changed(lambda r: r.__setitem__("verdict", "bad"), "verdict")


def run_demo(program, repository, folder):
    """The finished workspace; None when something is not installed."""
    scene = repository / "configs" / "scenes" / "demo_room.yaml"
    for arguments in (("synth", scene, "-o", folder / "capture"),
                      ("run", folder / "capture", "-o", folder / "workspace", "--progress", "none")):
        done = captures.deepslam(program, *arguments, data=None, timeout=1500)
        if done.returncode == 3 and any(word in done.stderr for word in ("sweethome3d-furniture", "fetch", "library build")):
            print(f"skipped: {done.stderr.strip()}")
            return None
        if done.returncode != 0:
            sys.exit(f"deepslam {arguments[0]} ended with {done.returncode}: {done.stderr}")
    return folder / "workspace"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("repository", type=pathlib.Path)
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--workspace", type=pathlib.Path)
    given = parser.parse_args()
    file = given.repository / "tests" / "end_to_end" / "golden_demo.json"
    if not given.record:
        check_that_changes_are_seen(json.loads(file.read_text()))
    with tempfile.TemporaryDirectory(prefix="deepslam-golden-") as temp:
        workspace = given.workspace or run_demo(given.program.resolve(), given.repository, pathlib.Path(temp))
        if workspace is None:
            return SKIPPED
        found = summary_of(workspace)
    if given.record:
        file.write_text(json.dumps(without_frames(found), indent=1) + "\n")
        return 0
    said = list(faults(json.loads(file.read_text()), found))
    for fault in said:
        print(fault)
    print(f"{len(found['keyframes'])} keyframes, {len(found['objects'])} objects, {len(said)} differences from the recorded run")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
