#!/usr/bin/env python3
"""Writes docs/python.md out of the docstrings of the Python package; ctest holds the page against them.

    scripts/python_docs.py [--check]      --check: writes nothing; exit code 1 where the page is not what the docstrings say

Fields are told by the comment behind them, properties and functions by their docstrings. Needs numpy, as the package does.
"""
import argparse
import ast
import inspect
import pathlib
import re
import sys
import textwrap

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "python" / "src"))
PAGE = REPOSITORY / "docs" / "python.md"
HEAD = """# Python

This page is written by `scripts/python_docs.py` out of the docstrings of the package in `python/`.

```
pip install ./python            # in the repository; "./python[mesh]" brings trimesh, "./python[rerun]" rerun-sdk
```

Python 3.11 or newer, on numpy alone, typed throughout. `python3 -m deepslam.check PATH ...` reads whole workspaces, maps and
scene graphs and says what is wrong with them (exit code 3).
"""
# Sections of the page, in order; names that __all__ has and no section names are a fault.
SECTIONS = {
    "Opening and running": ["open", "run", "expand", "find_program", "open_batch"],
    "The map": ["Scene", "SceneObject", "OrientedBox", "Mesh"],
    "The room": ["Layout", "Room", "Wall", "Opening"],
    "The camera path": ["Trajectory"],
    "Why things are as they are": ["Candidate", "Proposal", "Relation", "Label"],
    "Runs and batches": ["Progress", "RunResult", "Batch", "BatchCapture"],
    "What can go wrong": ["Error", "ProgramError", "RunFailed", "UsageError", "InputUnusable", "Interrupted", "ProgramMissing"],
}
LONGEST_LINE = 110
TYPES = {"Floats": "array", "Ints": "array of int", "Bytes": "array of bytes", "npt.NDArray[np.bool_]": "array of bool",
         "npt.NDArray[np.int64]": "array of int", "npt.ArrayLike": "array", "str | os.PathLike[str]": "path", "StrPath": "path",
         "pathlib.Path": "Path"}


def type_text(annotation):
    """An annotation as people read it."""
    text = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))
    for name, words in TYPES.items():
        text = text.replace(name, words)
    return re.sub(r"\b(program|scene|collections\.abc)\.", "", text)


def paragraphs(docstring):
    """Markdown of a docstring: indented parts are code of Python, or calls in a shell."""
    lines = []
    for block in re.split(r"\n\n+(?=\S)|\n\n+(?= {4})", inspect.cleandoc(docstring or "")):
        if block.startswith("    "):
            lines += ["```python", textwrap.dedent(block), "```", ""]
        else:
            lines += [block, ""]
    return "\n".join(lines) + "\n"


def signature_text(function):
    """Its call without what stands for the object itself, a parameter a line where one line would be long."""
    parts, star = [], False
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name == "self":
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not star:
            parts.append("*")
            star = True
        text = f"{parameter.name}: {type_text(parameter.annotation)}"
        parts.append(text if parameter.default is parameter.empty else f"{text} = {parameter.default!r}")
    returned = inspect.signature(function).return_annotation
    arrow = "" if returned in (inspect.Signature.empty, "None", None) else f" -> {type_text(returned)}"
    text = f"{function.__name__}({', '.join(parts)}){arrow}"
    if len(text) > LONGEST_LINE:
        text = f"{function.__name__}(\n" + "".join(f"    {part},\n" for part in parts) + f"){arrow}"
    return f"```text\n{text}\n```\n\n"


def fields_of(kind):
    """Name -> (type, what the comment behind it says), of a class and its bases: fields, and what __init__ sets of itself."""
    fields = {}
    for each in reversed(kind.__mro__[:-1]):
        lines = textwrap.dedent(inspect.getsource(each)).splitlines()
        body = ast.parse("\n".join(lines)).body[0].body
        body += next((node.body for node in body if isinstance(node, ast.FunctionDef) and node.name == "__init__"), [])
        for node in body:
            if isinstance(node, ast.AnnAssign):
                name = node.target.id if isinstance(node.target, ast.Name) else node.target.attr
                behind = re.search(r"  # (.*)$", lines[node.end_lineno - 1])
                fields[name] = (type_text(ast.unparse(node.annotation)), behind[1] if behind else "")
    return {name: field for name, field in fields.items() if not name.startswith("_")}


def rows_of(kind):
    """(name, type, meaning) of what a class has as values."""
    for name, (what, meaning) in fields_of(kind).items():
        yield name, what, meaning
    for name, member in inspect.getmembers(kind):
        wrapped = getattr(member, "fget", None) or getattr(member, "func", None)
        if not name.startswith("_") and wrapped is not None:
            meaning = " ".join((inspect.getdoc(wrapped) or "").split())
            yield name, type_text(inspect.signature(wrapped).return_annotation), meaning


def sentence(text):
    """In a table: begins with a capital, ends without a full stop."""
    return (text[:1].upper() + text[1:]).removesuffix(".")


def class_part(name, kind):
    bases = [base.__name__ for base in kind.__bases__ if issubclass(base, Exception)]
    text = f"### {name}" + (f" ({bases[0]})" if bases else "") + f"\n\n{paragraphs(kind.__doc__)}"
    rows = [] if issubclass(kind, Exception) else list(rows_of(kind))
    if silent := [row for row, _, meaning in rows if not meaning]:
        sys.exit(f"python_docs: {name} says nothing of: {', '.join(silent)}")
    if rows:
        text += "| value | type | meaning |\n|---|---|---|\n"
        text += "".join(f"| `{row}` | {what.replace('|', 'or')} | {sentence(meaning)} |\n" for row, what, meaning in rows) + "\n"
    if issubclass(kind, Exception):
        return text
    for method, member in inspect.getmembers(kind, inspect.isfunction):
        if not method.startswith("_") and method in field_owner(kind):
            text += f"{signature_text(member)}{paragraphs(member.__doc__)}\n"
    return text


def field_owner(kind):
    """Names that the class or its bases of the package define."""
    return {name for each in kind.__mro__ if each.__module__.startswith("deepslam") for name in vars(each)}


def page_text():
    import deepslam

    listed = [name for names in SECTIONS.values() for name in names]
    if sorted(listed) != sorted(deepslam.__all__):
        sys.exit(f"python_docs: sections and __all__ differ in {sorted(set(listed) ^ set(deepslam.__all__))}")
    text = HEAD + "\n" + paragraphs(deepslam.__doc__)
    for section, names in SECTIONS.items():
        text += f"## {section}\n\n"
        for name in names:
            what = getattr(deepslam, name)
            if inspect.isclass(what):
                text += class_part(name, what)
            else:
                text += f"### {name}\n\n{signature_text(what)}{paragraphs(what.__doc__)}"
    return re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only look whether the page is what the docstrings say")
    arguments = parser.parse_args()
    text = page_text()
    if not arguments.check:
        PAGE.write_text(text)
    elif not PAGE.exists() or PAGE.read_text() != text:
        sys.exit(f"python_docs: {PAGE} is not what the docstrings say; run scripts/python_docs.py")


if __name__ == "__main__":
    main()
