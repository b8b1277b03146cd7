#!/usr/bin/env python3
"""What `deepslam expand` writes for engines and simulators of maps that no capture gives, read by these.

    odd_maps_test.py DEEPSLAM REPOSITORY

An empty one, names of any letters, objects without a surface, fifty different pieces of furniture, a thousand objects.
The furniture is the library's.
"""
import importlib
import json
import os
import pathlib
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[2]).resolve()
sys.path[:0] = [str(REPOSITORY / "tests" / part) for part in ("support", "end_to_end")]
import python_packages  # noqa: E402

mujoco, pybullet, _ = python_packages.need("mujoco", "pybullet", "pxr")
from pxr import Usd, UsdValidation  # noqa: E402

captures = importlib.import_module("captures")
volume_of = importlib.import_module("obj_files").volume_of

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
DATA = pathlib.Path(os.environ.get("XDG_DATA_HOME") or pathlib.Path.home() / ".local/share") / "deepslam"
DATA = pathlib.Path(os.environ.get("DEEPSLAM_DATA") or DATA)
LIBRARY = DATA / "library" / "library.json"
APART_M = 6.0
VOLUME_TOLERANCE = 0.10  # of a mesh's volume, which the engines take for its mass


def make_map(objects):
    return {"format": "deepslam/map", "version": 5, "tool_version": "0", "capture_name": "odd -- one", "capture_hash": "",
            "ground_world": {"d_m": 0, "normal": [0, 0, 1]}, "ground_outline_m": [], "class_colours": {},
            "mesh_options": {}, "verdict": "good", "reasons": [], "objects": objects}


def make_object(number, name, model=None):
    """A piece of furniture, or what has no surface, on the floor and 6 m away from the next one."""
    height_m = model["size_m"][2] if model else 1.0
    shape = {"library_id": model["id"], "library_checksum": model["checksum"][:16]} if model else {}
    return {"id": number, "name": name, "class": model["class"] if model else "chair", "confidence": 0.5,
            "source": "retrieval", "credit": "", "note": "", "scale_m": 1.0,
            "size_m": model["size_m"] if model else [0, 0, 0], "shape": shape, "stands_on": "floor",
            "world_from_object": {"rotation_xyzw": [0, 0, 0, 1],
                                  "translation_m": [APART_M * (number % 32), APART_M * (number // 32), height_m / 2]}}


class OddMaps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not LIBRARY.is_file():
            raise unittest.SkipTest(f"no furniture library in {DATA}")
        cls.models = json.loads(LIBRARY.read_text())["models"]

    def setUp(self):
        temp = tempfile.TemporaryDirectory(prefix="deepslam-odd-")
        self.addCleanup(temp.cleanup)
        self.folder = pathlib.Path(temp.name)

    def expand(self, objects, *arguments):
        file = self.folder / "map.json"
        file.write_text(json.dumps(make_map(objects)))
        done = captures.deepslam(PROGRAM, "expand", file, "-o", *arguments, data=DATA)
        self.assertEqual(done.returncode, 0, done.stderr)

    def expand_all(self, objects):
        """The stage, the model of MuJoCo, and the links that PyBullet has."""
        self.expand(objects, self.folder / "scene.usdz", "--physics", "--simulator", self.folder / "simulator")
        stage = Usd.Stage.Open(str(self.folder / "scene.usdz"))
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
        self.assertFalse([(error.GetName(), error.GetMessage()) for error in errors])
        model = mujoco.MjModel.from_xml_path(str(self.folder / "simulator/scene.xml"))
        return stage, model

    def links_in_pybullet(self):
        client = pybullet.connect(pybullet.DIRECT)
        self.addCleanup(pybullet.disconnect, client)
        scene = pybullet.loadURDF(str(self.folder / "simulator/scene.urdf"), useFixedBase=True)
        return [pybullet.getJointInfo(scene, number)[12].decode() for number in range(pybullet.getNumJoints(scene))]

    def test_an_empty_map(self):
        stage, model = self.expand_all([])
        self.assertEqual(len(stage.GetPrimAtPath("/World/Objects").GetChildren()), 0)
        self.assertEqual(model.nbody, 1)
        self.assertEqual(self.links_in_pybullet(), ["endless_floor"])

    def test_names_of_any_letters_and_objects_without_a_surface(self):
        chair = next(model for model in self.models if model["class"] == "chair")
        names = ["Küche 2/<&>\"'", "椅子", "🪑", "7", "world", "World", "a\nb", "../../etc", "mesh", "Küche 2/<&>\"' "]
        objects = [make_object(number, name, chair) for number, name in enumerate(names)]
        objects.append(make_object(len(names), "nothing", None))
        stage, model = self.expand_all(objects)
        prims = stage.GetPrimAtPath("/World/Objects").GetChildren()
        self.assertEqual([prim.GetDisplayName() for prim in prims], [*names, "nothing"])
        self.assertEqual(prims[0].GetName(), "K_u00FCche_u00202_u002F_u003C_u0026_u003E_u0022_u0027")
        self.assertEqual(prims[1].GetName(), "_u6905_u5B50")
        self.assertTrue(all(name.isascii() and name.isidentifier() for name in map(Usd.Prim.GetName, prims)))
        # Whatever has a surface is in the simulators, under the names of USD but for those that the files themselves need.
        bodies = {model.body(number).name for number in range(1, model.nbody)}
        expected = {prim.GetName() for prim in prims} - {"nothing", "world"} | {"world_2"}
        self.assertEqual(bodies, expected)
        self.assertEqual(set(self.links_in_pybullet()), expected | {"endless_floor"})
        placed = json.loads((self.folder / "simulator/placements.json").read_text())["objects"]
        for row in placed:
            self.assertEqual((self.folder / "simulator" / row["file"]).resolve().parent,
                             (self.folder / "simulator/objects").resolve())

    def test_fifty_pieces_of_furniture(self):
        some = self.models[:: max(1, len(self.models) // 50)][:50]
        objects = [make_object(number, f"thing_{number:02}", model) for number, model in enumerate(some)]
        self.expand(objects, self.folder / "scene.usda", "--simulator", self.folder / "simulator")
        meshes = self.folder / "simulator/meshes"
        for thing in objects:
            volume = volume_of(meshes / f"{thing['name']}.obj")
            pieces = sum(map(volume_of, meshes.glob(f"{thing['name']}_piece_*.obj")))
            with self.subTest(model=thing["shape"]["library_id"]):
                self.assertAlmostEqual(pieces / volume, 1, delta=VOLUME_TOLERANCE)

    def test_a_thousand_objects(self):
        cabinet = min((model for model in self.models if model["class"] == "cabinet"), key=lambda model: model["id"])
        objects = [make_object(number, f"cabinet_{number:03}", cabinet) for number in range(1000)]
        stage, model = self.expand_all(objects)
        self.assertEqual(len(stage.GetPrimAtPath("/World/Objects").GetChildren()), 1000)
        self.assertEqual(model.nbody, 1001)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
