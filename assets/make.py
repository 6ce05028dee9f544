#!/usr/bin/env python3
"""Makes the bundled assets: python3 assets/make.py [FOLDER], by default the folder of this script.

Standard library only, and the same bytes on every run: all chance comes from seeded generators, and numbers are
rounded to a binary grid far coarser than the differences between maths libraries.
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True

from maker import box_over_plane, room, walk  # noqa: E402

ASSETS = {
    "box_over_plane.gltf": box_over_plane.make,
    "room.glb": room.make,
    "walk.csv": walk.make,
}


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in ASSETS.items():
        content = make()
        (folder / name).write_bytes(content)
        print(f"{name}: {len(content):,} bytes")


if __name__ == "__main__":
    main()
