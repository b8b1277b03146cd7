#!/usr/bin/env python3
"""Every command of README.md and docs is run, in a small world that is made for it; Python snippets as well.

    commands_test.py DEEPSLAM REPOSITORY

A command is a line of a fenced block that begins with a program's name, every line of a block marked `sh`, and every
`deepslam ...`, `scripts/...` between backticks. In words of capitals the world's own names are put (CAPTURE); of a|b|c
all are tried; what stands in brackets is left out, but its options must exist. Commands that install, build or take long
are on the list DRY, with the reason: of these the program and its options must exist. What is neither run nor on the
list is a fault, and so are paths of the repository that are not there and quoted messages that the program has not.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import python_packages  # noqa: E402

python_packages.need("numpy")  # of the Python package
PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
REPOSITORY = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path[:0] = [str(REPOSITORY / "tests/end_to_end"), str(REPOSITORY / "python/src")]
import captures  # noqa: E402

DATA = pathlib.Path(os.environ.get("XDG_DATA_HOME") or pathlib.Path.home() / ".local/share") / "deepslam"

# Programs whose name at the beginning of a line makes it a command.
PROGRAMS = r"(deepslam(-[a-z-]+)?|scripts/\S+|python3|pip|cmake|ctest|apt|apt-get|dpkg|evo_\w+|source|man|cpack|build/\S+)"

# Not run: regular expression -> reason. The program must exist, and its options stand in its help.
DRY = {
    r"scripts/(demo|test|setup|package|test_package|test_container|build|build_time)\.sh\b": "installs, builds or takes minutes",
    r"scripts/sanitizers\.sh\b": "builds for minutes; .ci/run calls it behind the tests",
    r"scripts/bench\.sh\b": "measures for a quarter of an hour, on a machine left alone",
    r"scripts/fuzz\.sh\b": "installs, builds and runs for hours; ctest replays what it found (fuzz)",
    r"python3 tests/tools/(kill|fault)_test\.py ": "ctest runs them with fewer trials (kill, faults)",
    r"deepslam-demo\b": "renders and reconstructs 120 frames; scripts/test_package.sh runs it",
    r"scripts/experiments/(run|loops|table1|one_sided|layouts|homes|recorded)\.py\b": "takes hours",
    r"scripts/experiments/wall_planes\.py\b": "needs Pillow; ctest runs it (layouts_experiment)",
    r"scripts/experiments/halves\.py\b": "wants a real capture; ctest runs it on one (real_capture)",
    r"python3 tests/end_to_end/golden_demo_test\.py ": "wants a build by another compiler; ctest runs it with this one (golden_demo)",
    r"python3 tests/end_to_end/two_builds\.py ": "wants a build by another compiler; ctest runs it with this one (two_builds)",
    r"scripts/(compare_open3d|open3d_reconstruction)\.py\b": "minutes, and needs another program",
    r"scripts/train/train\.sh\b": "trains for hours",
    r"deepslam library build -o my_library\b": "a library of two models; ctest makes one (cli)",
    r"deepslam run .*propose\.library=my_library": "wants that library",
    r"scripts/train/gpu\.sh\b": "packs or trains for minutes; ctest runs its parts (training_kit)",
    r"scripts/path_agreement\.py\b": "needs packages of PyPI",
    r"scripts/import_recording\.py\b": "needs packages of PyPI; ctest runs it where they are (import_recording)",
    r"deepslam priors look ": "needs an object of a class with networks; the world has tables",
    r"scripts/measure_noise\.py\b": "takes minutes; ctest runs it (noise_statistics)",
    r"deepslam synth configs/scenes/\S+( --rung \S+)? -o \S+$": "renders 120 frames; the world's capture is of the same kind",
    r"scripts/python_docs\.py\b": "writes the page; ctest looks whether it is current (python_package)",
    r"deepslam batch .*--engine slurm": "needs a cluster; ctest runs it (slurm)",
    r"deepslam batch --keep final$": "named in a sentence; the batch test runs it",
    r"deepslam library (build --force|split)$": "reads the whole catalogue, half a minute",
    r"python3 tests/(bench|graph)/": "a measurement of minutes, or needs another solver; ctest runs it where it can",
    r"(cmake|ctest|cpack|python3 -m) ": "builds; ctest itself builds and installs (installed)",
    r"(pip|apt|apt-get|dpkg) ": "changes this machine",
    r"evo_(ape|rpe) ": "another program, whose figures are in the table there",
}

# Words of a command -> what the world has.
WORLD = {
    "CAPTURE": "capture", "IN": "capture", "WORKSPACE": "workspace", "TRUTH": "capture", "SCENE.yaml": "scene.yaml",
    "ESTIMATE": "workspace/optimize/trajectory.tum", "redkitchen": "capture", "fr3_cabinet": "capture",
    "redkitchen/groundtruth.txt": "capture/groundtruth.txt", "FILE.onnx": "data/weights/yolo11n.onnx", "PREFIX": "prefix",
    "FILE": "corrections.yaml", "COMMAND": "run", "scene.glb": "workspace/export/scene.glb",
    "SCENE.glb": "workspace/export/scene.glb", "DIR": "data",
}


def in_world(word):
    """WORKSPACE/track/trajectory.tum as well."""
    first, slash, rest = word.partition("/")
    return WORLD.get(word) or WORLD.get(first, first) + slash + rest


def expand_alternatives(words):
    """a|b|c in one word: all of them."""
    for i, word in enumerate(words):
        if re.fullmatch(r"[\w.-]+(\|[\w.-]+)+", word):
            return [line for choice in word.split("|") for line in expand_alternatives([*words[:i], choice, *words[i + 1:]])]
    return [words]


class Command:
    def __init__(self, text, place, shell=False, inline=False):
        self.text, self.place, self.shell, self.inline = text, place, shell, inline

    def __str__(self):
        return f"{self.place}: {self.text.splitlines()[0]}"


def uncommented(line):
    """The line without its comment, where `#` stands outside of quotes."""
    quote = None
    for i, char in enumerate(line):
        if quote:
            quote = None if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char == "#" and (i == 0 or line[i - 1].isspace()):
            return line[:i].rstrip()
    return line.rstrip()


def whole(lines):
    """Takes lines off the front until they make a whole command: quotes closed, here-documents ended."""
    text = uncommented(lines.pop(0)).strip()
    end = re.search(r"<<'?(\w+)'?$", text)
    while end and lines:
        line = lines.pop(0)
        text += "\n" + line
        if line == end[1]:
            break
    while lines and (text.endswith("\\") or unclosed(text)):
        text = text.removesuffix("\\") + "\n" * unclosed(text) + lines.pop(0)
    return text


def unclosed(text):
    try:
        shlex.split(text)
    except ValueError:
        return True
    return False


def read_page(text, name):
    """Commands and Python snippets of a page, in order."""
    found, lines, number = [], text.splitlines(), 0
    while number < len(lines):
        fence = re.match(r"```(\w*)", lines[number])
        if not fence:
            for span in re.findall(r"`([^`]+)`", lines[number]):
                if re.match(r"(deepslam(-[a-z-]+)?|scripts/[\w/.]+\.(sh|py))( |$)", span):
                    found.append(Command(span, f"{name}:{number + 1}", inline=True))
            number += 1
            continue
        end = lines.index("```", number + 1)
        block, place = lines[number + 1:end], f"{name}:{number + 2}"
        if fence[1] == "python":
            found.append(("python", "\n".join(block), place))
        elif fence[1] in ("", "sh"):
            while block:
                if not uncommented(block[0]).strip() or not (fence[1] == "sh" or re.match(PROGRAMS + "( |$)", block[0])):
                    block.pop(0)
                    continue
                at = end - len(block) + 1
                found.append(Command(whole(block), f"{name}:{at}", shell=True))
        number = end + 1
    return found


class World:
    """A folder with captures, a workspace and lists under the names that the pages use."""

    def __init__(self, folder):
        self.folder, self.made = folder, 0
        (folder / "bin").mkdir()
        for name, target in (("deepslam", PROGRAM), ("deepslam-tools", PROGRAM.with_name("deepslam-tools")),
                             ("deepslam-views", PROGRAM.with_name("deepslam-views")),
                             ("deepslam-demo", REPOSITORY / "scripts/sample.sh"),
                             ("deepslam-fetch-weights", REPOSITORY / "scripts/fetch_weights.sh")):
            (folder / "bin" / name).symlink_to(target)
        for name in ("configs", "scripts", "tests", "examples"):
            (folder / name).symlink_to(REPOSITORY / name)
        # The furniture library is copied, as commands may write it.
        (folder / "data").mkdir()
        (folder / "data/weights").symlink_to(DATA / "weights")
        shutil.copytree(DATA / "library", folder / "data/library")
        for name in DATA.glob("library.made_from"):
            shutil.copy(name, folder / "data")
        self.environment = dict(os.environ, PATH=f"{folder}/bin:{os.environ['PATH']}", DEEPSLAM_DATA=str(folder / "data"),
                                XDG_CACHE_HOME=str(folder / "cache"))
        os.environ.update(DEEPSLAM=str(PROGRAM), DEEPSLAM_DATA=str(folder / "data"))  # for snippets of Python
        (folder / "scene.yaml").write_text(captures.SCENE)
        self.check("deepslam synth scene.yaml -o capture")
        self.check("deepslam run capture -o workspace --progress none")
        shutil.copy(folder / "workspace/export/map.json", folder / "map.json")
        (folder / "rooms.txt").write_text("capture kitchen\ncapture office\n")
        (folder / "corrections.yaml").write_text("version: 1\n")

    def run(self, text):
        return subprocess.run(["bash", "-c", "set -e\n" + text], cwd=self.folder, env=self.environment, capture_output=True,
                              text=True, errors="replace", timeout=600)

    def check(self, text):
        result = self.run(text)
        assert result.returncode == 0, f"`{text}` ended with {result.returncode}: {(result.stderr or result.stdout)[-800:]}"

    def fresh(self, name):
        self.made += 1
        return f"made{self.made}/{name}"


def program_of(words, world):
    """The program's file; a fault where there is none."""
    if "/" in words[0]:
        file = world.folder / words[0]
        assert file.is_file(), f"no file {words[0]}"
        return file
    return shutil.which(words[0], path=world.environment["PATH"])


def check_options(words, world):
    """The program is there, and --options of the command stand in its help."""
    file = program_of(words, world)
    options = [word.partition("=")[0].strip("[].,") for word in words if re.match(r"\[?--\w", word)]
    if "--" in words:
        options = [option for option in options if option in words[:words.index("--")]]
    if words[0] == "deepslam":
        path = [word for word in words[1:3] if re.fullmatch(r"[a-z]+", word)]
        while path and world.run(shlex.join(["deepslam", *path, "--help"])).returncode:
            path.pop()
        told = world.run(shlex.join(["deepslam", *path, "--help"]))
        assert path or len(words) == 1 or words[1].startswith("-") or words[1] == "COMMAND", f"no command {words[1]}"
    elif words[0].startswith(("scripts/", "deepslam-")):
        told = world.run(shlex.join([str(file), "--help"]))
        assert told.returncode == 0, f"{words[0]} --help ended with {told.returncode}"
    elif words[0] == "python3" and words[1].endswith(".py"):
        told = world.run(shlex.join([*words[:2], "--help"]))
        assert told.returncode == 0, f"{words[1]} --help ended with {told.returncode}"
    else:
        return
    for option in options:
        assert re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", told.stdout), f"{words[0]} has no option {option}"


def bare_mention(words):
    return words[0].startswith("scripts/") and len(words) == 1 or words[0].startswith("deepslam") and all(
        re.fullmatch(r"[a-z]+", word) for word in words[1:])


def check_command(command, world):
    text = re.sub(r" -- (.*)", "", command.text) if command.text.startswith("scripts/experiments") else command.text
    for pattern in DRY:
        if re.match(pattern, text):
            check_options(shlex.split(text), world)
            return "dry"
    if command.inline:
        words = shlex.split(text)
        if bare_mention(words):  # a name in a sentence, not a call
            if words[0].startswith("scripts/"):
                program_of(words, world)
            else:
                check_options(words, world)
            return "named"
    elif not text.startswith("deepslam ") or re.search(r"[<>;&$]|\n", text):
        world.check(text)
        return "run"
    words = shlex.split(text)
    bracketed = re.findall(r"\[([^\]]*)\]", text)
    check_options(words[:3] + [word for part in bracketed for word in part.split()], world)
    words = shlex.split(re.sub(r"\[[^\]]*\](\.\.\.)?|(?<= )\.\.\.", "", text))
    for line in expand_alternatives(words):
        line = [in_world(word) for word in line]
        if line[1:3] == ["eval", "trajectory"]:
            line = ["capture/groundtruth.txt" if word == "capture" else word for word in line]
        if line[1] == "expand":
            line = [word for word in line if word not in ("--library", "data")]
        if len(line) == 3 and line[1] == "run" and line[2] != "--help":
            line += ["-o", "workspace"]
        if "OUT" in line or line[1] == "synth":
            out = world.fresh("sample.sens" if "scannet" in line else "out")
            if "OUT" in line:
                line[line.index("OUT")] = out
            else:
                line[line.index("-o") + 1:line.index("-o") + 2] = [out]
        if line[1] == "convert" and "--to" not in line:
            line += [world.fresh("out"), "--to", "tum"]
        if line[1] == "run" and "--overrides" in line and len(line) == 4:
            line[2:2] = ["capture", "-o", "workspace"]
        world.check(shlex.join(line))
    return "run"


def check_page(text, name, world):
    """Faults of a page, and how many commands were treated how."""
    faults, counts, names = [], {}, {}
    os.chdir(world.folder)
    for item in read_page(text, name):
        try:
            if isinstance(item, tuple):
                kind = "python"
                exec(compile(item[1], item[2], "exec"), names)  # noqa: S102
            else:
                kind = check_command(item, world)
            counts[kind] = counts.get(kind, 0) + 1
        except Exception as fault:  # noqa: BLE001
            faults.append(f"{item if isinstance(item, Command) else item[2]}: {type(fault).__name__}: {fault}")
    return faults, counts


PAGES = ["README.md", *sorted(str(path.relative_to(REPOSITORY)) for path in (REPOSITORY / "docs").rglob("*.md"))]


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temp = tempfile.TemporaryDirectory(prefix="deepslam-docs-")
        cls.world = World(pathlib.Path(cls.temp.name).resolve())

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.temp.cleanup()

    def test_every_command_of_every_page(self):
        for name in PAGES:
            with self.subTest(page=name):
                faults, counts = check_page((REPOSITORY / name).read_text(), name, self.world)
                print(name, counts, file=sys.stderr)
                self.assertFalse(faults, "\n" + "\n".join(faults))

    def test_a_wrong_page_is_found_out(self):
        for text, expected in (
                ("```sh\ndeepslam status workspace --verbos\n```\n", "verbos"),
                ("```\ndeepslam rnu capture -o workspace\n```\n", "no command rnu"),
                ("text `deepslam convert capture OUT --to tum|obj`", "obj"),
                ("```\nscripts/test.sh --presett dev\n```\n", "no option --presett"),
                ("see `scripts/nothing.sh`", "no file"),
                ("```sh\nfrobnicate\n```\n", "frobnicate"),
                ("```python\nopen('workspace/export/nothing.json')\n```\n", "nothing.json")):
            faults, _ = check_page(text, "page", self.world)
            self.assertEqual(len(faults), 1, text)
            self.assertIn(expected, faults[0])

    def test_paths_exist(self):
        wrong = []
        for name in PAGES:
            for number, line in enumerate((REPOSITORY / name).read_text().splitlines(), 1):
                for path in re.findall(r"`((?:src|docs|tests|configs|scripts|cmake|examples|tools)/[\w./-]+)`", line):
                    if "NAME" not in path and not (REPOSITORY / path).exists():
                        wrong.append(f"{name}:{number}: {path}")
                for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", line):
                    if not ((REPOSITORY / name).parent / link).exists():
                        wrong.append(f"{name}:{number}: {link}")
        self.assertFalse(wrong, wrong)

    def test_quoted_messages_are_the_programs(self):
        page = (REPOSITORY / "docs/guides/own_capture.md").read_text()
        messages = re.findall(r"^\| `([^`]+)` \|", page, re.M)
        self.assertGreater(len(messages), 5)
        sources = "".join(path.read_text() for path in (REPOSITORY / "src").rglob("*.cc"))
        for message in messages:
            self.assertIn(message, sources)


if __name__ == "__main__":
    if not (DATA / "library/library.json").is_file() or not (DATA / "weights/yolov8s.onnx").is_file():
        print("needs weights and furniture library: scripts/setup.sh, scripts/furniture.sh: skipped", file=sys.stderr)
        sys.exit(77)
    unittest.main(warnings="ignore")  # the snippets leave closing of files to Python
