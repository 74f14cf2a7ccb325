"""The camera as low-poly art in a window, by OpenCV (``pip install opencv-python``). ``q`` ends, 1 to 9 choose a preset.

    python webcam.py            # the first camera
    python webcam.py clip.mp4   # a file in its place
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np

import polyreel


def main() -> None:
    try:
        cv2: Any = importlib.import_module("cv2")
    except ImportError:
        print("OpenCV is not installed: pip install opencv-python")
        return
    camera = cv2.VideoCapture(sys.argv[1] if len(sys.argv) > 1 else 0)
    if not camera.isOpened():
        print("no camera, or no such file")
        return
    presets = list(polyreel.presets())[:9]
    # Live frames come one at a time: `render`, not `stream`, which works some frames ahead.
    renderer = polyreel.Renderer(points=1200, quality="draft")
    while True:
        more, frame = camera.read()
        if not more:
            break
        # OpenCV has blue first.
        art = renderer.render(frame[..., ::-1])
        cv2.imshow("polyreel", np.ascontiguousarray(art[..., ::-1]))
        key = cv2.waitKey(1) & 0xFF
        if key == ord("q"):
            break
        if ord("1") <= key < ord("1") + len(presets):
            renderer = polyreel.Renderer(preset=presets[key - ord("1")], quality="draft")
    camera.release()
    cv2.destroyAllWindows()


if __name__ == "__main__":
    main()
