#!/usr/bin/env python3
"""Time from asking for a report page until its 3D view has drawn the scene, in headless Chromium with software rendering.

    first_picture.py PAGE [RUNS]

Prints every run's time and the median as JSON. The aim is 2 s for the page of redkitchen.
"""
import json
import os
import pathlib
import statistics
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "web"))
import report_test  # noqa: E402

SCRIPT = """
const path = require("path");
const {chromium} = require(path.join(process.env.DEEPSLAM_NODE_MODULES, "playwright-core"));
(async () => {
  const browser = await chromium.launch({executablePath: process.env.DEEPSLAM_BROWSER, headless: true,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]});
  const tab = await browser.newPage({viewport: {width: 1150, height: 900}});
  await tab.goto("file://" + process.argv[2]);
  await tab.waitForFunction("window.deepslamViewer", null, {timeout: 120000});
  console.log(await tab.evaluate("window.deepslamViewer.firstPictureMs"));
  await browser.close();
})();
"""


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    modules, browser = report_test.find_modules(), report_test.find_browser()
    if not modules or not browser:
        print("needs node, playwright-core and Chromium: scripts/setup.sh --tests", file=sys.stderr)
        return 1
    environment = dict(os.environ, DEEPSLAM_NODE_MODULES=str(modules), DEEPSLAM_BROWSER=browser)
    page = str(pathlib.Path(sys.argv[1]).resolve())
    times = []
    for _ in range(int(sys.argv[2]) if len(sys.argv) == 3 else 5):
        done = subprocess.run(["node", "-e", SCRIPT, "--", "bench", page], env=environment, capture_output=True, text=True,
                              check=True, timeout=180)
        times.append(float(done.stdout))
    print(json.dumps({"page_bytes": pathlib.Path(page).stat().st_size, "first_picture_ms": [round(t) for t in times],
                      "median_ms": round(statistics.median(times))}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
