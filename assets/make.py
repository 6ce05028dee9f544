#!/usr/bin/env python3
"""Makes the bundled assets: python3 assets/make.py [FOLDER]. With --check it only compares.

It uses only the standard library and writes the same bytes on every run: all random numbers come from seeded
generators, and coordinates are rounded to a grid that is much coarser than the differences between maths libraries.
"""

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True

from maker import box_over_plane, room, walk  # noqa: E402

ASSETS = {
    "box_over_plane.gltf": box_over_plane.make,
    "room.glb": room.make,
    "walk.csv": walk.make,
}


def read_arguments():
    parser = argparse.ArgumentParser(prog="assets/make.py", description="Makes the bundled assets.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).resolve().parent,
                        help="the folder of the assets; default: the folder of this script")
    parser.add_argument("--check", action="store_true",
                        help="write nothing; fail if a file differs from the bytes that would be written")
    return parser.parse_args()


def main():
    arguments = read_arguments()
    differing = 0
    for name, make in ASSETS.items():
        path, content = arguments.folder / name, make()
        if not arguments.check:
            arguments.folder.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            print(f"{name}: {len(content):,} bytes")
        elif not path.exists() or path.read_bytes() != content:
            print(f"{path} differs from what make.py writes", file=sys.stderr)
            differing += 1
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
