"""Makes landscape.png, the photo of the recipes: a lake between mountains, computed.

    python3 docs/recipes/landscape.py crates/magician-program/samples/landscape.png

Needs nothing but Python. It is in the public domain, and so is what it makes.
"""

import math
import struct
import sys
import zlib

WIDTH, HEIGHT = 360, 270
SHORE = 0.64


def noise(seed, x):
    """A number from 0 to 1 for each whole number, and what lies smoothly between them."""

    def at(n):
        n = (n * 374761393 + seed * 668265263) & 0xFFFFFFFF
        n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
        return ((n ^ (n >> 16)) & 0xFFFF) / 0xFFFF

    low = math.floor(x)
    share = x - low
    share = share * share * (3 - 2 * share)
    return at(low) * (1 - share) + at(low + 1) * share


def rough(seed, x, octaves=6):
    """Noise of several sizes, from -1 to 1."""
    return sum((2 * noise(seed + n, x * 2**n) - 1) / 2**n for n in range(octaves)) / 2


def ridge(layer, x):
    """How high up a ridge is, from the top of the picture."""
    base, height, wide = [(0.47, 0.30, 3.0), (0.55, 0.20, 4.5), (0.62, 0.10, 7.0)][layer]
    return base - height * (0.35 + rough(11 * layer + 3, x * wide + layer))


def above_water(x, y):
    """How light the picture is there, 0 to 1."""
    for layer in (2, 1, 0):
        top = ridge(layer, x)
        if y > top:
            far = (0.58, 0.36, 0.16)[layer]
            depth = (y - top) / max(SHORE - top, 0.02)
            slope = rough(40 + layer, x * 23 + y * 9) - rough(60 + layer, x * 17 - y * 21)
            snow = 0.38 if layer == 0 and depth < 0.35 + 0.3 * rough(80, x * 30) else 0.0
            return far + 0.16 * depth + 0.13 * slope + snow * (0.75 + slope)
    sun = math.hypot((x - 0.68) * WIDTH / HEIGHT, y - 0.13)
    cloud = max(0.0, rough(90, x * 4 + 9 * y) + rough(95, y * 16 + x)) * 0.35
    glow = 0.45 * math.exp(-((sun / 0.16) ** 2))
    return min(1.0, 0.62 + 0.35 * y + glow + cloud) if sun > 0.045 else 1.0


def tree(x, y):
    """Whether firs on the bank in front cover it."""
    bank = 0.95 - 0.10 * math.exp(-(((x - 0.05) / 0.22) ** 2)) - 0.06 * math.exp(-(((x - 1.0) / 0.2) ** 2))
    if y > bank + 0.012 * rough(120, x * 40):
        return True
    for n, (root, tall) in enumerate([(0.05, 0.55), (0.13, 0.40), (0.20, 0.30), (0.26, 0.19), (0.92, 0.34), (0.985, 0.46)]):
        top = 0.95 - tall
        if y > top:
            down = (y - top) / tall
            step = 0.35 + 0.65 * ((down * (9 + n % 3)) % 1.0)
            if abs(x - root) * WIDTH / HEIGHT < 0.13 * tall / 0.5 * down * step + 0.003:
                return True
    return False


def grey(x, y):
    if tree(x, y):
        return 0.05 + 0.05 * (1 + rough(130, x * 60 + y * 37))
    if y < SHORE:
        return above_water(x, y)
    down = (y - SHORE) / (1 - SHORE)
    wave = 0.012 * down * math.sin(y * 420 + 5 * rough(140, x * 6)) + 0.004 * rough(150, y * 90 + x * 7)
    light = above_water(x + wave, SHORE - (y - SHORE) * 0.95)
    ripple = 0.10 * down * rough(160, y * 130 + 3 * rough(170, x * 9))
    return 0.80 * light + 0.02 + ripple


def main():
    rows = []
    for row in range(HEIGHT):
        pixels = (grey((column + 0.5) / WIDTH, (row + 0.5) / HEIGHT) for column in range(WIDTH))
        rows.append(b"\0" + bytes(round(255 * min(max(pixel, 0.0), 1.0)) for pixel in pixels))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 0, 0, 0, 0)
    with open(sys.argv[1], "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b""))


main()
