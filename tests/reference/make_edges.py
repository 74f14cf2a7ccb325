"""Makes the reference figures of Edge Drawing and of the bilateral filter: python3 make_edges.py (see README.md)."""

import numpy as np
import cv2

SIZES = {"blocks": (61, 47), "disk": (61, 47), "shapes": (200, 150)}


def picture(name):
    """The inputs, by formulas in whole numbers that tests/it/maps.rs has too."""
    width, height = SIZES[name]
    y, x = np.mgrid[0:height, 0:width].astype(np.int64)
    if name == "blocks":
        value = (x >> 3) * 37 ^ (y >> 3) * 91
    elif name == "shapes":
        grain = ((x * 7919 + y * 104729) & 0xFFFFFF) * 613 >> 9 & 7
        disk = (x - 60) ** 2 + (y - 70) ** 2 < 2025
        wedge = x + 2 * y > 320
        value = np.where(disk, 190 - (y >> 1), np.where(wedge, 30 + (x >> 5) * 23, 70 + (x >> 1))) + grain
    else:
        ground = 40 + x + (x * y % 7)
        value = np.where((x - 30) ** 2 + (y - 22) ** 2 < 196, 200 - y, ground)
    return (value & 255).astype(np.uint8)


def colours(name):
    """The same in colour."""
    grey = picture(name)
    return np.dstack([grey, 255 - grey, (grey >> 1) + 60])


def edges(luma, gradient, anchor):
    detector = cv2.ximgproc.createEdgeDrawing()
    params = cv2.ximgproc.EdgeDrawing.Params()
    params.GradientThresholdValue = gradient
    params.AnchorThresholdValue = anchor
    params.MinPathLength = 10
    params.NFAValidation = False
    detector.setParams(params)
    detector.detectEdges(luma)
    return detector.getEdgeImage() > 0


def main():
    print("OpenCV", cv2.__version__)
    for name in SIZES:
        for gradient, anchor in [(36, 8), (20, 0)]:
            found = edges(picture(name), gradient, anchor)
            # Each row of pixels as a number in hexadecimal digits, the leftmost pixel the highest bit.
            rows = ["".join(f"{byte:02x}" for byte in row) for row in np.packbits(found, axis=1)]
            with open(f"edge-drawing-{name}-{gradient}.txt", "w", encoding="ascii") as file:
                file.write("\n".join(rows) + "\n")
            print(name, gradient, anchor, int(found.sum()), "edge pixels")
    for name, sigma in [("blocks", 75), ("disk", 30)]:
        smooth = cv2.bilateralFilter(colours(name), 9, sigma, 75)
        rows = [" ".join(str(v) for v in row.reshape(-1)) for row in smooth]
        with open(f"bilateral-{name}.txt", "w", encoding="ascii") as file:
            file.write("\n".join(rows) + "\n")


main()
