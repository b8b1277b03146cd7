#!/usr/bin/env python3
"""What stage export writes for other programs, read by these: JSON Schema, OpenUSD, MuJoCo, PyBullet.

    exports_test.py DEEPSLAM REPOSITORY

A rendered room, and redkitchen where DEEPSLAM_TEST_DATA is set. Workspaces that are there already, exported with all
of it on, are looked at instead where DEEPSLAM_EXPORTED names them (with ":" between).
"""
import ctypes
import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[2]).resolve()
sys.path[:0] = [str(REPOSITORY / "tests" / part) for part in ("support", "end_to_end")]
import python_packages  # noqa: E402

numpy, jsonschema, mujoco, pybullet, typesys, _ = python_packages.need(
    "numpy", "jsonschema", "mujoco", "pybullet", "rosbags.typesys", "pxr")
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, UsdValidation  # noqa: E402

captures = importlib.import_module("captures")
volume_of = importlib.import_module("obj_files").volume_of

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
DATA = pathlib.Path(os.environ.get("DEEPSLAM_TEST_DATA", "/nonexistent")) / "data"
EXPORTED = [pathlib.Path(name) for name in os.environ.get("DEEPSLAM_EXPORTED", "").split(":") if name]
SETTINGS = ["export.usd=both", "export.usd_physics=true", "export.simulator=true"]
SECONDS = 2.0  # of simulation
MAX_MOVED_M, MAX_TIPPED_DEG = 0.01, 1.0
VOLUME_TOLERANCE = 0.15  # hulls of rough parts, as of what hangs under a seat, hold air that no cut is worth
SAME_M = 0.001


def turned(rotation_xyzw):
    x, y, z, w = rotation_xyzw
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def tipped_deg(before, after):
    """Between where up was and where it is, of two rotation matrices."""
    return float(numpy.degrees(numpy.arccos(numpy.clip((after @ before.T)[2, 2], -1, 1))))


class Exported:
    """The files that a run exported."""

    def __init__(self, workspace):
        self.folder = workspace / "export"
        self.map = json.loads((self.folder / "map.json").read_text())
        self.graph = json.loads((self.folder / "scene_graph.json").read_text())
        self.simulator = self.folder / "simulator"
        self.placements = json.loads((self.simulator / "placements.json").read_text())["objects"]

    def files(self):
        return {path.relative_to(self.folder): path.read_bytes() for path in self.folder.rglob("*")
                if path.is_file() and path.name != "timing.json"}

    def free_names(self):
        return [pathlib.Path(row["file"]).stem for row in self.placements]

    def on_floor(self):
        standing = {row["subject"] for row in self.graph["relations"]
                    if row["predicate"] == "stands_on" and row["object"] == "floor"}
        return [name for name in self.free_names() if name in standing]


class SceneChecks:
    """Of one scene; subclasses give `exported`."""

    exported = None

    def test_the_graph_fits_its_schema_and_itself(self):
        schema = json.loads((REPOSITORY / "docs/scene_graph.schema.json").read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        graph = self.exported.graph
        jsonschema.Draft202012Validator(schema).validate(graph)
        objects = {entry["name"]: entry for entry in graph["objects"]}
        places = {"floor"} | {entry["name"] for kind in ("rooms", "walls") for entry in graph[kind]}
        for relation in graph["relations"]:
            self.assertIn(relation["subject"], objects)
            self.assertIn(relation["object"], places | set(objects))
        self.assertEqual(list(objects), [entry["name"] for entry in self.exported.map["objects"]])
        for room in graph["rooms"]:
            inside = [entry["id"] for entry in graph["objects"] if entry["room"] == room["id"]]
            self.assertEqual(room["objects"], inside)
        for entry in graph["objects"]:
            low, high = entry["axis_aligned_box"]["min_m"], entry["axis_aligned_box"]["max_m"]
            self.assertTrue(all(a <= b <= c for a, b, c in zip(low, entry["centre_m"], high)), entry["name"])

    def test_usd_is_valid_and_says_what_the_map_says(self):
        for name in ("scene.usda", "scene.usdz"):
            with self.subTest(file=name):
                stage = Usd.Stage.Open(str(self.exported.folder / name))
                validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
                errors = UsdValidation.ValidationContext(validators).Validate(stage)
                self.assertFalse([(error.GetName(), error.GetMessage()) for error in errors])
                self.assertEqual(UsdGeom.GetStageMetersPerUnit(stage), 1)
                self.assertEqual(UsdGeom.GetStageUpAxis(stage), "Z")
                self.assertEqual(stage.GetDefaultPrim().GetPath(), Sdf.Path("/World"))
                for entry in self.exported.map["objects"]:
                    self.check_object(stage.GetPrimAtPath(f"/World/Objects/{entry['name']}"), entry)

    def check_object(self, prim, entry):
        self.assertTrue(prim, entry["name"])
        self.assertEqual(list(UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Get()), [entry["class"]])
        self.assertEqual(prim.GetCustomDataByKey("deepslam:class"), entry["class"])
        matrix = numpy.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())).T
        pose = entry["world_from_object"]
        self.assertLess(numpy.abs(matrix[:3, 3] - pose["translation_m"]).max(), SAME_M)
        self.assertLess(numpy.abs(matrix[:3, :3] - turned(pose["rotation_xyzw"])).max(), 1e-5)
        mesh = UsdGeom.Mesh(prim.GetChild(prim.GetName()))
        points = numpy.array(mesh.GetPointsAttr().Get())
        self.assertLess(numpy.abs(numpy.ptp(points, axis=0) - entry["size_m"]).max(), SAME_M, entry["name"])
        extent = numpy.array(mesh.GetExtentAttr().Get())
        self.assertLess(numpy.abs(extent - [points.min(axis=0), points.max(axis=0)]).max(), 1e-4)
        colours = mesh.GetDisplayColorPrimvar()
        self.assertIn(colours.GetInterpolation(), ("vertex", "constant"))
        if colours.GetInterpolation() == "vertex":
            self.assertEqual(len(colours.Get()), len(points))
        self.assertTrue(UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0])
        if prim.HasAPI(UsdPhysics.RigidBodyAPI):
            self.assertGreater(UsdPhysics.MassAPI(prim).GetMassAttr().Get(), 0)
            self.assertTrue(prim.GetChild("collision"))

    def test_messages_of_ros_hold_it(self):
        # The guide's frames and markers, packed as ROS 2 sends them and unpacked again.
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        kinds = {name.rsplit("/", 1)[1]: kind for name, kind in store.types.items()
                 if name.split("/")[0] in ("builtin_interfaces", "geometry_msgs", "std_msgs", "visualization_msgs")}
        header = kinds["Header"](kinds["Time"](0, 0), "map")
        no_bytes = numpy.zeros(0, numpy.uint8)
        picture = store.types["sensor_msgs/msg/CompressedImage"](header, "", no_bytes)
        frames, markers = [], []
        for thing in self.exported.graph["objects"]:
            pose, box = thing["world_from_object"], thing["oriented_box"]
            turn = kinds["Quaternion"](*pose["rotation_xyzw"])
            frames.append(kinds["TransformStamped"](
                header, thing["name"], kinds["Transform"](kinds["Vector3"](*pose["translation_m"]), turn)))
            place = kinds["Pose"](kinds["Point"](*box["centre_m"]), kinds["Quaternion"](*box["rotation_xyzw"]))
            markers.append(kinds["Marker"](
                header=header, ns=thing["class"], id=thing["id"], type=kinds["Marker"].CUBE, action=0, pose=place,
                scale=kinds["Vector3"](*box["size_m"]), color=kinds["ColorRGBA"](0, 1, 0, 0.4),
                lifetime=kinds["Duration"](0, 0), frame_locked=False, points=[], colors=[], texture_resource="",
                texture=picture, uv_coordinates=[], text="", mesh_resource="", mesh_use_embedded_materials=False,
                mesh_file=kinds["MeshFile"]("", no_bytes)))
        for message in [kinds["MarkerArray"](markers), *frames]:
            packed = store.serialize_cdr(message, message.__msgtype__)
            self.assertEqual(store.serialize_cdr(store.deserialize_cdr(packed, message.__msgtype__), message.__msgtype__), packed)

    def test_blender_has_their_names_and_labels(self):
        done = subprocess.run([REPOSITORY / "scripts/import_blender.sh", self.exported.folder / "scene.usdz"],
                              capture_output=True, text=True, timeout=600)
        if "no Blender found" in done.stderr or "usd_import" in done.stderr:
            self.skipTest("no Blender that reads USD")
        self.assertEqual(done.returncode, 0, done.stderr)
        things = {thing["name"]: thing for thing in json.loads(done.stdout)}
        for entry in self.exported.map["objects"]:
            thing = things[entry["name"]]
            self.assertEqual((thing["class"], thing["instance"]), (entry["class"], entry["id"]))
            self.assertTrue(thing["vertex_colours"])
            self.assertLess(numpy.abs(numpy.subtract(thing["at_m"], entry["world_from_object"]["translation_m"])).max(), SAME_M)
            self.assertLess(numpy.abs(numpy.subtract(thing["size_m"], entry["size_m"])).max(), SAME_M)

    def test_convex_pieces_have_the_volume_of_the_mesh(self):
        # Pieces of things that reach into others or into a wall are cut: what stands apart shows the decomposition.
        near = {name for relation in self.exported.graph["relations"] if relation.get("distance_m", 1) == 0
                for name in (relation["subject"], relation["object"])}
        near |= {entry["name"] for entry in self.exported.graph["objects"] if self.is_at_a_wall(entry)}
        for entry in self.exported.graph["objects"]:
            if not entry["has_mesh"] or entry["name"] in near:
                continue
            pieces = sum(map(volume_of, self.exported.simulator.glob(f"meshes/{entry['name']}_piece_*.obj")))
            self.assertAlmostEqual(pieces / entry["volume_m3"], 1, delta=VOLUME_TOLERANCE, msg=entry["name"])

    def is_at_a_wall(self, entry):
        """Whether a wall crosses its box, or passes it within 20 cm."""
        low, high = (numpy.array(entry["axis_aligned_box"][end][:2]) + way for end, way in (("min_m", -0.2), ("max_m", 0.2)))
        for wall in self.exported.graph["walls"]:
            along = numpy.linspace(wall["from_m"], wall["to_m"], 200)
            if ((along > low) & (along < high)).all(axis=1).any():
                return True
        return False

    def test_things_stay_where_they_stand_in_mujoco(self):
        model = mujoco.MjModel.from_xml_path(str(self.exported.simulator / "scene.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        bodies = {name: model.body(name).id for name in self.exported.free_names()}
        self.assertEqual(model.njnt, len(bodies))
        before = {name: (data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()) for name, body in bodies.items()}
        while data.time < SECONDS:
            mujoco.mj_step(model, data)
            self.assertLess(numpy.abs(data.qvel).max(initial=0), 20, "something exploded")
        for name in self.exported.on_floor():
            place, turn = before[name]
            self.assertLess(numpy.linalg.norm(data.xpos[bodies[name]] - place), MAX_MOVED_M, name)
            self.assertLess(tipped_deg(turn, data.xmat[bodies[name]].reshape(3, 3)), MAX_TIPPED_DEG, name)

    def test_things_stay_where_they_stand_in_pybullet(self):
        client = pybullet.connect(pybullet.DIRECT)
        self.addCleanup(pybullet.disconnect, client)
        pybullet.setGravity(0, 0, -9.81)
        whole = pybullet.loadURDF(str(self.exported.simulator / "scene.urdf"), useFixedBase=True)
        links = {pybullet.getJointInfo(whole, n)[12].decode() for n in range(pybullet.getNumJoints(whole))}
        for entry in self.exported.graph["objects"]:
            if entry["has_mesh"]:
                self.assertIn(entry["name"], links)
        pybullet.removeBody(whole)
        pybullet.loadURDF(str(self.exported.simulator / "scene_fixed.urdf"), useFixedBase=True)
        bodies = {pathlib.Path(row["file"]).stem: pybullet.loadURDF(
            str(self.exported.simulator / row["file"]), row["position_m"], row["rotation_xyzw"],
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE) for row in self.exported.placements}
        before = {name: pybullet.getBasePositionAndOrientation(body) for name, body in bodies.items()}
        pybullet.setTimeStep(1 / 240)
        for _ in range(int(240 * SECONDS)):
            pybullet.stepSimulation()
        for name in self.exported.on_floor():
            place, turn = pybullet.getBasePositionAndOrientation(bodies[name])
            self.assertLess(numpy.linalg.norm(numpy.subtract(place, before[name][0])), MAX_MOVED_M, name)
            self.assertLess(tipped_deg(turned(before[name][1]), turned(turn)), MAX_TIPPED_DEG, name)

    def test_sdformat_takes_what_gazebo_loads(self):
        try:
            check = ctypes.CDLL("libsdformat12.so.12").cmdCheck
        except OSError as fault:
            self.skipTest(str(fault))
        files = [self.exported.simulator / name for name in ("scene.sdf", "scene_fixed.urdf")]
        for file in [*files, *self.exported.simulator.glob("objects/*.urdf")]:
            self.assertEqual(check(str(file).encode()), 0, file.name)
        self.assertNotEqual(check(str(self.exported.folder / "map.json").encode()), 0, "it would take anything")

    def test_a_ball_under_a_chair_or_a_table_rolls(self):
        standing = [entry for entry in self.exported.map["objects"]
                    if entry["class"] in ("chair", "table") and entry["name"] in self.exported.on_floor()]
        rolled = {entry["name"]: self.ball_under(entry) for entry in standing}
        # What was seen from one side alone may be closed below; a hull would close all of them.
        self.assertGreater(max(rolled.values(), default=1), 0.15, rolled)

    def ball_under(self, entry):
        """How far a ball of 2 cm gets that is pushed along the floor from the middle of a thing's footprint, m."""
        text = (self.exported.simulator / "scene.xml").read_text()
        x, y = entry["world_from_object"]["translation_m"][:2]
        ball = (f'<body name="ball" pos="{x} {y} 0.021"><freejoint/><geom type="sphere" size="0.02" mass="0.02" '
                'friction="0.7 0.005 0.0001"/></body>')
        path = self.exported.simulator / "with_ball.xml"
        path.write_text(text.replace("</worldbody>", ball + "</worldbody>"))
        self.addCleanup(path.unlink, missing_ok=True)
        model = mujoco.MjModel.from_xml_path(str(path))
        farthest = 0.0
        for angle in numpy.linspace(0, 2 * numpy.pi, 8, endpoint=False):
            data = mujoco.MjData(model)
            data.qvel[-6:-3] = [0.5 * numpy.cos(angle), 0.5 * numpy.sin(angle), 0]
            while data.time < 0.8:
                mujoco.mj_step(model, data)
            place = data.body("ball").xpos
            if place[2] < 0.05:
                farthest = max(farthest, float(numpy.hypot(place[0] - x, place[1] - y)))
        return farthest


def export(capture, workspace):
    arguments = [word for setting in SETTINGS for word in ("--set", setting)]
    done = captures.deepslam(PROGRAM, "run", capture, "-o", workspace, "--progress", "none", *arguments, data=None,
                             timeout=1200)
    if done.returncode == 3:
        raise unittest.SkipTest(f"weights or library are missing: {done.stderr.strip()[-200:]}")
    assert done.returncode == 0, done.stderr[-2000:]
    return Exported(workspace)


class Scene(SceneChecks, unittest.TestCase):
    """A capture, run with all of it on, in a folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.temp = tempfile.TemporaryDirectory(prefix="deepslam-exports-")
        cls.addClassCleanup(cls.temp.cleanup)
        cls.folder = pathlib.Path(cls.temp.name)
        cls.capture = cls.find_capture()
        cls.exported = export(cls.capture, cls.folder / "workspace")


class RenderedRoom(Scene):
    @classmethod
    def find_capture(cls):
        capture = captures.make_room(PROGRAM, cls.folder / "room")
        if capture is None:
            raise unittest.SkipTest("the furniture catalogues are not installed")
        return capture

    def test_exports_are_the_same_every_time(self):
        before = self.exported.files()
        arguments = [word for setting in SETTINGS for word in ("--set", setting)]
        done = captures.deepslam(PROGRAM, "run", self.capture, "-o", self.folder / "workspace", "--progress", "none",
                                 "--force", "export", "--threads", "1", *arguments, data=None)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.exported.files(), before)

    def test_nothing_of_it_is_written_unasked(self):
        done = captures.deepslam(PROGRAM, "run", self.capture, "-o", self.folder / "plain", "--progress", "none", data=None)
        self.assertEqual(done.returncode, 0, done.stderr)
        names = {path.name for path in (self.folder / "plain/export").iterdir()}
        self.assertIn("scene_graph.json", names)
        self.assertFalse(names & {"scene.usda", "scene.usdz", "simulator"})


class Redkitchen(Scene):
    @classmethod
    def find_capture(cls):
        if not DATA.is_dir():
            raise unittest.SkipTest("DEEPSLAM_TEST_DATA is not set")
        return DATA / "redkitchen"


def load_tests(loader, _tests, _pattern):
    if not EXPORTED:
        classes = [RenderedRoom, Redkitchen]
    else:
        classes = [type(f"Workspace_{path.name}", (SceneChecks, unittest.TestCase), {"exported": Exported(path)})
                   for path in EXPORTED]
    return unittest.TestSuite(loader.loadTestsFromTestCase(each) for each in classes)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
