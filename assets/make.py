#!/usr/bin/env python3
"""Makes the bundled assets: python3 assets/make.py [FOLDER], by default the folder of this script.
With --check it writes nothing and fails if a file there is not, byte for byte, what would be made.

Standard library only, and the same bytes on every run: all chance comes from seeded generators, and numbers
are rounded to a binary grid far coarser than the differences between maths libraries.
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


def main(arguments):
    checking = "--check" in arguments
    folders = [a for a in arguments if a != "--check"]
    folder = Path(folders[0]) if folders else Path(__file__).resolve().parent
    differing = 0
    for name, make in ASSETS.items():
        path, content = folder / name, make()
        if not checking:
            folder.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            print(f"{name}: {len(content):,} bytes")
        elif not path.exists() or path.read_bytes() != content:
            print(f"{path} is not what make.py makes", file=sys.stderr)
            differing += 1
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
