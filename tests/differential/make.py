#!/usr/bin/env python3
"""Random pictures of every format, and what other readers make of them.

Neither reader composes every APNG rightly: their frames are read by Pillow and composed here.

    make.py --seed N --count N FOLDER

writes COUNT files of each format to FOLDER, and `cases.txt`: a line of tab-separated fields for each,
`file`, `tolerance` (mean and largest difference of a channel), and for each reader `name:width:height:frames`
with its frames as raw RGBA in `file.name.rgba`. Readers are Pillow (with libwebp, libtiff, libjpeg-turbo) and
ffmpeg, where it is on the path.
"""
import argparse
import io
import os
import random
import shutil
import struct
import subprocess
import sys
import zlib

from PIL import Image, ImageOps, ImageSequence

Image.MAX_IMAGE_PIXELS = None


def picture(rng, mode, size):
    """A picture of areas of one colour and ramps, some of it transparent."""
    width, height = size
    image = Image.new("RGBA", size, tuple(rng.randrange(256) for _ in range(3)) + (255,))
    pixels = image.load()
    for _ in range(rng.randrange(2, 7)):
        x0, y0 = rng.randrange(width), rng.randrange(height)
        x1, y1 = rng.randrange(x0, width) + 1, rng.randrange(y0, height) + 1
        colour = [rng.randrange(256) for _ in range(3)]
        alpha = rng.choice([255, 255, 255, 0, rng.randrange(256)])
        step = rng.choice([0, 0, 3, 7])
        for y in range(y0, y1):
            for x in range(x0, x1):
                shade = [min(255, c + step * ((x + y) % 16)) for c in colour]
                pixels[x, y] = tuple(shade) + (alpha,)
    return image.convert(mode)


def some_size(rng, most=40):
    return rng.randrange(1, most), rng.randrange(1, most)


# PNG and APNG, written here.

SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
ADAM7 = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def samples(rng, colour, depth, size, entries):
    """Rows of samples: areas of one value and some noise."""
    width, height = size
    count = SAMPLES[colour]
    most = min((1 << depth) - 1, entries - 1) if colour == 3 else (1 << depth) - 1
    value = lambda: [rng.randint(0, most) for _ in range(count)]
    base = value()
    rows = [[list(base) for _ in range(width)] for _ in range(height)]
    for _ in range(3):
        x0, y0 = rng.randrange(width), rng.randrange(height)
        x1, y1 = rng.randrange(x0, width) + 1, rng.randrange(y0, height) + 1
        fill = value()
        for y in range(y0, y1):
            for x in range(x0, x1):
                rows[y][x] = list(fill)
    for _ in range(width * height // 6):
        rows[rng.randrange(height)][rng.randrange(width)] = value()
    return rows


def packed(row, depth):
    flat = [v for pixel in row for v in pixel]
    if depth == 16:
        return b"".join(struct.pack(">H", v) for v in flat)
    if depth == 8:
        return bytes(flat)
    out, bits, number = bytearray(), 0, 0
    for value in flat:
        bits, number = bits << depth | value, number + depth
        if number == 8:
            out.append(bits)
            bits, number = 0, 0
    if number:
        out.append(bits << (8 - number))
    return bytes(out)


def filtered(rng, lines, bpp):
    out, before = bytearray(), None
    for line in lines:
        kind = rng.randrange(5)
        above = before or bytes(len(line))
        left = bytes(bpp) + line
        corner = bytes(bpp) + above
        out.append(kind)
        for i, value in enumerate(line):
            a, b, c = left[i], above[i], corner[i]
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            out.append((value - (0, a, b, (a + b) // 2, paeth)[kind]) & 255)
        before = line
    return bytes(out)


def png_data(rng, rows, colour, depth, interlaced):
    bpp = max(1, SAMPLES[colour] * depth // 8)
    if not interlaced:
        return zlib.compress(filtered(rng, [packed(row, depth) for row in rows], bpp))
    out = b""
    for x0, y0, dx, dy in ADAM7:
        lines = [packed(row[x0::dx], depth) for row in rows[y0::dy] if row[x0::dx]]
        out += filtered(rng, lines, bpp)
    return zlib.compress(out)


def png_head(rng, size, colour, depth, interlaced):
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", *size, depth, colour, 0, 0, int(interlaced)))
    rest, entries = b"", 0
    if colour == 3:
        entries = rng.randint(1, 1 << depth)
        rest += chunk(b"PLTE", bytes(rng.randrange(256) for _ in range(3 * entries)))
        if rng.random() < 0.5:
            rest += chunk(b"tRNS", bytes(rng.randrange(256) for _ in range(rng.randint(1, entries))))
    elif colour in (0, 2) and depth == 8 and rng.random() < 0.3:
        rest += chunk(b"tRNS", struct.pack(">H", rng.randrange(256)) * SAMPLES[colour])
    return head, rest, entries


def png(rng, path):
    colour = rng.choice(list(SAMPLES))
    depth, size, interlaced = rng.choice(DEPTHS[colour]), some_size(rng), rng.random() < 0.4
    head, rest, entries = png_head(rng, size, colour, depth, interlaced)
    data = png_data(rng, samples(rng, colour, depth, size, entries), colour, depth, interlaced)
    exif = b""
    if rng.random() < 0.3:
        exif = chunk(b"eXIf", exif_of(rng.randint(1, 8)))
    cut = rng.randrange(len(data) + 1)
    parts = chunk(b"IDAT", data[:cut]) + chunk(b"IDAT", data[cut:])
    write(path, b"\x89PNG\r\n\x1a\n" + head + rest + exif + parts + chunk(b"IEND", b""))
    # Some readers cut 16 bits off, others round them, of colours and of alpha.
    return 1.5, 3


def apng(rng, path):
    colour = rng.choice([2, 6, 6, 6, 3, 0, 4])
    depth, interlaced = rng.choice(DEPTHS[colour]), rng.random() < 0.25
    canvas = some_size(rng)
    head, rest, entries = png_head(rng, canvas, colour, depth, interlaced)
    count, hidden = rng.randint(1, 7), rng.random() < 0.25
    parts = [head, chunk(b"acTL", struct.pack(">II", count, rng.randrange(4))), rest]
    data = lambda size: png_data(rng, samples(rng, colour, depth, size, entries), colour, depth, interlaced)
    if hidden:
        parts.append(chunk(b"IDAT", data(canvas)))
    number = 0
    for i in range(count):
        size, place = canvas, (0, 0)
        if i > 0 or (hidden and rng.random() < 0.5):
            size = rng.randint(1, canvas[0]), rng.randint(1, canvas[1])
            place = rng.randint(0, canvas[0] - size[0]), rng.randint(0, canvas[1] - size[1])
        control = struct.pack(">IIIIIHHBB", number, *size, *place, rng.randrange(1, 9), rng.choice([0, 10, 100]),
                              rng.randrange(3), rng.randrange(2))
        parts.append(chunk(b"fcTL", control))
        number += 1
        if i == 0 and not hidden:
            parts.append(chunk(b"IDAT", data(size)))
            continue
        body = data(size)
        cut = rng.randrange(len(body) + 1)
        for piece in (body[:cut], body[cut:]):
            parts.append(chunk(b"fdAT", struct.pack(">I", number) + piece))
            number += 1
    write(path, b"\x89PNG\r\n\x1a\n" + b"".join(parts) + chunk(b"IEND", b""))
    return 1.5, 5


# GIF, written here: codes of one width, which every decoder reads.

def lzw(indices):
    """Codes of 9 bits, cleared before they would grow."""
    codes, out, bits, number = [256], bytearray(), 0, 0
    for i, index in enumerate(indices):
        if i and i % 200 == 0:
            codes.append(256)
        codes.append(index)
    codes.append(257)
    for code in codes:
        bits |= code << number
        number += 9
        while number >= 8:
            out.append(bits & 255)
            bits, number = bits >> 8, number - 8
    if number:
        out.append(bits & 255)
    blocks = [out[i:i + 255] for i in range(0, len(out), 255)]
    return b"\x08" + b"".join(bytes([len(b)]) + bytes(b) for b in blocks) + b"\0"


def gif(rng, path):
    canvas = some_size(rng)
    palette = lambda: bytes(rng.randrange(256) for _ in range(48))
    parts = [b"GIF89a" + struct.pack("<HHBBB", *canvas, 0xf3, 0, 0) + palette()]
    if rng.random() < 0.5:
        name = rng.choice([b"NETSCAPE2.0", b"ANIMEXTS1.0"])
        parts.append(b"!\xff\x0b" + name + b"\x03\x01" + struct.pack("<H", rng.randrange(5)) + b"\0")
    # Without a transparent colour, other readers clear to the background's: browsers do not.
    transparent = rng.random() < 0.7
    disposals = 4 if transparent else 2
    for i in range(rng.randint(1, 7)):
        size, place = canvas, (0, 0)
        if i:
            size = rng.randint(1, canvas[0]), rng.randint(1, canvas[1])
            place = rng.randint(0, canvas[0] - size[0]), rng.randint(0, canvas[1] - size[1])
        if rng.random() < 0.2:
            parts.append(rng.choice([b"!\x42\x02ab\0", b"!\xfe\x03hey\0"]))
        flags = rng.randrange(disposals) << 2 | int(transparent)
        parts.append(b"!\xf9\x04" + struct.pack("<BHB", flags, rng.randrange(2, 20), rng.randrange(16)) + b"\0")
        interlaced, local = rng.random() < 0.3, rng.random() < 0.3
        rows = [bytes(p[0] for p in row) for row in samples(rng, 3, 4, size, 16)]
        if interlaced:
            order = [y for first, step in ((0, 8), (4, 8), (2, 4), (1, 2)) for y in range(first, size[1], step)]
            rows = [rows[y] for y in order]
        described = (0x40 if interlaced else 0) | (0x83 if local else 0)
        parts.append(b"," + struct.pack("<HHHHB", *place, *size, described) + (palette() if local else b""))
        parts.append(lzw(b"".join(rows)))
    write(path, b"".join(parts) + b";")
    return 0, 0


# WebP: stills by libwebp, put together to animations here.

def riff(kind, data):
    return kind + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def webp_still(rng, size, lossless):
    mode = rng.choice(["RGB", "RGBA"])
    out = io.BytesIO()
    picture(rng, mode, size).save(out, "WEBP", lossless=lossless, quality=rng.randint(20, 100), exact=True,
                                  method=rng.randrange(3), alpha_quality=rng.choice([100, 60]))
    return out.getvalue()


def webp(rng, path):
    lossless = rng.random() < 0.5
    write(path, webp_still(rng, some_size(rng), lossless))
    return (0, 0) if lossless else (2, 12)


def webp_animation(rng, path):
    canvas = some_size(rng)
    frames = b""
    for i in range(rng.randint(1, 6)):
        size, place = canvas, (0, 0)
        if rng.random() < 0.8:
            size = rng.randint(1, canvas[0]), rng.randint(1, canvas[1])
            place = tuple(rng.randint(0, (c - s) // 2) * 2 for c, s in zip(canvas, size))
        still = webp_still(rng, size, rng.random() < 0.5)[12:]
        if still[:4] == b"VP8X":
            still = still[18:]
        head = b"".join(struct.pack("<I", v)[:3] for v in (place[0] // 2, place[1] // 2, size[0] - 1, size[1] - 1,
                                                          rng.randint(20, 200)))
        frames += riff(b"ANMF", head + bytes([rng.randrange(4)]) + still)
    sizes = struct.pack("<I", canvas[0] - 1)[:3] + struct.pack("<I", canvas[1] - 1)[:3]
    body = riff(b"VP8X", b"\x12\0\0\0" + sizes) + riff(b"ANIM", struct.pack("<IH", 0, rng.randrange(4))) + frames
    write(path, riff(b"RIFF", b"WEBP" + body))
    return 2, 12


# TIFF, written here without compression, and by libtiff with it.

def tiff(rng, path):
    if rng.random() < 0.4:
        mode = rng.choice(["1", "L", "RGB", "RGBA", "CMYK"])
        compression = rng.choice([None, "packbits", "tiff_lzw", "tiff_adobe_deflate"])
        picture(rng, mode, some_size(rng)).save(path, "TIFF", compression=compression)
        return 1, 1
    order = rng.choice("<>")
    kind = rng.choice(["gray", "white", "rgb", "rgba", "premultiplied"])
    bits = {"gray": (1, 2, 4, 8, 16), "white": (1, 2, 4, 8)}.get(kind, (8, 16))
    depth, size = rng.choice(bits), some_size(rng)
    if kind == "premultiplied":
        depth = 8
    count = {"rgb": 3, "rgba": 4, "premultiplied": 4}.get(kind, 1)
    colour = {1: 0, 3: 2, 4: 6}[count]
    rows = samples(rng, colour, depth, size, 0)
    if kind == "premultiplied":
        for row in rows:
            for pixel in row:
                pixel[:3] = [v * pixel[3] // 255 for v in pixel[:3]]
    swapped = lambda data: data if depth != 16 or order == ">" else b"".join(
        data[i + 1:i + 2] + data[i:i + 1] for i in range(0, len(data), 2))
    planar = count > 1 and rng.random() < 0.3
    if planar:
        planes = [[[[p[c]] for p in row] for row in rows] for c in range(count)]
        strips = [b"".join(swapped(packed(row, depth)) for row in plane) for plane in planes]
    else:
        strips = [b"".join(swapped(packed(row, depth)) for row in rows)]
    photometric = {"gray": 1, "white": 0}.get(kind, 2)
    tags = {256: [size[0]], 257: [size[1]], 258: [depth] * count, 259: [1], 262: [photometric],
            274: [1 if depth == 16 else rng.randint(1, 8)], 277: [count], 278: [size[1]], 284: [2 if planar else 1]}
    if count == 4:
        tags[338] = [1 if kind == "premultiplied" else 2]
    at = 8
    tags[273], tags[279] = [], [len(strip) for strip in strips]
    for strip in strips:
        tags[273].append(at)
        at += len(strip)
    body = b"".join(strips)
    body += b"\0" * (len(body) % 2)
    directory = 8 + len(body)
    values, entries = b"", b""
    behind = directory + 2 + 12 * len(tags) + 4
    for tag, value in sorted(tags.items()):
        data = b"".join(struct.pack(order + "H", v) for v in value)
        if len(data) <= 4:
            place = data + b"\0" * (4 - len(data))
        else:
            place = struct.pack(order + "I", behind + len(values))
            values += data
        entries += struct.pack(order + "HHI", tag, 3, len(value)) + place
    mark = b"II" if order == "<" else b"MM"
    write(path, mark + struct.pack(order + "HI", 42, directory) + body + struct.pack(order + "H", len(tags)) +
          entries + b"\0" * 4 + values)
    return 2, 3


def jpeg(rng, path):
    mode = rng.choice(["RGB", "RGB", "RGB", "L"])
    size = rng.randrange(8, 60), rng.randrange(8, 60)
    image = picture(rng, "RGB", size).convert(mode)
    options = {"quality": rng.randint(60, 100), "progressive": rng.random() < 0.4, "optimize": rng.random() < 0.3}
    if mode == "RGB":
        options["subsampling"] = rng.choice([0, 1, 2])
    if rng.random() < 0.3:
        options["restart_marker_blocks"] = rng.randint(1, 5)
    if rng.random() < 0.4:
        options["exif"] = b"Exif\0\0" + exif_of(rng.randint(1, 8))
    cjpeg = shutil.which("cjpeg")
    if cjpeg and mode == "RGB" and rng.random() < 0.3:
        ppm, scans = path + ".ppm", path + ".scans"
        image.save(ppm)
        write(scans, b"0;\n1;\n2;\n")
        sampling = rng.choice(["1x1", "2x1", "1x2", "2x2"])
        subprocess.run([cjpeg, "-quality", "90", "-sample", sampling, "-scans", scans, "-outfile", path, ppm],
                       check=True)
    else:
        image.save(path, "JPEG", **options)
    return 4, 90


def bmp(rng, path):
    size = some_size(rng)
    kind = rng.choice(["1", "L", "P", "RGB", "16", "down"])
    if kind in ("1", "L", "P", "RGB"):
        picture(rng, kind, size).save(path, "BMP")
        return 0, 0
    bits = 16 if kind == "16" else 24
    line = (size[0] * bits + 31) // 32 * 4
    body = b"".join(bytes(rng.randrange(256) for _ in range(line)) for _ in range(size[1]))
    height = -size[1] if kind == "down" else size[1]
    info = struct.pack("<IiiHHIIiiII", 40, size[0], height, 1, bits, 0, len(body), 0, 0, 0, 0)
    write(path, b"BM" + struct.pack("<IHHI", 54 + len(body), 0, 0, 54) + info + body)
    return 1, 8


def pnm(rng, path):
    picture(rng, rng.choice(["1", "L", "RGB"]), some_size(rng)).save(path, "PPM")
    return 0, 0


def exif_of(orientation):
    return b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0" + bytes([orientation]) + b"\0" * 7


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)


# The readers.

def rgba(image):
    if image.mode in ("I;16", "I;16B", "I"):
        raw = image.convert("I").tobytes()
        values = struct.unpack("<%di" % (len(raw) // 4), raw)
        gray = Image.frombytes("L", image.size, bytes((v + 128) // 257 for v in values))
        return gray.convert("RGBA")
    if image.mode == "CMYK":
        return image.convert("RGB").convert("RGBA")
    return image.convert("RGBA")


def by_pillow(path):
    # Not from the file: of what Pillow maps, it forgets the orientation.
    with open(path, "rb") as file:
        data = io.BytesIO(file.read())
    with Image.open(data) as image:
        still = getattr(image, "n_frames", 1) == 1
        hidden = image.info.get("default_image", False)
        frames = []
        for i, frame in enumerate(ImageSequence.Iterator(image)):
            if hidden and i == 0:
                continue
            frames.append(rgba(ImageOps.exif_transpose(frame) if still else frame))
        return frames[0].size, [frame.tobytes() for frame in frames]


def by_composing(path):
    """An APNG's frames, each read by Pillow as a PNG of its own, composed as the specification says."""
    with open(path, "rb") as file:
        data = file.read()
    head, shared, frames, at = None, b"", [], 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body, whole = data[at + 8:at + 8 + length], data[at:at + 12 + length]
        at += 12 + length
        if kind == b"IHDR":
            head = body
        elif kind in (b"PLTE", b"tRNS"):
            shared += whole
        elif kind == b"fcTL":
            frames.append([struct.unpack(">IIIIIHHBB", body), b""])
        elif frames and kind in (b"IDAT", b"fdAT"):
            frames[-1][1] += body if kind == b"IDAT" else body[4:]
    canvas = Image.new("RGBA", struct.unpack(">II", head[:8]))
    answers = []
    for i, ((_, width, height, x, y, _, _, dispose, blend), picture) in enumerate(frames):
        still = chunk(b"IHDR", struct.pack(">II", width, height) + head[8:]) + shared + chunk(b"IDAT", picture)
        still = b"\x89PNG\r\n\x1a\n" + still + chunk(b"IEND", b"")
        frame = rgba(Image.open(io.BytesIO(still)))
        before = canvas.copy()
        if blend:
            canvas.alpha_composite(frame, (x, y))
        else:
            canvas.paste(frame, (x, y))
        answers.append(canvas.tobytes())
        if dispose == 1 or (dispose == 2 and i == 0):
            canvas.paste((0, 0, 0, 0), (x, y, x + width, y + height))
        elif dispose == 2:
            canvas = before
    return canvas.size, answers


def by_ffmpeg(path, size):
    kind = path.rsplit(".", 1)[1]
    if kind in ("webp",) and b"ANMF" in open(path, "rb").read():
        return None
    demuxer = {"apng": "apng", "gif": "gif"}.get(path.rsplit("-", 1)[0].rsplit("/", 1)[1])
    args = ["ffmpeg", "-v", "error", "-nostdin"]
    if demuxer:
        args += ["-f", demuxer]
    args += ["-i", path, "-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgba", "-sws_flags",
             "accurate_rnd+full_chroma_int", "-"]
    done = subprocess.run(args, capture_output=True)
    length = size[0] * size[1] * 4
    if done.returncode or not done.stdout or len(done.stdout) % length:
        return None
    return size, [done.stdout[i:i + length] for i in range(0, len(done.stdout), length)]


KINDS = {"png": (png, "png"), "apng": (apng, "png"), "gif": (gif, "gif"), "webp": (webp, "webp"),
         "webpa": (webp_animation, "webp"), "tiff": (tiff, "tif"), "jpeg": (jpeg, "jpg"), "bmp": (bmp, "bmp"),
         "pnm": (pnm, "ppm")}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("folder")
    args = parser.parse_args()
    ffmpeg = shutil.which("ffmpeg")
    lines = []
    for name, (make, extension) in KINDS.items():
        for i in range(args.count):
            rng = random.Random("%d %s %d" % (args.seed, name, i))
            path = os.path.join(args.folder, "%s-%03d.%s" % (name, i, extension))
            mean, most = make(rng, path)
            fields = [os.path.basename(path), "%g" % mean, "%g" % most]
            read, size = {}, None
            try:
                read["pillow"] = by_pillow(path)
                size = read["pillow"][0]
            except (OSError, TypeError, ValueError):
                # Pillow reads no APNGs of 16 bits, for one.
                pass
            if name == "apng":
                read["pillow"] = by_composing(path)
                size = read["pillow"][0]
            if ffmpeg and size and name != "apng":
                read["ffmpeg"] = by_ffmpeg(path, size)
            for reader, answer in read.items():
                if answer:
                    (width, height), frames = answer
                    write("%s.%s.rgba" % (path, reader), b"".join(frames))
                    fields.append("%s:%d:%d:%d" % (reader, width, height, len(frames)))
            lines.append("\t".join(fields))
    write(os.path.join(args.folder, "cases.txt"), ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    sys.exit(main())
