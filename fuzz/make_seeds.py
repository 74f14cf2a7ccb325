"""Small sound inputs to begin with, into corpus/TARGET: `python3 make_seeds.py PROGRAM`, a built polyreel.

Needs ffmpeg.
"""

import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
PROGRAM = Path(sys.argv[1]).resolve()


def output(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout


def put(target, name, data):
    folder = HERE / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data)


def clip(pixels, container, *options, size="18x10", frames=3):
    """A test pattern, as ffmpeg writes it."""
    source = ["-f", "lavfi", "-i", "testsrc=s=32x24:r=30000/1001", "-frames:v", str(frames), "-s", size]
    return output("ffmpeg", "-v", "error", *source, "-pix_fmt", pixels, *options, "-strict", "-1", "-f", container, "-")


def videos():
    for pixels, bytes_each in [("rgba", 128), ("rgb24", 96), ("gray", 32)]:
        for index in "01":
            data = clip(pixels, "nut", "-c:v", "rawvideo", "-write_index", index, size="8x4")
            put("nut", f"{pixels}-{index}", bytes([bytes_each]) + data)
    for pixels in "gray yuv420p yuvj420p yuv422p yuv444p yuv411p gray10le yuv420p10le yuv444p12le".split():
        put("y4m", pixels, clip(pixels, "yuv4mpegpipe"))


def pictures():
    for pixels in ["rgba", "rgb24", "gray", "pal8", "rgba64be", "gray16be", "ya8", "monob"]:
        put("apng", pixels, clip(pixels, "image2pipe", "-c:v", "png", frames=1))
    for pixels in ["yuvj420p", "yuvj444p", "gray"]:
        put("jpeg", pixels, clip(pixels, "image2pipe", "-c:v", "mjpeg", frames=1))
    for pixels in ["yuva420p", "bgra"]:
        put("webp", pixels, clip(pixels, "webp", "-c:v", "libwebp_anim"))
        put("webp", f"still-{pixels}", clip(pixels, "webp", "-c:v", "libwebp", frames=1))
    for codec, pixels in [("tiff", "rgb24"), ("tiff", "rgba64le"), ("bmp", "bgr24"), ("ppm", "rgb24"), ("pgm", "gray16be")]:
        put("picture", f"{codec}-{pixels}", clip(pixels, "image2pipe", "-c:v", codec, frames=1))


def of_the_program(folder):
    def render(name, *options):
        path = folder / name
        output(PROGRAM, "render", folder / "in.gif", "-o", path, "-y", "-q", "--points", "40", *options)
        return path.read_bytes()

    (folder / "in.gif").write_bytes(clip("pal8", "gif", size="32x24"))
    for target, name in [("gif", "out.gif"), ("apng", "out.apng"), ("webp", "out.webp"), ("y4m", "out.y4m")]:
        put(target, name, render(name))
    meshes(render("out.polyreel", "--report", str(folder / "report.json")))
    put("report", "report", (folder / "report.json").read_bytes())
    for name in ["fine", "sketch", "neon", "riso"]:
        put("preset", name, output(PROGRAM, "presets", name))
    for number, name in enumerate(["frame_%04d.png", "a%db", "100%%_%d", "%5d.x", "%", "100%done"]):
        put("pattern", str(number), name.encode())


def meshes(stream):
    """The first frame with each that follows, without their times (32 bytes)."""
    key, at = None, 20
    while at + 9 <= len(stream):
        length = struct.unpack_from("<I", stream, at + 1)[0]
        kind, packet = stream[at : at + 1], stream[at + 9 + 32 : at + 9 + length]
        if kind == b"K":
            key = packet
        elif kind == b"D" and key:
            put("mesh_stream", str(at), struct.pack("<H", len(key)) + key + packet)
        at += 9 + length


if __name__ == "__main__":
    videos()
    pictures()
    with tempfile.TemporaryDirectory() as folder:
        of_the_program(Path(folder))
