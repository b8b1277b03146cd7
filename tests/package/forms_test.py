#!/usr/bin/env python3
"""Man page and completions against what --help says: every command and option is in all of them.

    forms_test.py DEEPSLAM
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()


def output(*command, **options):
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, **options)
    assert result.returncode == 0, f"{command}: {result.stderr}"
    return result.stdout


def crawl(path=()):
    """Commands by --help: path -> (names of options, names of commands below)."""
    text = output(PROGRAM, *path, "--help")
    below = re.findall(r"^  (\w[\w-]*) ", text.partition("\nSubcommands:\n")[2], re.M)
    options = []
    for names in re.findall(r"^  (-\S+)", text, re.M):
        options += [name for name in names.split(",") if name.startswith("-")]
    found = {path: (options, below)}
    for name in below:
        found.update(crawl((*path, name)))
    return found


COMMANDS = crawl()


class Forms(unittest.TestCase):
    def test_help_was_understood(self):
        self.assertIn(("eval", "objects"), COMMANDS)
        self.assertIn("--output", COMMANDS[("run",)][0])
        self.assertGreater(len(COMMANDS), 20)

    def test_man_page_has_every_command_and_option(self):
        if shutil.which("man") is None:
            self.skipTest("needs man: scripts/setup.sh --tests")
        with tempfile.TemporaryDirectory(prefix="deepslam-man-") as folder:
            file = pathlib.Path(folder) / "deepslam.1"
            file.write_text(output(PROGRAM, "man"))
            made = subprocess.run(["man", "--warnings", "-E", "ascii", "-Tascii", "-P", "cat", "-l", str(file)],
                                  capture_output=True, text=True, env={**os.environ, "MANWIDTH": "200", "GROFF_NO_SGR": "1"})
            self.assertEqual((made.returncode, made.stderr), (0, ""))
        text = re.sub(".\b", "", made.stdout)
        parts = re.split(r"^   deepslam (.+)$", text, flags=re.M)
        sections = dict(zip((tuple(name.split()) for name in parts[1::2]), parts[2::2]))
        sections[()] = parts[0]
        self.assertEqual(set(sections), set(COMMANDS))
        for path, (options, _) in COMMANDS.items():
            for option in options:
                where = () if option in ("-h", "--help", "--help-all") else path
                self.assertRegex(sections[where], rf"(?m)^ .*(?<!\S){re.escape(option)}(?![\w-])", f"{path}")

    def complete(self, *lines):
        """What bash offers for each line, a tuple of words of which the last is being written."""
        script = 'source <("$0" completion bash)\n'
        for words in lines:
            quoted = " ".join("'" + word + "'" for word in words)
            script += f'COMP_WORDS=(deepslam {quoted}); COMP_CWORD={len(words)}; _deepslam; echo "${{COMPREPLY[*]}}"\n'
        return [line.split() for line in output("bash", "--norc", "-c", script, PROGRAM).splitlines()]

    def test_bash_offers_every_command_and_option(self):
        paths = list(COMMANDS)
        for path, offered in zip(paths, self.complete(*((*path, "-") for path in paths))):
            self.assertEqual(sorted(offered), sorted(COMMANDS[path][0]), path)
        nodes = [path for path in paths if COMMANDS[path][1]]
        for path, offered in zip(nodes, self.complete(*((*path, "") for path in nodes))):
            self.assertEqual(sorted(offered), sorted(COMMANDS[path][1]), path)

    def test_bash_offers_values(self):
        poses, to, equals, setting, choice, flag = self.complete(
            ("run", "x", "--poses", ""), ("convert", "a", "b", "--to", "s"), ("convert", "--to", "=", "o"),
            ("run", "--set", "track.po"), ("run", "--set", "detect.source", "=", "n"), ("run", "--set", "track.photometric", "=", ""))
        self.assertEqual(poses, ["track", "capture", "prior"])
        self.assertEqual(to, ["scannet"])
        self.assertEqual(equals, ["open3d"])
        self.assertEqual(setting, ["track.poses="])
        self.assertEqual(sorted(choice), ["network", "none"])
        self.assertEqual(sorted(flag), ["false", "true"])

    def test_settings_are_those_of_the_configuration(self):
        names, section = set(), ""
        for line in output(PROGRAM, "config", "dump").splitlines():
            match = re.match(r"( *)(\w+):", line)
            if match:
                depth = len(match[1]) // 2
                section = ".".join([*section.split(".")[:depth], match[2]]) if depth else match[2]
                if re.match(r" *\w+: +\S", line):
                    names.add(section + "=")
        self.assertGreater(len(names), 100)
        self.assertEqual(set(self.complete(("run", "--set", ""))[0]), names)

    def test_zsh_and_fish_have_every_command_and_option(self):
        for shell in ("zsh", "fish"):
            text = output(PROGRAM, "completion", shell)
            for path, (options, commands) in COMMANDS.items():
                for option in options:
                    shown = f"'{option}:" if shell == "zsh" else (" -l " + option[2:] if option[:2] == "--" else " -s " + option[1:])
                    self.assertIn(shown, text, path)
                for name in commands:
                    self.assertIn(f"'{name}:" if shell == "zsh" else f" -a {name} ", text)
            if shutil.which(shell):
                output(shell, "-n", "/dev/stdin", input=text)


if __name__ == "__main__":
    unittest.main()
