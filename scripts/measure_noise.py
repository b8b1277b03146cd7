#!/usr/bin/env python3
"""Measures the depth noise of rendered captures and holds it against the published formulas:

    scripts/measure_noise.py --deepslam build/release/tools/deepslam [--plot docs/evaluation/noise.svg]

For every camera preset an empty room is rendered twice, with and without one fault, and the two depths are compared:
spread along the ray by range and angle, how neighbours share it, steps of disparity, displacement of edges. Prints a
table; exit code 1 when a figure is further from its formula than chance allows. Needs Python 3 alone.
"""
import argparse
import html
import json
import math
import pathlib
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "end_to_end"))
import captures  # noqa: E402  (its reader of PNG files)

UNITS_PER_M = 10_000
ROOM = (9.0, 9.0, 2.6)
ANGLES = ((0, 25), (50, 60), (72, 78))  # deg
RANGE_BIN_M = 0.5
# Camera, full size: width, height, focal length, principal point.
CAMERAS = {"kinect_v1": (640, 480, 525, 319.5, 239.5), "kinect_v2": (512, 424, 365.5, 255.5, 211.5),
           "d435": (640, 480, 615, 319.5, 239.5), "phone_lidar": (640, 480, 483, 319.5, 239.5)}
# The papers' formulas: spread along the ray in metres by range z in metres and angle in radians.
AXIAL = {
    "kinect_v1": ("Nguyen 2012", lambda z, a: 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / math.sqrt(z) * odds(a) ** 2),
    "kinect_v2": ("Fankhauser 2015", lambda z, a: (1.5 - 0.5 * z + 0.3 * z * z + 0.1 * z ** 1.5 * odds(a) ** 2) / 1e3),
    "d435": ("Keselman 2017", lambda z, a: 0.08 * z * z / (385 * 0.05)),
    "phone_lidar": ("Luetzenburg 2021", lambda z, a: 0.005 + 0.002 * z)}
# Depth per step of disparity: z^2 step / (f b), from f in px, b in m, step in px.
STEPS = {"kinect_v1": (580, 0.075, 1 / 8), "d435": (385, 0.05, 1 / 32)}
LATERAL_PX = {"kinect_v1": 0.8, "d435": 0.7}
REACH_PX = {"kinect_v1": 4, "d435": 4}
COLOURS = ("#1f6fb4", "#d1605e", "#5a9e4b")


def odds(angle):
    return angle / (math.pi / 2 - angle)


class Renderer:
    def __init__(self, program, folder):
        self.program = program
        self.folder = folder
        self.count = 0

    def frames(self, preset, fault, scene, divisor=1, lines=""):
        """Depths in metres (rows) and poses of a scene with one fault alone, or none."""
        width, height, focal, cx, cy = CAMERAS[preset]
        camera = (f"camera: {{preset: {preset}, width: {width // divisor}, height: {height // divisor}, fx: {focal / divisor}, "
                  f"fy: {focal / divisor}, cx: {(cx + 0.5) / divisor - 0.5}, cy: {(cy + 0.5) / divisor - 0.5}}}\n")
        faults = "faults: {all: false" + (f", {fault}: true" if fault else "") + "}\n"
        self.count += 1
        file = self.folder / f"scene{self.count}.yaml"
        file.write_text(f"seed: 11\nframes_per_s: 10\ndepth_units_per_m: {UNITS_PER_M}\n{camera}{faults}{lines}"
                        f"room: {{size_m: {list(ROOM)}, posters: 0}}\nlights: []\n{scene}")
        capture = self.folder / f"capture{self.count}"
        subprocess.run([self.program, "synth", file, "-o", capture], check=True, capture_output=True)
        poses = [[float(x) for x in line.split()[1:]] for line in (capture / "groundtruth.txt").read_text().splitlines()
                 if not line.startswith("#")]
        depths = [captures.read_grey16(png) for png in sorted((capture / "depth").glob("*.png"))]
        return depths, poses


def rotate(q, p):
    x, y, z, w = q
    cross = [y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]]
    twice = [y * cross[2] - z * cross[1], z * cross[0] - x * cross[2], x * cross[1] - y * cross[0]]
    return [p[i] + 2 * (w * cross[i] + twice[i]) for i in range(3)]


def cosine_on_room(ray_world, origin, depth):
    """Of the angle between the ray and the face of the room where it ends; None near an edge of the room."""
    place = [origin[i] + depth * ray_world[i] for i in range(3)]
    gaps = [abs(abs(place[0]) - ROOM[0] / 2), abs(abs(place[1]) - ROOM[1] / 2), min(abs(place[2]), abs(place[2] - ROOM[2]))]
    near = [axis for axis in range(3) if gaps[axis] < 0.01]
    if len(near) != 1:
        return None
    return abs(ray_world[near[0]]) / math.sqrt(sum(x * x for x in ray_world))


def axial(renderer, preset):
    """{(angle group, range bin): [count, sum of squares, sum of the formula's squares, sum of ranges]} and the overall ratio."""
    divisor = 4
    walk = ("frames: 36\nwalk: {points_m: [[-3.6, -3.4, 1.4], [-1.0, 0.4, 1.5], [1.5, -0.6, 1.3], [3.5, 3.6, 1.5]], "
            "look_at_m: [[2.5, -3.0, 0.8], [-4.0, 4.0, 0.4], [0.5, 4.0, 1.6], [4.4, -4.0, 0.2]]}\n")
    clean, poses = renderer.frames(preset, None, walk, divisor)
    noisy, _ = renderer.frames(preset, "axial_noise", walk, divisor)
    _, _, focal, cx, cy = CAMERAS[preset]
    focal, cx, cy = focal / divisor, (cx + 0.5) / divisor - 0.5, (cy + 0.5) / divisor - 0.5
    formula = AXIAL[preset][1]
    bins, everything = {}, [0, 0.0, 0.0]
    for before, after, pose in zip(clean, noisy, poses):
        for v, (row, noisy_row) in enumerate(zip(before, after)):
            for u, (a, b) in enumerate(zip(row, noisy_row)):
                z = a / UNITS_PER_M
                if not 0.5 < z < 6:
                    continue
                cosine = cosine_on_room(rotate(pose[3:], [(u - cx) / focal, (v - cy) / focal, 1.0]), pose[:3], z)
                if cosine is None or cosine < math.cos(math.radians(80)):
                    continue
                angle = math.acos(min(1.0, cosine))
                off, expected = (b - a) / UNITS_PER_M, formula(z, angle)
                everything = [everything[0] + 1, everything[1] + (off / expected) ** 2, everything[2] + off / expected]
                group = next((g for g, (low, high) in enumerate(ANGLES) if low <= math.degrees(angle) < high), None)
                if group is not None:
                    entry = bins.setdefault((group, int(z / RANGE_BIN_M)), [0, 0.0, 0.0, 0.0])
                    for i, value in enumerate((1, off * off, expected * expected, z)):
                        entry[i] += value
    count, squares, total = everything
    return bins, math.sqrt(squares / count), total / count, count


def wall(x):
    """A few frames of the wall at 4.5 m from a camera at x."""
    return (f"frames: 4\nwalk: {{points_m: [[{x}, 0.3, 1.3], [{x + 0.1}, 0.2, 1.3]], look_at_m: [[4.5, 0.3, 1.3]], shake_deg: 0, "
            "shake_m: 0}\n")


def sharing(renderer, preset):
    """Correlation of the noise of pixels 1, 2, 4 and 8 apart along rows and columns."""
    clean, _ = renderer.frames(preset, None, wall(1.5))
    noisy, _ = renderer.frames(preset, "axial_noise", wall(1.5))
    products = {d: [0.0, 0.0] for d in (1, 2, 4, 8)}
    for before, after in zip(clean, noisy):
        noise = [[b - a for a, b in zip(row, noisy_row)] for row, noisy_row in zip(before, after)]
        rows = noise[::7]
        columns = [list(column) for column in zip(*noise)][::7]
        for line in rows + columns:
            square = sum(x * x for x in line) / len(line)
            for d, entry in products.items():
                entry[0] += sum(x * y for x, y in zip(line, line[d:])) / (len(line) - d)
                entry[1] += square
    return {d: a / b for d, (a, b) in products.items()}


def steps(renderer, preset):
    """(range, gap to the next depth that occurs) over a floor that runs away from the camera."""
    floor = "frames: 1\nwalk: {points_m: [[-4.0, 0, 1.2], [-3.9, 0, 1.2]], look_at_m: [[0, 0, 0]], shake_deg: 0, shake_m: 0}\n"
    depths, _ = renderer.frames(preset, "quantisation", floor)
    levels = sorted({value for row in depths[0] for value in row if value > 0})
    return [((a + b) / 2 / UNITS_PER_M, (b - a) / UNITS_PER_M) for a, b in zip(levels, levels[1:])]


def lateral(renderer, preset):
    """Share of pixels k = 1 .. 3 columns from a vertical edge that show the surface beyond it."""
    slab = renderer.folder / "slab.obj"
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (0, 2.2) for z in (-0.02, 0.02)]
    slab.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) +
                    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n")
    lines = "objects: [{class: shelf, model: slab.obj, position_m: [0.4, 0.3], yaw_deg: 180}]\n"
    clean, _ = renderer.frames(preset, None, wall(-1), lines=lines)
    noisy, _ = renderer.frames(preset, "lateral_noise", wall(-1), lines=lines)
    wrong, count = [0, 0, 0], 0
    for before, after in zip(clean, noisy):
        # Away from the slab's upper edge, over which pixels stray as well.
        for row, noisy_row in list(zip(before, after))[len(before) // 2:]:
            for u in range(8, len(row) - 8):
                low, high = row[u - 1], row[u]
                if min(low, high) == 0 or abs(high - low) < 0.5 * UNITS_PER_M:
                    continue
                middle = (low + high) / 2
                count += 2
                for k in range(3):
                    wrong[k] += (noisy_row[u - 1 - k] > middle) != (low > middle)
                    wrong[k] += (noisy_row[u + k] > middle) != (high > middle)
    return [n / count for n in wrong], count


def strays(k, deviation):
    """Share of a normal displacement, rounded to pixels, that is k or more one way."""
    return 0.5 * math.erfc((k - 0.5) / deviation / math.sqrt(2))


class Panel:
    """A plot of points and lines, as SVG."""
    WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 380, 250, 52, 30, 40

    def __init__(self, title, x_label, y_label, x_range, y_range):
        self.title, self.x_label, self.y_label, self.x_range, self.y_range = title, x_label, y_label, x_range, y_range
        self.marks, self.names = [], []

    def at(self, x, y):
        width, height = self.WIDTH - self.LEFT - 12, self.HEIGHT - self.TOP - self.BOTTOM
        share = [(value - low) / (high - low) for value, (low, high) in zip((x, y), (self.x_range, self.y_range))]
        return self.LEFT + share[0] * width, self.TOP + (1 - share[1]) * height

    def line(self, points, colour, dash=""):
        inside = [self.at(x, y) for x, y in points if self.y_range[0] <= y <= self.y_range[1]]
        self.marks.append(f'<polyline fill="none" stroke="{colour}" stroke-width="1.5" stroke-dasharray="{dash}" points="' +
                          " ".join(f"{x:.1f},{y:.1f}" for x, y in inside) + '"/>')

    def points(self, points, colour, name):
        for x, y in points:
            if self.y_range[0] <= y <= self.y_range[1]:
                px, py = self.at(x, y)
                self.marks.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3" fill="{colour}"/>')
        self.names.append((name, colour))

    def svg(self, left, top):
        out = [f'<g transform="translate({left},{top})">',
               f'<text x="{self.LEFT}" y="18" font-weight="bold">{html.escape(self.title)}</text>']
        for share in (0, 0.25, 0.5, 0.75, 1):
            x, y = (low + share * (high - low) for low, high in (self.x_range, self.y_range))
            (px, _), (_, py) = self.at(x, self.y_range[0]), self.at(self.x_range[0], y)
            bottom = self.HEIGHT - self.BOTTOM
            out.append(f'<line x1="{self.LEFT}" x2="{self.WIDTH - 12}" y1="{py:.1f}" y2="{py:.1f}" stroke="#ddd"/>'
                       f'<text x="{self.LEFT - 6}" y="{py + 4:.1f}" text-anchor="end">{y:.3g}</text>'
                       f'<text x="{px:.1f}" y="{bottom + 16}" text-anchor="middle">{x:.3g}</text>')
        out += self.marks
        for n, (name, colour) in enumerate(self.names):
            out.append(f'<circle cx="{self.LEFT + 12}" cy="{self.TOP + 10 + 15 * n}" r="3" fill="{colour}"/>'
                       f'<text x="{self.LEFT + 20}" y="{self.TOP + 14 + 15 * n}">{html.escape(name)}</text>')
        out.append(f'<text x="{self.LEFT}" y="{self.HEIGHT - 6}">{html.escape(self.x_label)}; {html.escape(self.y_label)}</text></g>')
        return "\n".join(out)


def axial_panel(preset, bins):
    measured, expected = {}, {}
    for (group, _), (count, squares, formula, ranges) in sorted(bins.items()):
        if count >= 150:
            measured.setdefault(group, []).append((ranges / count, 1e3 * math.sqrt(squares / count)))
            # Over the pixels of the bin: their angles and ranges are not spread evenly.
            expected.setdefault(group, []).append((ranges / count, 1e3 * math.sqrt(formula / count)))
    high = 1.15 * max(y for points in measured.values() for _, y in points)
    panel = Panel(f"{preset}, along the ray ({AXIAL[preset][0]})", "range in m", "standard deviation in mm", (0, 6), (0, high))
    for group, points in measured.items():
        low_deg, high_deg = ANGLES[group]
        panel.line(expected[group], COLOURS[group])
        panel.points(points, COLOURS[group], f"{low_deg} to {high_deg} deg; line: formula")
    return panel


def plot(results, command):
    panels = [axial_panel(preset, results[preset]["bins"]) for preset in CAMERAS]
    panel = Panel("Steps of disparity", "range in m", "step in mm", (0, 8), (0, 200))
    for n, (preset, (focal, baseline, step)) in enumerate(STEPS.items()):
        panel.line([(0.1 * i, 1e3 * (0.1 * i) ** 2 * step / (focal * baseline)) for i in range(5, 81)], COLOURS[n])
        panel.points([(z, 1e3 * gap) for z, gap in results[preset]["steps"]][::3], COLOURS[n], preset)
    panels.append(panel)
    panel = Panel("Noise shared by neighbours", "distance in px", "correlation", (0, 10), (0, 1))
    for n, (preset, reach) in enumerate(REACH_PX.items()):
        panel.line([(0.1 * i, math.exp(-0.1 * i / reach)) for i in range(101)], COLOURS[n])
        panel.points(results[preset]["sharing"].items(), COLOURS[n], preset)
    panels.append(panel)
    panel = Panel("Pixels beside an edge that show the other side", "columns from the edge", "share", (0, 4), (0, 0.4))
    for n, (preset, deviation) in enumerate(LATERAL_PX.items()):
        panel.line([(0.5 + 0.05 * i, strays(0.5 + 0.05 * i, deviation)) for i in range(71)], COLOURS[n])
        panel.points([(k + 1, share) for k, share in enumerate(results[preset]["lateral"])], COLOURS[n], preset)
    panels.append(panel)
    width, height = 2 * Panel.WIDTH, ((len(panels) + 1) // 2) * Panel.HEIGHT
    body = [panel.svg(Panel.WIDTH * (n % 2), Panel.HEIGHT * (n // 2)) for n, panel in enumerate(panels)]
    return (f"<!-- {html.escape(command).replace('--', '- -')} -->\n"
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="11">\n'
            f'<rect width="{width}" height="{height}" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n")


class Checks:
    def __init__(self):
        self.num_off = 0

    def row(self, what, measured, expected, tolerance):
        off = abs(measured - expected) > tolerance
        self.num_off += off
        print(f"{what:<52} {measured:>10.4f} {expected:>10.4f} {tolerance:>8.4f}  {'OFF' if off else 'ok'}")


def measure(renderer, checks):
    results = {}
    print(f"{'':<52} {'measured':>10} {'formula':>10} {'within':>8}")
    for preset in CAMERAS:
        result = results[preset] = {}
        result["bins"], ratio, mean, count = axial(renderer, preset)
        checks.row(f"{preset}: spread, share of the formula, {count} px", ratio, 1, 0.02)
        checks.row(f"{preset}: mean, in standard deviations", mean, 0, 0.03)
        for (group, bin_number), (n, squares, formula, ranges) in sorted(result["bins"].items()):
            if n >= 1500:
                low, high = ANGLES[group]
                checks.row(f"{preset}: spread in mm, {low}-{high} deg, {ranges / n:.2f} m", 1e3 * math.sqrt(squares / n),
                           1e3 * math.sqrt(formula / n), 0.1 * 1e3 * math.sqrt(formula / n))
    for preset in STEPS:
        result = results[preset]
        focal, baseline, step = STEPS[preset]
        result["steps"] = steps(renderer, preset)
        for low in (1, 2, 3, 4, 5):
            here = [(gap, z * z * step / (focal * baseline)) for z, gap in result["steps"] if low <= z < low + 1]
            if here:
                # Depths are written in steps of their own, of 0.1 mm.
                formula = 1e3 * sum(f for _, f in here) / len(here)
                checks.row(f"{preset}: mean step in mm, {low}-{low + 1} m", 1e3 * sum(g for g, _ in here) / len(here), formula,
                           0.03 * formula + 0.05)
        result["sharing"] = sharing(renderer, preset)
        for distance, correlation in result["sharing"].items():
            checks.row(f"{preset}: correlation {distance} px apart", correlation, math.exp(-distance / REACH_PX[preset]), 0.04)
        result["lateral"], count = lateral(renderer, preset)
        for k, share in enumerate(result["lateral"]):
            checks.row(f"{preset}: strays {k + 1} px from an edge, {count} px", share, strays(k + 1, LATERAL_PX[preset]), 0.025)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deepslam", type=pathlib.Path, default=ROOT / "build/release/tools/deepslam")
    parser.add_argument("--plot", type=pathlib.Path, help="write the plots here (SVG)")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures here")
    args = parser.parse_args()
    checks = Checks()
    with tempfile.TemporaryDirectory() as folder:
        results = measure(Renderer(args.deepslam.resolve(), pathlib.Path(folder)), checks)
    if args.plot:
        args.plot.write_text(plot(results, "scripts/measure_noise.py --plot " + shlex.quote(str(args.plot))))
    if args.json:
        plain = {preset: {key: value for key, value in result.items() if key != "bins"} for preset, result in results.items()}
        args.json.write_text(json.dumps(plain, indent=1))
    print(f"{checks.num_off} figures off")
    return 1 if checks.num_off else 0


if __name__ == "__main__":
    sys.exit(main())
