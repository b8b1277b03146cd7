#!/usr/bin/env python3
"""Figures of how much there is to learn: options, constants, words of documents, coined terms.

    scripts/words.py [REPOSITORY]            prints them
    scripts/words.py --list [REPOSITORY]     names what each figure counts: options, constants, places of coined terms
    scripts/words.py --check [REPOSITORY]    fails where a limit below is passed; ctest runs this

The limits are what has been reached: they are lowered, and raised only by what a new format, class or option needs.
"""
import argparse
import pathlib
import re
import sys

LIMITS = {
    "options": 125,
    "options that nobody sets": 21,
    "constants without a comment": 0,
    "words of documents": 24900,
    "lines of tracking and alignment": 6766,
    "coined terms": 39,
}

# Coined here -> what the field says. A pattern is matched against words of code (also within names) and of documents.
GLOSSARY = [
    (r"\banchors?\b|[aA]nchor(ed|_)", "reference frame"),
    (r"texels?", "pixel"),
    (r"\bdescents?\b", "Gauss-Newton iterations"),
    (r"\bway_left|\bway left\b", "convergence estimate"),
    (r"shelved|\bshelf of\b", "out-of-core"),
    (r"crumbs?", "small components"),
    (r"stretches\b", "sub-trajectories"),
    (r"\bsights?\b|\bSights?\b|_sights?\b", "observation"),
    (r"\bvisits\b|\bVisits?\b|\bthe visit\b|\bvisits?_", "re-observation"),
    (r"known again|KnownAgain|known_again", "re-identified"),
    (r"measured again|MeasuredAgain", "re-registered"),
    (r"intruders?", "duplicate landmark"),
    (r"\bcontests?\b", "candidate set"),
    (r"[hH]andicap", "penalty"),
    (r"_lead\b|\bLead\(|\ba lead\b|\bhas to lead\b", "margin"),
    (r"likeness|Likeness", "patch-wise ZNCC"),
    (r"\badrift\b", "unconnected sub-trajectory"),
    (r"carrying[_ ]edges|CarryingEdges", "subgraph preconditioner"),
    (r"level[_ ]tops?\b|LevelTop", "support plane"),
    (r"[bB]rightness", "intensity"),
    (r"\btwins?\b|_twins?\b|Twin\b", "uncompressed copy"),
    (r"\bjudges?\b|\bjudged\b|Judge[A-Z]", "score"),
    (r"\bbelieved?\b", "accept"),
]

CODE = ("src", "tools", "tests", "scripts", "python", "cmake")
CODE_ENDINGS = {".h", ".cc", ".py", ".sh", ".txt", ".cmake", ".yaml", ".js"}
NUMBER = r"constexpr (?:double|float|int|bool|std::size_t|size_t|std::u?int\d+_t|unsigned|auto) k\w+ ?(?:=|\{)[^;\"]*\d[^;\"]*;"


def read(path):
    return path.read_text(encoding="utf-8", errors="replace")


def files_of(root, folders, endings):
    found = []
    for folder in folders:
        found += [path for path in (root / folder).rglob("*") if path.suffix in endings and path.is_file()]
    return sorted(path for path in found if "corpus" not in path.parts and "__pycache__" not in path.parts)


def options_of(root):
    """Dotted names out of configs/default.yaml, which the program writes itself."""
    names, open_maps = [], []
    for line in read(root / "configs/default.yaml").splitlines():
        match = re.match(r"( *)(\w+):(.*)", line)
        if not match:
            continue
        del open_maps[len(match[1]) // 2:]
        if match[3].strip():
            names.append(".".join([*open_maps, match[2]]))
        else:
            open_maps.append(match[2])
    return names


def unset_options(root, names):
    """Those whose last name stands in no document, configuration, script or test."""
    paths = [root / "README.md", *files_of(root, ("docs", "configs", "scripts", "tests", "python", "examples"),
                                           CODE_ENDINGS | {".md", ".json"})]
    words = set()
    for path in paths:
        if path.name != "default.yaml":
            words |= set(re.findall(r"\w+", read(path)))
    return [name for name in names if name.split(".")[-1] not in words]


def uncommented_constants(root):
    """Numeric constants of sources with no comment on their lines or above them."""
    found = []
    for path in files_of(root, ("src", "tools"), {".h", ".cc"}):
        text = read(path)
        for match in re.finditer(NUMBER, text):
            begin = text.rfind("\n", 0, match.start()) + 1
            above = text[text.rfind("\n", 0, max(begin - 1, 0)) + 1:begin]
            rest = text[match.start():text.find("\n", match.end())]
            if "//" not in rest and not above.lstrip().startswith("//"):
                number = text.count("\n", 0, match.start()) + 1
                found.append(f"{path.relative_to(root)}:{number}: {' '.join(match[0].split())}")
    return found


def words_of_documents(root):
    """page -> words: what has a letter, so that bars and figures of tables do not count"""
    pages = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    return {str(page.relative_to(root)): len(re.findall(r"\S*[A-Za-z]\S*", read(page))) for page in pages}


def coined_terms(root):
    found = []
    paths = files_of(root, CODE, CODE_ENDINGS) + [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    for path in paths:
        if path == pathlib.Path(__file__).resolve():
            continue
        for number, line in enumerate(read(path).splitlines(), 1):
            for pattern, standard in GLOSSARY:
                for match in re.finditer(pattern, line):
                    found.append(f"{path.relative_to(root)}:{number}: {match[0]} ({standard})")
        for pattern, standard in GLOSSARY:
            if re.search(pattern, path.stem):
                found.append(f"{path.relative_to(root)}: file name ({standard})")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="fail where a limit is passed")
    parser.add_argument("--list", action="store_true", help="name what each figure counts")
    parser.add_argument("repository", nargs="?", default=".")
    arguments = parser.parse_args()
    root = pathlib.Path(arguments.repository).resolve()
    names = options_of(root)
    pages = words_of_documents(root)
    lines = [f"{path.relative_to(root)}: {read(path).count(chr(10))}"
             for path in files_of(root, ("src/deepslam/tracking", "src/deepslam/alignment"), {".h", ".cc"})]
    lists = {
        "options": names,
        "options that nobody sets": unset_options(root, names),
        "constants without a comment": uncommented_constants(root),
        "words of documents": [f"{page}: {count}" for page, count in pages.items()],
        "lines of tracking and alignment": lines,
        "coined terms": coined_terms(root),
    }
    sums = {"words of documents", "lines of tracking and alignment"}
    faults = []
    for name, items in lists.items():
        figure = sum(int(item.rsplit(" ", 1)[1]) for item in items) if name in sums else len(items)
        print(f"{figure:6} of {LIMITS[name]:6}  {name}")
        if arguments.list:
            print("".join(f"          {item}\n" for item in items), end="")
        if figure > LIMITS[name]:
            faults.append(f"{name}: {figure}, at most {LIMITS[name]} (scripts/words.py --list names them)")
    if arguments.check:
        print("\n".join(faults) if faults else "no fault")
        return 1 if faults else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
