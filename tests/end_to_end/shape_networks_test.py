#!/usr/bin/env python3
"""Shape networks that misbehave, on a whole run: one that answers a view with NaN loses that candidate alone, weights of another
version are refused.

    shape_networks_test.py DEEPSLAM REPOSITORY
"""
import json
import math
import pathlib
import sys
import tempfile
import unittest

import captures
import onnx_files
from onnx_files import INT64, constant, node

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SKIPPED = 77
TEMP = tempfile.TemporaryDirectory(prefix="deepslam-networks-")
DIR = pathlib.Path(TEMP.name)
ROOM = captures.make_room(PROGRAM, DIR / "room")
CROP, SKETCH, LATENTS, SIDE = (7, 128, 128), (5, 64, 64), 100, 64


def network(role, class_name, inputs, outputs, nodes, constants, version=2, **metadata):
    """The bytes of a shape network's file; `inputs` and `outputs`: name -> shape without the batch."""
    batches = [{name: (1, *shape) for name, shape in ports.items()} for ports in (inputs, outputs)]
    return onnx_files.network(*batches, nodes, constants, {
        "format": "deepslam/prior", "version": version, "class": class_name, "role": role, **metadata})


def fixed(name, shape, values):
    """Node and constant of an output that is the same for every view."""
    return node("Identity", [f"{name}_is"], name), constant(f"{name}_is", (1, *shape), values)


def write_networks(folder, class_name, least=None, version=1):
    """Networks that answer every view with a box. The latents are the mean of the crop; below `least` they are NaN."""
    (folder / class_name).mkdir(parents=True, exist_ok=True)
    sketch, sketch_is = fixed("sketch", SKETCH, [0.1] * math.prod(SKETCH))
    # The higher the mean, the surer of the azimuth.
    azimuth, azimuth_is = node("Mul", ["azimuth_is", "row"], "azimuth"), constant("azimuth_is", (1, 24), [9.0] + [0.0] * 23)
    elevation, elevation_is = fixed("elevation", (1,), [0.3])
    inner = range(SIDE // 4, 3 * SIDE // 4)
    logits, logits_is = fixed("logits", (SIDE,) * 3, [4.0 if x in inner and y in inner and z in inner else -4.0
                                                      for x in range(SIDE) for y in range(SIDE) for z in range(SIDE)])
    nodes = [node("ReduceMean", ["crop"], "mean"), node("Reshape", ["mean", "one_row"], "row")]
    constants = [constant("one_row", (2,), [1, 1], INT64), constant("zeros", (1, LATENTS), [0.0] * LATENTS)]
    if least is not None:  # a root of what is negative
        nodes += [node("Sub", ["row", "least"], "above"), node("Sqrt", ["above"], "root"), node("Add", ["row", "root"], "sum")]
        constants.append(constant("least", (1, 1), [least]))
    nodes.append(node("Add", ["zeros", "sum" if least is not None else "row"], "latents"))
    for role, content in {
            "sketch": network("sketch", class_name, {"crop": CROP}, {"sketch": SKETCH}, [sketch], [sketch_is], 1),
            "encoder": network("encoder", class_name, {"crop": CROP, "sketch": SKETCH},
                               {"latents": (LATENTS,), "azimuth": (24,), "elevation": (1,)}, [*nodes, azimuth, elevation],
                               [*constants, azimuth_is, elevation_is], version),
            "decoder": network("decoder", class_name, {"latents": (LATENTS,)}, {"logits": (SIDE,) * 3}, [logits], [logits_is], 1,
                               threshold=0.4, threshold_colour=0.3)}.items():
        (folder / class_name / f"{role}.onnx").write_bytes(content)


class ShapeNetworks(unittest.TestCase):
    def setUp(self):
        self.dir = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(dir=DIR)))
        self.workspace, self.priors = self.dir / "workspace", self.dir / "priors"

    def write(self, **faults):
        for name in ("chair", "table"):
            write_networks(self.priors, name, **faults)

    def run_until(self, stage, max_views=8):
        boxes = DIR / "boxes.json"
        boxes.write_text(json.dumps(captures.true_boxes(ROOM)))
        return captures.deepslam(PROGRAM, "run", ROOM, "-o", self.workspace, "--progress", "none", *captures.BARE, "--set",
                                 "detect.source=file", "--set", f"detect.file={boxes}", "--set", f"propose.priors={self.priors}",
                                 "--set", "propose.network=true", "--set", f"propose.networks.max_views={max_views}", "--until", stage)

    def proposed(self, stage="propose", **options):
        result = self.run_until(stage, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        document = json.loads((self.workspace / "propose/candidates.json").read_text())
        of_views = {(one["object"], one["view"]): one["latents"][0] for one in document["candidates"] if one["source"] == "network"}
        return of_views, document

    def test_the_surest_views_are_offered(self):
        self.write()
        of_all, _ = self.proposed()
        of_two, _ = self.proposed(max_views=2)
        surest = set()
        for thing in {number for number, _ in of_all}:
            surest |= set(sorted((key for key in of_all if key[0] == thing), key=of_all.get, reverse=True)[:2])
        self.assertLess(len(surest), len(of_all))
        self.assertEqual(set(of_two), surest)

    def test_a_view_answered_with_nan_loses_its_candidate_and_the_run_goes_on(self):
        self.write()
        sound, _ = self.proposed()
        self.assertGreater(len(sound), 2)
        misread, next_one = sorted(sound, key=sound.get)[:2]
        self.write(least=(sound[misread] + sound[next_one]) / 2)
        left, document = self.proposed("report")
        self.assertEqual(set(left), set(sound) - {misread})
        notes = [note for note in document["notes"] if "not finite" in note]
        self.assertEqual(len(notes), 1, document["notes"])
        self.assertRegex(notes[0], "frame .*latents")
        self.assertTrue((self.workspace / "report/index.html").exists())

    def test_weights_of_another_version_are_refused(self):
        self.write()
        sound, _ = self.proposed()
        before = (self.workspace / "propose/candidates.json").read_bytes()
        write_networks(self.priors, "table", version=9)
        result = self.run_until("report")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertRegex(result.stderr, r"priors/table/encoder\.onnx: it is of version '9', this program knows up to \d.*train\.sh")
        self.assertFalse((self.workspace / "register").exists())
        self.assertEqual([path for path in self.workspace.rglob("*") if ".partial" in path.name], [])
        self.write()
        self.assertEqual(self.proposed()[0], sound)
        self.assertEqual((self.workspace / "propose/candidates.json").read_bytes(), before)


if __name__ == "__main__":
    if ROOM is None:
        print("skipped: the furniture catalogues (Debian package sweethome3d-furniture) are not installed")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
