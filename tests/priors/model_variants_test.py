#!/usr/bin/env python3
"""Variants of meshes that networks learn from: other proportions, backs of other chairs of the training, armchairs as sofas, sofas as
armchairs, none of them like a withheld product."""
import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile

PROGRAM = sys.argv[1]
GRID, LAYERS = 64, 32768
QUADS = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))


def boxes_as_obj(boxes):
    """Boxes ((low), (high)) in the frame of files: x right to left, y up, z front; metres."""
    lines = []
    for n, (low, high) in enumerate(boxes):
        lines += ["v {} {} {}".format(*(side[k] for side, k in zip(zip(low, high), (x, y, z))))
                  for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        lines += ["f " + " ".join(str(8 * n + corner) for corner in quad) for quad in QUADS]
    return "\n".join(lines) + "\n"


def chair(number, full_back):
    """Of its own height and width; the back is a board, or two posts and a rail."""
    wide, deep, seat, top = 0.40 + 0.03 * number, 0.42 + 0.02 * (number % 3), 0.44, 0.8 + 0.05 * number
    legs = [((x, 0, z), (x + 0.05, seat, z + 0.05)) for x in (0, wide - 0.05) for z in (0, deep - 0.05)]
    plate = [((0, seat - 0.05, 0), (wide, seat, deep))]
    posts = [((x, seat, 0), (x + 0.05, top, 0.05)) for x in (0, wide - 0.05)]
    rail = [((0, top - 0.05, 0), (wide, top, 0.05))]
    board = [((0, seat, 0), (wide, top, 0.05))]
    return boxes_as_obj(legs + plate + (board if full_back else posts + rail))


def armchair(number, wide=0.8, arm=0.12, high=0.62):
    """A body down to the floor between arms."""
    wide, deep, top = wide + 0.02 * number, 0.8, 0.8 + 0.04 * number
    arms = [((x, 0, 0), (x + arm, high, deep)) for x in (0, wide - arm)]
    return boxes_as_obj([((0, 0, 0), (wide, 0.42, deep)), ((0, 0, 0), (wide, top, 0.18))] + arms)


def catalogue(file, name, obj, size_cm):
    """One product; size: width, depth, height."""
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("m/1.obj", obj)
        archive.writestr("PluginFurnitureCatalog.properties", "name=Boxes\nlicense=free\nid#1=B#{0}\nname#1={0}\nmodel#1=/m/1.obj\n"
                         "creator#1=nobody\nwidth#1={1}\ndepth#1={2}\nheight#1={3}\n".format(name, *size_cm))


def solid_of(voxels):
    """Indices (x, y, z) of a packed shape."""
    return [(i // GRID ** 2, i // GRID % GRID, i % GRID) for i in range(GRID ** 3) if (voxels[i // 8] >> (7 - i % 8)) & 1]


def voxels_as_obj(voxels):
    """A shape as boxes, one for each column of it, and its sides in voxels: width, depth, height."""
    columns = {}
    for x, y, z in solid_of(voxels):
        runs = columns.setdefault((x, y), [])
        if runs and runs[-1][1] == z:
            runs[-1][1] = z + 1
        else:
            runs.append([z, z + 1])
    # In files width comes first, then height, then depth.
    boxes = [((y, low, x), (y + 1, high, x + 1)) for (x, y), runs in columns.items() for low, high in runs]
    sides = [max(high[axis] for _, high in boxes) - min(low[axis] for low, _ in boxes) for axis in range(3)]
    return boxes_as_obj(boxes), (sides[0], sides[2], sides[1])


def filled_back(voxels):
    """Share of the back's square between its rims that is solid: seen from the front, above the seat's middle."""
    shown = {(y, z) for _, y, z in solid_of(voxels)}
    high = max(z for _, z in shown)
    low = min(z for _, z in shown)
    layers = range(low + int(0.7 * (high - low)), low + int(0.85 * (high - low)))
    rows = [sorted(y for y, z in shown if z == layer) for layer in layers]
    return sum(len(row) / (row[-1] - row[0] + 1) for row in rows if row) / len(rows)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "catalogues").mkdir()
        catalogue(folder / "catalogues" / "boxes.sh3f", "Cabinet", boxes_as_obj([((0, 0, 0), (0.8, 0.9, 0.4))]), (80, 40, 90))
        (folder / "withheld.yaml").write_text("withheld:\n", encoding="utf-8")
        meshes = folder / "meshes" / "chair"
        meshes.mkdir(parents=True)
        for n in range(6):
            (meshes / f"{'board' if n % 2 else 'posts'}{n}.obj").write_text(chair(n, n % 2 == 1), encoding="utf-8")

        def render(out, *arguments, kind="chair", meshes="meshes"):
            made = subprocess.run([PROGRAM, "priors", "render", "--class", kind, "--designs", "0", "--product-views", "1",
                                   "--catalogues", folder / "catalogues", "--withheld-list", folder / "withheld.yaml",
                                   "--meshes", folder / meshes, "-o", folder / out, *map(str, arguments)],
                                  capture_output=True, text=True, check=False)
            assert made.returncode == 0, made.stderr
            models = json.loads((folder / out / "training_views.json").read_text(encoding="utf-8"))["models"]
            packed = (folder / out / "voxels.npy").read_bytes()[-LAYERS * len(models):]
            return models, {m["id"]: packed[n * LAYERS:(n + 1) * LAYERS] for n, m in enumerate(models)}

        models, one = render("one", "--variants", 4, "--threads", 1)
        again = render("two", "--variants", 4, "--threads", 2)
        assert (models, one) == again, "variants depend on the number of threads"
        _, plain = render("plain", "--variants", 0)
        assert len(plain) == 6 and len(one) == 30, (len(plain), len(one))
        assert all(one[key] == shape for key, shape in plain.items()), "the meshes themselves are no longer among them"
        assert len(set(one.values())) == 30, "variants are alike"
        for entry in models:
            own = entry["id"].split("~")[0]
            assert entry["split"] == next(m["split"] for m in models if m["id"] == own), "a variant validates its own design"

        trained = {m["id"] for m in models if m["split"] == "train"}
        assert any("board" in key for key in trained), "nothing to exchange backs with"
        other_backs = 0
        for key in sorted(k for k in trained if "posts" in k):
            filled = filled_back(one[key])
            variant = int(key.split("~")[1]) if "~" in key else 0
            assert variant % 2 == 1 or filled < 0.6, f"{key} keeps its own back, which is open: {filled}"
            other_backs += filled > 0.8
        assert other_backs >= 1, "no chair got the back of another"

        seats = folder / "seats" / "chair"
        seats.mkdir(parents=True)
        for n in range(2):
            (seats / f"arms{n}.obj").write_text(armchair(n), encoding="utf-8")
            (seats / f"none{n}.obj").write_text(chair(n, True), encoding="utf-8")
        sofas, wide = render("wide", "--variants", 4, "--widened", 3, "--threads", 1, kind="sofa", meshes="seats")
        again = render("wide_again", "--variants", 4, "--widened", 3, "--threads", 2, kind="sofa", meshes="seats")
        assert (sofas, wide) == again, "widened armchairs depend on the number of threads"
        assert sorted(wide) == sorted(f"meshes/chair/arms{n}~wide{k}" for n in range(2) for k in (1, 2, 3)), sorted(wide)
        assert len(set(wide.values())) == 6 and all(m["class"] == "sofa" for m in sofas), sofas
        assert len({(m["id"].split("~")[0], m["split"]) for m in sofas}) == 2, "armchairs validate themselves"
        chairs, _ = render("chairs", "--variants", 0, "--widened", 3, meshes="seats")
        assert len(chairs) == 4 and all(m["class"] == "chair" for m in chairs), "chairs have no use for sofas"
        (folder / "sofas" / "sofa").mkdir(parents=True)
        (folder / "sofas" / "sofa" / "arms.obj").write_text(armchair(0, 1.9), encoding="utf-8")
        (folder / "sofas" / "sofa" / "none.obj").write_text(chair(0, True), encoding="utf-8")
        chairs, _ = render("narrow", "--narrowed", 3, meshes="sofas")
        assert [m["id"] for m in chairs] == [f"meshes/sofa/arms~narrow{k}" for k in (1, 2, 3)], chairs
        assert all(m["class"] == "chair" for m in chairs), chairs

        # What turns out like a withheld product is drawn anew: of an armchair with arms as high as its back.
        (folder / "high" / "chair").mkdir(parents=True)
        (folder / "high" / "chair" / "arms.obj").write_text(armchair(0, 0.9, 0.25, 0.78), encoding="utf-8")
        _, free = render("free", "--variants", 0, "--widened", 6, kind="sofa", meshes="high")
        like = "meshes/chair/arms~wide2"
        obj, sides = voxels_as_obj(free[like])
        catalogue(folder / "catalogues" / "hidden.sh3f", "Sofa", obj, [180 / sides[0] * side for side in sides])
        (folder / "withheld.yaml").write_text('withheld:\n  - id: "B#Sofa"\n    catalogue: hidden.sh3f\n    mesh: m/1.obj\n',
                                              encoding="utf-8")
        _, checked = render("checked", "--variants", 0, "--widened", 6, kind="sofa", meshes="high")
        assert sorted(checked) == sorted(free), sorted(checked)
        assert checked[like] != free[like], "a withheld shape is among what is learned from"
        assert any(checked[key] == free[key] for key in free), "what is not like it was drawn anew as well"
    print("variants: fine")


if __name__ == "__main__":
    main()
