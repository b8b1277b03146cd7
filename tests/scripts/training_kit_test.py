#!/usr/bin/env python3
"""The training kit for a large GPU (scripts/train/gpu.sh) without one: packing, budget, checkpoints, the stream of views.

    training_kit_test.py DEEPSLAM SCRIPTS/train     what needs PyTorch is skipped by name where it is not installed
"""
import importlib.util
import json
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
TRAIN = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(TRAIN))
import budget  # noqa: E402
import gpu_kit  # noqa: E402
import pieces  # noqa: E402
import results  # noqa: E402

HAS_TORCH = all(importlib.util.find_spec(name) for name in ("torch", "numpy", "matplotlib", "yaml", "onnx", "scipy"))
needs_torch = unittest.skipUnless(HAS_TORCH, "PyTorch and what goes with it (scripts/train/requirements.txt) is not installed")
VIEWS = PROGRAM.parent / "deepslam-views"

# A stool of a seat and four legs, 0.45 m high; y up.
BOXES = [((-0.2, 0.40, -0.2), (0.2, 0.45, 0.2))] + [
    ((x - 0.02, 0.0, z - 0.02), (x + 0.02, 0.40, z + 0.02)) for x in (-0.17, 0.17) for z in (-0.17, 0.17)]


def obj():
    lines, count = [], 0
    for low, high in BOXES:
        corners = [[(low, high)[n >> axis & 1][axis] for axis in range(3)] for n in range(8)]
        lines += ["v " + " ".join(map(str, corner)) for corner in corners]
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
            lines += [f"f {count + a + 1} {count + b + 1} {count + c + 1}", f"f {count + a + 1} {count + c + 1} {count + d + 1}"]
        count += 8
    return "\n".join(lines) + "\n"


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


class BudgetTest(unittest.TestCase):
    def test_runs_share_one_budget(self):
        clock = Clock()
        first = budget.Budget(600, clock=clock)
        self.assertEqual(first.share(), 0)
        clock.now += 150
        self.assertAlmostEqual(first.share(), 0.25)
        self.assertFalse(first.is_spent())
        clock.now += 5000  # between the runs nothing is spent
        second = budget.Budget(600, 150, clock)
        self.assertAlmostEqual(second.share(), 0.25)
        clock.now += 450
        self.assertTrue(second.is_spent())
        self.assertEqual(second.share(), 1)

    def test_nothing_left_is_spent_at_once(self):
        self.assertTrue(budget.Budget(0).is_spent())
        self.assertEqual(budget.Budget(0).share(), 1)

    def test_every(self):
        clock = Clock()
        every = budget.Every(60, clock)
        due = []
        for _ in range(240):
            clock.now += 1
            due.append(every.is_due())
        self.assertEqual([n for n, yes in enumerate(due, 1) if yes], [60, 120, 180, 240])


class PiecesTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_round_trip_in_pieces_of_limited_size(self):
        content = bytes(range(256)) * 40
        pieces.write(self.folder, "checkpoint", 7, content, most=1000)
        files = sorted(self.folder.iterdir())
        self.assertEqual(len(files), 11)
        self.assertLessEqual(max(file.stat().st_size for file in files), 1000)
        self.assertEqual(pieces.read(self.folder, "checkpoint"), (7, content))
        pieces.write(self.folder, "checkpoint", 8, b"short", most=1000)
        self.assertEqual([file.name for file in self.folder.iterdir()], ["checkpoint.8.1of1"])
        self.assertEqual(pieces.read(self.folder, "checkpoint"), (8, b"short"))

    def test_a_set_that_is_not_whole_leaves_the_one_before(self):
        pieces.write(self.folder, "checkpoint", 7, b"before" * 300, most=1000)
        before = {file.name: file.read_bytes() for file in self.folder.iterdir()}
        for cut in ("missing", "changed"):
            pieces.write(self.folder, "checkpoint", 8, b"after" * 500, most=1000)
            for name, content in before.items():
                (self.folder / name).write_bytes(content)
            victim = self.folder / "checkpoint.8.2of3"
            if cut == "missing":
                victim.unlink()
            else:
                victim.write_bytes(b"x" + victim.read_bytes()[1:])
            self.assertEqual(pieces.read(self.folder, "checkpoint"), (7, b"before" * 300), cut)

    def test_nothing_there(self):
        self.assertIsNone(pieces.read(self.folder, "checkpoint"))


class ResultsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.tar = self.folder / "results.tar"

    def part(self, name, content):
        file = self.folder / name
        file.write_bytes(content)
        return file

    def packed(self):
        with tarfile.open(self.tar) as tar:
            return {entry.name: tar.extractfile(entry).read() for entry in tar}

    def shell(self, command):
        return lambda place: ["sh", "-c", command, "sh", str(place)]

    def test_what_is_packed_stays_until_something_better_is_whole(self):
        results.pack(self.tar, "bed", [self.part("weights.pt", b"early")])
        self.assertEqual(self.packed(), {"bed/weights.pt": b"early"})
        with self.assertRaises(SystemExit) as ended:
            results.pack(self.tar, "bed", [self.part("large", b"x" * 2**20)], most=2**19)
        self.assertIn("at most", str(ended.exception))
        with self.assertRaises(OSError):
            results.pack(self.tar, "bed", [self.folder / "missing"])
        self.assertEqual(self.packed(), {"bed/weights.pt": b"early"})
        results.pack(self.tar, "bed", [self.part("a", b"1"), self.part("b", b"2")])
        self.assertEqual(self.packed(), {"bed/a": b"1", "bed/b": b"2"})

    def test_steps_end_with_their_time_and_go_on_where_they_were(self):
        first = self.shell("echo . >>runs; mkdir $1; echo done >$1/file")
        begun = time.monotonic()
        steps = results.Steps(self.folder, 1.0, lambda: False)
        self.assertTrue(steps.make("first", first))
        self.assertFalse(steps.make("second", self.shell("echo half >$1; exec sleep 60")))
        self.assertFalse(steps.make("third", self.shell("echo >$1")), "nothing begins after the end")
        self.assertLess(time.monotonic() - begun, 20)
        self.assertFalse((self.folder / "second").exists() or (self.folder / "third").exists())
        again = results.Steps(self.folder, 60, lambda: False, {"WORD": "whole"})
        self.assertTrue(again.make("first", first))
        self.assertTrue(again.make("second", self.shell("test ! -e $1 && echo $WORD >$1")))
        self.assertEqual((self.folder / "second").read_text(), "whole\n")
        self.assertEqual((self.folder / "runs").read_text(), ".\n", "what was made is not made again")

    def test_steps_end_when_asked_and_say_why_they_fail(self):
        asked = results.Steps(self.folder, 60, lambda: True)
        self.assertFalse(asked.make("scores", self.shell("echo >$1")))
        steps = results.Steps(self.folder, 60, lambda: False)
        with self.assertRaises(SystemExit) as ended:
            steps.make("scores", self.shell("echo >$1; echo out of memory >&2; exit 3"))
        self.assertIn("scores: out of memory", str(ended.exception))
        self.assertFalse((self.folder / "scores").exists())


class PackTest(unittest.TestCase):
    """A kit of one mesh, packed, unpacked elsewhere, and its renderer run there."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        meshes = cls.folder / "meshes" / "chair"
        meshes.mkdir(parents=True)
        (meshes / "stool.obj").write_text(obj(), encoding="utf-8")
        catalogues = pathlib.Path("/usr/share/sweethome3d/furniture")
        if not catalogues.is_dir():
            raise unittest.SkipTest("sweethome3d-furniture is not installed")
        cls.pack = cls.folder / "models.pack"
        outcome = subprocess.run([str(PROGRAM), "priors", "pack", "--class", "shelf", "--meshes", str(cls.folder / "meshes"),
                                  "-o", str(cls.pack)], cwd=TRAIN.parents[1], capture_output=True, text=True, check=False)
        assert outcome.returncode == 0, outcome.stderr

    def archive(self):
        """As gpu_kit.pack makes it, without waiting for the compressor."""
        archive = self.folder / "kit.tar.xz"
        if archive.exists():
            return archive
        kit = self.folder / "made"
        kit.mkdir()
        gpu_kit.copy_program(VIEWS, kit)
        shutil.copy(self.pack, kit / "models.pack")
        (kit / "kit.json").write_text(json.dumps({"format": gpu_kit.FORMAT, "version": gpu_kit.VERSION, "class": "shelf"}))
        with tarfile.open(archive, "w:xz", preset=0) as tar:
            for file in sorted(kit.rglob("*")):
                tar.add(file, file.relative_to(kit), recursive=False)
        return archive

    def run_kit(self, *arguments):
        return subprocess.run([sys.executable, str(TRAIN / "gpu_kit.py"), *map(str, arguments)], capture_output=True, text=True,
                              check=False)

    def views(self, command, out):
        outcome = subprocess.run([*command, "--pack", str(self.pack), "--class", "shelf", "--designs", "4", "--views", "2",
                                  "--product-views", "2", "--variants", "1", "-o", str(out)], env={}, capture_output=True,
                                 text=True, check=False)
        self.assertEqual(outcome.returncode, 0, outcome.stderr)
        return {file.name: file.read_bytes() for file in sorted(out.iterdir())}

    def test_the_carried_renderer_gives_the_same_views(self):
        out = self.folder / "unpacked"
        outcome = self.run_kit("unpack", self.archive(), "--class", "shelf", "--out", out)
        self.assertEqual(outcome.returncode, 0, outcome.stderr)
        here = self.views([str(VIEWS)], self.folder / "here")
        there = self.views(gpu_kit.program_of(out), self.folder / "there")
        self.assertEqual(here, there)
        # Every library of it lies in the kit, so that none of the machine's is asked for.
        loaded = subprocess.run([*gpu_kit.program_of(out)[:3], "--list", *gpu_kit.program_of(out)[3:]], env={}, capture_output=True,
                                text=True, check=True).stdout
        outside = [line for line in loaded.splitlines() if "=>" in line and str(out) not in line]
        self.assertEqual(outside, [])
        models = json.loads(here["training_views.json"])["models"]
        self.assertEqual({model["source"] for model in models}, {"generated", "catalogue"})
        self.assertNotIn("withheld", {model["split"] for model in models})

    @needs_torch
    def test_a_training_is_packed_before_it_is_scored(self):
        """The time for scores is nothing, as where a time limit ends the command right after the training."""
        import torch
        import yaml
        import nets
        import restart
        kit = self.folder / "unpacked_to_train"
        self.assertEqual(self.run_kit("unpack", self.archive(), "--out", kit).returncode, 0)
        config, out = TRAIN / "classes/shelf.yaml", self.folder / "trained"
        command = [sys.executable, str(TRAIN / "gpu_train.py"), str(config), "--kit", str(kit), "--work", str(self.folder / "work"),
                   "--out", str(out), "--cpu"]

        def packed(*arguments):
            outcome = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
            self.assertEqual(outcome.returncode, 0, outcome.stderr)
            with tarfile.open(out / "results.tar") as tar:
                return outcome.stdout, {pathlib.Path(entry.name).name: tar.extractfile(entry).read() for entry in tar}

        outcome = subprocess.run([*command, "--score"], capture_output=True, text=True, check=False)
        self.assertNotEqual(outcome.returncode, 0)
        self.assertIn("holds no checkpoint", outcome.stderr)
        said, files = packed("--minutes", "1", "--score-minutes", "0")
        self.assertIn("gpu.sh shelf --score", said)
        self.assertEqual(set(files), {"weights.pt", "curve.json", "curve.csv", "curves.png", "curves.svg"})
        self.assertLess(max(file.stat().st_size for file in out.iterdir()), results.MOST_BYTES + 1)
        steps = json.loads(files["curve.json"])["step"]
        self.assertGreater(steps, 0)
        (self.folder / "weights.pt").write_bytes(files["weights.pt"])
        model = nets.Prior(yaml.safe_load(config.read_text(encoding="utf-8"))["width"])
        restart.read(model, self.folder / "weights.pt")
        self.assertTrue(all(bool(torch.isfinite(value).all()) for value in model.state_dict().values()))
        # The checkpoint has these very weights, so that what was made of them holds.
        (self.folder / "work/made/scores").mkdir()
        _, again = packed("--score", "--score-minutes", "0")
        self.assertEqual(json.loads(again["curve.json"])["step"], steps)
        self.assertTrue((self.folder / "work/made/scores").exists())

    def test_withheld_products_are_only_for_tests(self):
        out = self.folder / "withheld"
        subprocess.run([str(VIEWS), "--pack", str(self.pack), "--class", "shelf", "--withheld", "--product-views", "1", "-o", str(out)],
                       check=True, capture_output=True)
        models = json.loads((out / "training_views.json").read_text(encoding="utf-8"))["models"]
        self.assertEqual({model["split"] for model in models}, {"withheld"})

    def test_bad_kits_are_refused(self):
        for name, content, said in (("damaged", self.archive().read_bytes()[:20000], "cannot be unpacked"), ("none", None, "is missing")):
            archive = self.folder / f"{name}.tar.xz"
            if content is not None:
                archive.write_bytes(content)
            outcome = self.run_kit("unpack", archive, "--out", self.folder / name)
            self.assertNotEqual(outcome.returncode, 0)
            self.assertIn(said, outcome.stderr)
            self.assertFalse((self.folder / name).exists())
        outcome = self.run_kit("unpack", self.archive(), "--class", "chair", "--out", self.folder / "other")
        self.assertIn("a kit for shelf, not for chair", outcome.stderr)

    def test_what_is_too_large_is_not_carried(self):
        archive = self.archive()
        with self.assertRaises(SystemExit) as ended:
            gpu_kit.check_size(archive, 10 * gpu_kit.MIB, 11)
        self.assertIn("more than 11 MiB", str(ended.exception))
        gpu_kit.check_size(archive, 0, 64)


class CheckTest(unittest.TestCase):
    def test_what_is_missing_is_named(self):
        outcome = subprocess.run([sys.executable, "-I", str(TRAIN / "gpu_kit.py"), "check"], capture_output=True, text=True, check=False)
        if outcome.returncode == 0:
            return  # all is there, and a GPU
        self.assertRegex(outcome.stderr, "lacks .*requirements.txt|sees no CUDA device.*--cpu")

    def test_unknown_classes_and_options(self):
        for arguments, said in ((("lamp",), "no such class: lamp"), (("chair", "--fast"), "unknown option --fast")):
            outcome = subprocess.run([str(TRAIN / "gpu.sh"), *arguments], capture_output=True, text=True, check=False)
            self.assertEqual(outcome.returncode, 2)
            self.assertIn(said, outcome.stderr)


@needs_torch
class StreamTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        subprocess.run([str(PROGRAM), "priors", "render", "--no-catalogue", "--class", "shelf", "--designs", "6", "--views", "4",
                        "-o", str(cls.folder / "views")], check=True, capture_output=True)

    def test_the_pool_gives_what_the_files_hold(self):
        import numpy as np
        import torch
        import data
        import stream
        views = data.Views([self.folder / "views"], "train")
        pool = stream.Pool(len(views) + 5, 0.0, torch.device("cpu"))
        pool.add(self.folder / "views")
        self.assertEqual(pool.seen, len(views))
        item = pool.batch(64, 0.0, np.random.default_rng(2))
        drawn = np.random.default_rng(2)
        numbers = drawn.integers(pool.rings["made"].count, size=64)
        flip = torch.from_numpy(drawn.random(64) < 0.5)
        expected = data.varied(views.crops(numbers), views.sketches(numbers), views.voxels(views.owner[numbers]), views.camera(numbers),
                               views.viewpoint(numbers), views.symmetry(numbers), flip, torch.zeros(64, dtype=bool))
        self.assertEqual(set(item), set(expected))
        for name, values in item.items():
            self.assertTrue(torch.equal(values, expected[name]), name)

    def test_old_views_go_when_new_ones_come(self):
        import torch
        import stream
        pool = stream.Pool(9, 0.0, torch.device("cpu"))
        for _ in range(3):
            pool.add(self.folder / "views")
        self.assertEqual(pool.rings["made"].count, 8)

    def test_renderers_that_fail_end_the_training(self):
        import time
        import stream
        renderers = stream.Renderers(lambda number, out: ["sh", "-c", "echo no disk >&2; exit 4"], self.folder / "shards", 1, 2)
        with self.assertRaises(SystemExit) as ended:
            for _ in range(200):
                renderers.take()
                time.sleep(0.01)
        self.assertIn("no disk", str(ended.exception))
        renderers.stop()

    def test_renderers_wait_for_who_takes(self):
        import time
        import stream
        renderers = stream.Renderers(lambda number, out: ["mkdir", str(out)], self.folder / "made", 1, 2, ahead=3)
        time.sleep(0.05)
        taken = []
        for _ in range(400):
            taken += [renderers.take()]
            time.sleep(0.002)
            self.assertLessEqual(len(renderers.ready) + len(renderers.running), 3)
        taken = [folder.name for folder in taken if folder]
        self.assertGreater(len(taken), 3)
        self.assertEqual(len(set(taken)), len(taken))
        renderers.stop()


@needs_torch
class CheckpointTest(unittest.TestCase):
    def test_a_training_goes_on_where_it_was(self):
        import copy
        import torch
        import checkpoint
        torch.manual_seed(3)
        make = lambda: torch.nn.Sequential(torch.nn.Linear(8, 16), torch.nn.BatchNorm1d(16), torch.nn.Linear(16, 1))
        adam = lambda model: torch.optim.AdamW(model.parameters(), lr=0.01)

        def learn(model, optimizer, steps):
            for _ in range(steps):
                loss = (model(given) - given.sum(1, keepdim=True)).square().mean()
                optimizer.zero_grad()
                loss.backward()
                optimizer.step()
            return float(loss.detach())

        given = torch.randn(64, 8)
        with tempfile.TemporaryDirectory() as name:
            folder, model = pathlib.Path(name), make()
            optimizer = adam(model)
            learn(model, optimizer, 30)
            mean = copy.deepcopy(model)
            checkpoint.write(folder, model, mean, optimizer, {"step": 30, "curve": [{"iou64": 0.5}]})
            model_2, mean_2 = make(), make()
            optimizer_2 = adam(model_2)
            state = checkpoint.read(folder, model_2, mean_2, optimizer_2, torch.device("cpu"))
            self.assertEqual(state, {"step": 30, "curve": [{"iou64": 0.5}]})
            for ours, theirs in zip(model.state_dict().values(), model_2.state_dict().values()):
                torch.testing.assert_close(theirs, ours, rtol=1e-3, atol=1e-4)
            # One that begins anew is far behind; one that goes on is level.
            went_on, came_back, anew = learn(model, optimizer, 20), learn(model_2, optimizer_2, 20), make()
            self.assertAlmostEqual(came_back, went_on, delta=0.05 * went_on + 1e-3)
            self.assertGreater(learn(anew, adam(anew), 20), 2 * went_on)


@needs_torch
class CutTest(unittest.TestCase):
    def test_voxels_within_reach_belong_together(self):
        """Against every pair of voxels; sparse grids have many components, one of them large enough to stay or none."""
        import numpy as np
        import torch
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components
        import cut
        random = np.random.default_rng(4)
        for share in (0.0002, 0.001, 0.005):
            solid = random.random((64, 64, 64)) < share
            solid[20:29, 30:36, 10:40] |= random.random((9, 6, 30)) < 0.5
            places = np.argwhere(solid)
            near = np.argwhere(np.abs(places[:, None] - places[None]).max(2) <= cut.REACH)
            links = coo_matrix((np.ones(len(near)), near.T), shape=(len(places),) * 2)
            expected = connected_components(links, directed=False)[1]
            found = cut.components(solid)
            self.assertTrue(((found > 0) == solid).all())
            pairs = np.unique(np.stack([expected, found[tuple(places.T)]], 1), axis=0)
            self.assertEqual([len(pairs)] * 2, [len(np.unique(column)) for column in pairs.T], share)
            large = np.bincount(expected) >= cut.SMALL_SHARE * len(places)
            kept = torch.zeros(64, 64, 64, dtype=torch.bool)
            kept[tuple(torch.from_numpy(places[large[expected]].T))] = True
            self.assertTrue(torch.equal(cut.without_small_components(torch.from_numpy(solid)), kept), share)


@needs_torch
class ScoresTest(unittest.TestCase):
    def test_networks_that_give_no_solid_have_no_distance(self):
        import scores
        self.assertIsNone(scores.mean_of_known([float("nan")] * 3))
        self.assertAlmostEqual(scores.mean_of_known([0.1, float("nan"), 0.3]), 0.2)


@needs_torch
class LossTest(unittest.TestCase):
    def test_the_derivative_is_that_of_the_value(self):
        import torch
        import train
        torch.manual_seed(1)
        logits = (2 * torch.randn(2, 64, 64, 64)).double().requires_grad_()
        truth, weights = (torch.rand(2, 64, 64, 64) > 0.7).double(), [1.0, 1.0, 1.0, 1.0]
        value, _ = train.Occupancy.apply(logits, truth, weights)
        value.backward()
        along = torch.randn_like(logits)
        step = 1e-4
        with torch.no_grad():
            ahead, behind = (float(train.Occupancy.apply(logits + sign * step * along, truth, weights)[0]) for sign in (1, -1))
        slope = float((logits.grad * along).sum())
        # The largest value of a line may change hands within the step.
        self.assertAlmostEqual((ahead - behind) / (2 * step), slope, delta=0.02 * abs(slope) + 1e-4)


if __name__ == "__main__":
    unittest.main(verbosity=1)
