"""The mesh behind a picture: its facets by size, and as SVG.

python mesh.py out.svg
"""

from __future__ import annotations

import sys

import numpy as np

import polyreel


def main() -> None:
    y, x = np.mgrid[0:240, 0:320]
    picture = np.stack([x * 255 // 319, y * 255 // 239, 255 * (np.hypot(x - 160, y - 120) < 70)], -1).astype(np.uint8)
    mesh = polyreel.triangulate(picture, points=300, quality="best")
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    areas = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    print(f"{mesh}: facets of {areas.min():.1f} to {areas.max():.1f} pixels")
    destination = sys.argv[1] if len(sys.argv) > 1 else "mesh.svg"
    mesh.save(destination, overwrite=True)


if __name__ == "__main__":
    main()
