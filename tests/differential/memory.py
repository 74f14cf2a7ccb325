#!/usr/bin/env python3
"""Peak memory of PROGRAM on files that claim or unpack to much more than they hold.

    memory.py PROGRAM FOLDER

prints a line for each file that takes more than 200 MiB (pictures that are what they claim: 1 GiB), or whose exit
code is not the right one.
"""
import os
import struct
import sys
import zlib

MOST = 200 << 10
SIDE = 8000


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(size, depth, colour, interlaced, extra=b"", data=None):
    head = struct.pack(">IIBBBBB", size, size, depth, colour, 0, 0, interlaced)
    data = zlib.compress(b"\0" * 100) if data is None else data
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def whole(size=16, extra=b""):
    return png(size, 8, 2, 0, extra, zlib.compress((b"\0" + b"\x55" * 3 * size) * size))


def bomb(megabytes):
    packer = zlib.compressobj(9)
    out = b"".join(packer.compress(bytes(1 << 20)) for _ in range(megabytes))
    return out + packer.flush()


def riff(body):
    return b"RIFF" + struct.pack("<I", len(body) + 4) + b"WEBP" + body


def webp_chunk(kind, data):
    return kind + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def three(value):
    return struct.pack("<I", value)[:3]


def vp8l(size):
    return webp_chunk(b"VP8L", b"\x2f" + struct.pack("<I", (size - 1) | (size - 1) << 14) + b"\x88\x88\x08\0")


def vp8(size):
    return webp_chunk(b"VP8 ", b"\x10\x02\0\x9d\x01\x2a" + struct.pack("<HH", size, size) + bytes(40))


def webp_animation(size, frame):
    extended = webp_chunk(b"VP8X", b"\x12\0\0\0" + three(size - 1) * 2)
    head = bytes(6) + three(size - 1) * 2 + three(100) + b"\0"
    return riff(extended + webp_chunk(b"ANIM", bytes(6)) + webp_chunk(b"ANMF", head + frame) * 2)


def tiff(size):
    tags = [(256, size), (257, size), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, size),
            (279, min(size * size, (1 << 32) - 1))]
    body = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", t, 4, 1, v) for t, v in tags) + bytes(4)
    return b"II*\0" + struct.pack("<I", 8) + body


def bmp(size):
    info = struct.pack("<IiiHHIIiiII", 40, size, size, 1, 24, 0, 0, 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 60, 0, 0, 54) + info + b"abcdef"


def jpeg(size, extra=b"", behind=b""):
    frame = b"\xff\xc0" + struct.pack(">HBHHB", 17, 8, size, size, 3) + b"\1\x11\0\2\x11\0\3\x11\0"
    return b"\xff\xd8" + extra + frame + b"\xff\xda\0\x0c\3\1\0\2\0\3\0\0\x3f\0" + bytes(40) + behind


def gif(screen, frame):
    head = b"GIF89a" + struct.pack("<HHBBB", screen, screen, 0x80, 0, 0) + bytes(6)
    return head + b"," + struct.pack("<HHHHB", 0, 0, frame, frame, 0) + b"\x02\x02\x44\x0a\0;"


def files():
    """Names, bytes, and the exit code that is right (None: any of 0 and 1)."""
    control = struct.pack(">IIIIIIHHBB", 0, SIDE, SIDE, 0, 0, 1, 10, 0, 0, 0)[:26]
    animated = chunk(b"acTL", struct.pack(">II", 2, 0)) + chunk(b"fcTL", control)
    yield "lie.png", png(SIDE, 8, 2, 0), 1
    yield "lie16.png", png(SIDE, 16, 6, 0), 1
    yield "interlaced.png", png(SIDE, 8, 6, 1), 1
    yield "apng.png", png(SIDE, 8, 6, 0, animated), 1
    yield "icc.png", whole(extra=chunk(b"iCCP", b"x\0\0" + bomb(600))), 0
    yield "text.png", whole(extra=chunk(b"zTXt", b"x\0\0" + bomb(600))), 0
    yield "exif.png", whole(extra=chunk(b"eXIf", bytes(300 << 20))), None
    yield "lossless.webp", riff(vp8l(SIDE)), None
    yield "lossy.webp", riff(vp8(SIDE)), None
    yield "lossless-animation.webp", webp_animation(SIDE, vp8l(SIDE)), None
    yield "lossy-animation.webp", webp_animation(SIDE, vp8(SIDE)), None
    yield "lie.tif", tiff(SIDE), 1
    yield "lie.bmp", bmp(SIDE), 1
    yield "lie.ppm", b"P6\n%d %d\n255\nabc" % (SIDE, SIDE), 1
    yield "lie.pam", b"P7\nWIDTH %d\nHEIGHT %d\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\nabc" % (SIDE, SIDE), 1
    yield "plain.ppm", b"P3\n%d %d\n255\n1 2 3" % (SIDE, SIDE), 1
    yield "lie.y4m", b"YUV4MPEG2 W%d H%d F25:1 C444\nFRAME\nabc" % (SIDE, SIDE), 1
    yield "lie.jpg", jpeg(SIDE), 1
    yield "behind.jpg", jpeg(64, behind=b"\xff\xd9" + bytes(300 << 20)), None
    yield "comments.jpg", jpeg(64, extra=(b"\xff\xfe\xff\xff" + bytes(0xfffd)) * 4000, behind=b"\xff\xd9"), None
    yield "lie.gif", gif(SIDE, SIDE), 1
    yield "frame.gif", gif(40, SIDE), 1


def run(program, path):
    """Exit code and peak memory in KiB."""
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        os.execv(program, [program, "render", path, "-o", "null:", "--max-size", "64", "--points", "50"])
    _, status, usage = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss


def main():
    program, folder = sys.argv[1:]
    for name, data, expected in files():
        path = os.path.join(folder, name)
        with open(path, "wb") as file:
            file.write(data)
        del data
        code, memory = run(program, path)
        os.remove(path)
        right = code in (0, 1) if expected is None else code == expected
        most = 1 << 20 if code == 0 and "lossless" in name else MOST
        if not right or memory > most or os.environ.get("VERBOSE"):
            print("%s: exit code %d, %d MiB" % (name, code, memory >> 10))


if __name__ == "__main__":
    main()
