"""Makes the reference figures in this folder: python3 make.py (see README.md)."""

import numpy as np
import cv2
import skimage
from medpy.filter.smoothing import anisotropic_diffusion
from skimage.feature import canny
from skimage.filters import laplace, sobel
from skimage.filters.rank import entropy
from skimage.metrics import mean_squared_error, structural_similarity
from skimage.morphology import disk

SIZES = {"ramps": (32, 24), "blocks": (61, 47), "noise": (33, 40), "disk": (61, 47)}


def picture(name, shift=0):
    """The inputs, by formulas in whole numbers that tests/it/maps.rs has too."""
    width, height = SIZES[name]
    y, x = np.mgrid[0:height, 0:width].astype(np.int64)
    x = x + shift
    if name == "ramps":
        value = x * 7 + y * 3 + (x * y >> 2)
    elif name == "blocks":
        value = (x >> 3) * 37 ^ (y >> 3) * 91
    elif name == "noise":
        value = ((x * 374761393 + y * 668265263) & 0xFFFFFFFF) * 1274126177 >> 20
    else:
        ground = 40 + x + (x * y % 7)
        value = np.where((x - 30) ** 2 + (y - 22) ** 2 < 196, 200 - y, ground)
    return (value & 255).astype(np.uint8)


def store(name, array, digits):
    rows = [" ".join(f"{v:.{digits}g}" for v in row) for row in array]
    with open(name + ".txt", "w", encoding="ascii") as file:
        file.write("\n".join(rows) + "\n")


def main():
    print("scikit-image", skimage.__version__, "OpenCV", cv2.__version__)
    for name in SIZES:
        luma = picture(name)
        store(f"entropy-{name}", entropy(luma, disk(5)), 6)
        diffused = anisotropic_diffusion(luma, niter=10, kappa=50, gamma=0.1, option=1)
        store(f"diffusion-{name}", diffused, 7)
        detector = cv2.saliency.StaticSaliencySpectralResidual_create()
        store(f"saliency-{name}", detector.computeSaliency(luma)[1], 5)
        store(f"sobel-{name}", sobel(luma.astype(np.float64)), 6)
        store(f"laplacian-{name}", np.abs(laplace(luma.astype(np.float64))), 8)
        edges = canny(luma, sigma=2**0.5, low_threshold=20, high_threshold=60, mode="nearest")
        store(f"canny-{name}", edges.astype(np.uint8), 1)
        other = picture(name, 1)
        wang = dict(gaussian_weights=True, sigma=1.5, use_sample_covariance=False)
        print(
            f'("{name}", {structural_similarity(luma, other, data_range=255):.9f},',
            f"{structural_similarity(luma, other, data_range=255, **wang):.9f},",
            f"{mean_squared_error(luma, other):.9f}),",
        )
    harsh = dict(niter=25, kappa=15, gamma=0.25, option=1)
    store("diffusion-harsh", anisotropic_diffusion(picture("disk"), **harsh), 7)
    store("entropy-radius-9", entropy(picture("blocks"), disk(9)), 6)


main()
