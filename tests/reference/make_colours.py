"""Colours of 16 bits in wide profiles, and what LittleCMS makes of them in sRGB: `python3 make_colours.py` here.

Needs numpy and the library of LittleCMS (Debian: liblcms2-2). A profile goes to colours-NAME.icc, colours to
colours-NAME.txt: red, green and blue (or gray) of 0..65535, then those of sRGB, with three decimals.
"""

import ctypes
from ctypes import byref, c_double, c_int32, c_uint32, c_void_p

import numpy as np

lcms = ctypes.CDLL("liblcms2.so.2")


def call(name, result, *arguments):
    function = getattr(lcms, name)
    function.restype = result
    return function(*arguments)


def pointer(name, *arguments):
    return c_void_p(call(name, c_void_p, *arguments))


# Pixels of doubles or of 16 bits, by lcms2.h.
RGB, GRAY, RGB_16, LAB_16 = 1 << 22 | 4 << 16 | 3 << 3, 1 << 22 | 3 << 16 | 1 << 3, 4 << 16 | 3 << 3 | 2, 10 << 16 | 3 << 3 | 2
RELATIVE, EXACT, GUESS_CLASS, EIGHT_BITS = 1, 0x100, 0x20, 8
LAB = 0x4C616220
D50, D65 = (0.3457, 0.3585), (0.3127, 0.3290)


def gamma(exponent):
    return pointer("cmsBuildGamma", None, c_double(exponent))


def srgb_curve():
    values = (c_double * 5)(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
    return pointer("cmsBuildParametricToneCurve", None, c_int32(4), values)


def matrix(white, primaries, curve):
    """A profile of primaries and a curve."""
    points = (c_double * 9)(*[v for x, y in primaries for v in (x, y, 1)])
    return pointer("cmsCreateRGBProfile", (c_double * 3)(*white, 1), points, (c_void_p * 3)(*[curve.value] * 3))


def table(profile, version, grid, flags=0):
    """The profile as a table of Lab, for the perceptual intent only, as those of most scanners and cameras are."""
    lab = pointer("cmsCreateLab2Profile" if version < 4 else "cmsCreateLab4Profile", None)
    transform = pointer("cmsCreateTransform", profile, RGB_16, lab, LAB_16, RELATIVE, 0)
    flags |= GUESS_CLASS | grid << 16
    link = pointer("cmsTransform2DeviceLink", transform, c_double(version), c_uint32(flags))
    call("cmsWriteTag", c_int32, link, 0x77747074, pointer("cmsD50_XYZ"))
    return link


def lightness(curve):
    """A gray profile whose curve gives L* of CIELAB."""
    profile = pointer("cmsCreateGrayProfile", (c_double * 3)(*D50, 1), curve)
    call("cmsSetPCS", None, profile, c_uint32(LAB))
    return profile


def encoded(profile):
    size = c_uint32()
    assert call("cmsSaveProfileToMem", c_int32, profile, None, byref(size))
    data = ctypes.create_string_buffer(size.value)
    assert call("cmsSaveProfileToMem", c_int32, profile, data, byref(size))
    return data.raw


def to_srgb(icc, colours):
    """Colours of 0..1 in sRGB, 0..1, without the tables that LittleCMS uses for speed."""
    layout = RGB if colours.shape[1] == 3 else GRAY
    profile = pointer("cmsOpenProfileFromMem", icc, c_uint32(len(icc)))
    srgb = pointer("cmsCreate_sRGBProfile")
    transform = pointer("cmsCreateTransform", profile, layout, srgb, RGB, RELATIVE, EXACT)
    colours = np.ascontiguousarray(colours, dtype=float)
    out = np.empty((len(colours), 3))
    call("cmsDoTransform", None, transform, c_void_p(colours.ctypes.data), c_void_p(out.ctypes.data), c_uint32(len(out)))
    return np.clip(out, 0, 1)


def colours(channels, count=96):
    """Any colours, dark ones, those near gray, grays, black and white."""
    random = np.random.default_rng(7)
    values = random.integers(0, 65536, (count, channels))
    values[: count // 4] = (values[: count // 4] / 65535) ** 3 * 65535
    near = slice(count // 4, count // 2)
    values[near] = values[near, :1] + random.integers(-2000, 2001, (count // 4, channels))
    values[-18:] = np.linspace(0, 65535, 18).round()[:, None]
    return values.clip(0, 65535)


P3 = [(0.68, 0.32), (0.265, 0.69), (0.15, 0.06)]
ADOBE = [(0.64, 0.33), (0.21, 0.71), (0.15, 0.06)]
PROPHOTO = [(0.734699, 0.265301), (0.159597, 0.840403), (0.036598, 0.000105)]
adobe = lambda: matrix(D65, ADOBE, gamma(563 / 256))
PROFILES = {
    "display-p3": lambda: matrix(D65, P3, srgb_curve()),
    "adobe-rgb": adobe,
    "prophoto": lambda: matrix(D50, PROPHOTO, gamma(1.8)),
    "linear-p3": lambda: matrix(D65, P3, gamma(1.0)),
    "table-16": lambda: table(adobe(), 2.1, 17),
    "table-8": lambda: table(adobe(), 2.1, 17, EIGHT_BITS),
    "table-4": lambda: table(adobe(), 4.3, 17),
    "lightness": lambda: lightness(gamma(1.0)),
}

if __name__ == "__main__":
    for name, profile in PROFILES.items():
        icc = encoded(profile())
        values = colours(1 if icc[16:20] == b"GRAY" else 3)
        with open(f"colours-{name}.icc", "wb") as file:
            file.write(icc)
        with open(f"colours-{name}.txt", "w") as file:
            for before, after in zip(values, to_srgb(icc, values / 65535) * 255):
                file.write(" ".join(map(str, before)) + " " + " ".join(f"{v:.3f}" for v in after) + "\n")
