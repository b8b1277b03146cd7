#!/usr/bin/env python3
"""The report's page as a browser shows it, opened from disk without a network.

    report_test.py PAGE_WRITER FOLDER       PAGE_WRITER FILE writes a page; picture and page stay in FOLDER/report_page
    report_test.py --page PAGE FOLDER       the same checks on a page that is there already

Exit code 77: node, playwright-core or Chromium is missing (scripts/setup.sh --tests).
"""
import os
import pathlib
import shutil
import subprocess
import sys

SKIPPED = 77
TIMING = ('<script>parent.postMessage({deepslamTiming: [{"stage": "track", "wall_s": 2, "cpu_s": 2, "peak_mb": 100, '
          '"reused": false}]}, "*")</script>\n')


def find_modules():
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "deepslam" / "node"
    for modules in sorted(cache.glob("*/node_modules")):
        if (modules / "playwright-core" / "package.json").exists():
            return modules
    return None


def find_browser():
    names = [os.environ.get("CHROMIUM"), "chromium", "chromium-browser", "google-chrome"]
    return next(filter(None, (shutil.which(name) for name in names if name)), None)


def write_page(writer, page, *arguments):
    page.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([writer, page, *arguments], check=True, timeout=1200)
    return page


def made_pages(writer, folder):
    room = write_page(writer, folder / "workspace" / "report" / "index.html")
    first = room.read_bytes()
    write_page(writer, room)
    assert room.read_bytes() == first, "two pages of one content differ"
    (room.parent.parent / "timing.html").write_text(TIMING)
    return {"room": room, "hall": write_page(writer, folder / "hall" / "index.html", "1000"),
            "empty": write_page(writer, folder / "empty" / "index.html", "0")}


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "--page":
        given, target = pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    elif len(sys.argv) == 3:
        given, target = None, sys.argv[2]
    else:
        print(__doc__, file=sys.stderr)
        return 2
    modules, browser = find_modules(), find_browser()
    if not modules or not browser or not shutil.which("node"):
        print("skipped: needs node, playwright-core and Chromium: scripts/setup.sh --tests")
        return SKIPPED
    folder = (pathlib.Path(target) / "report_page").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    pages = {"room": given} if given else made_pages(sys.argv[1], folder)
    pages["copied"] = folder / "copied" / "alone" / "page.html"
    pages["copied"].parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(pages["room"], pages["copied"])
    script = pathlib.Path(__file__).resolve().with_name("report_test.cjs")
    environment = dict(os.environ, DEEPSLAM_NODE_MODULES=str(modules), DEEPSLAM_BROWSER=browser)
    arguments = [f"{kind}={page}" for kind, page in pages.items()]
    done = subprocess.run(["node", script, folder, *arguments], env=environment, timeout=1200)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
