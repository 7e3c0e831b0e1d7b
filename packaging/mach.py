"""What can be said of a program or library for macOS without a Mac: what it needs, and whether its signature fits.

`packaging/mach.py FILE` prints it as JSON.
"""

import hashlib
import json
import pathlib
import struct
import sys

MAGIC = 0xFEEDFACF
PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "aarch64"}
VERSION_MIN_MACOSX, RPATH, BUILD_VERSION = 0x24, 0x8000001C, 0x32
LOAD_DYLIB, LOAD_WEAK_DYLIB, REEXPORT_DYLIB, CODE_SIGNATURE = 0xC, 0x80000018, 0x8000001F, 0x1D
SUPERBLOB, CODE_DIRECTORY = 0xFADE0CC0, 0xFADE0C02
SHA256 = 2


def _commands(data):
    """Kind and bytes of each load command (mach-o/loader.h)."""
    magic, *_, count, _, _, _ = struct.unpack_from("<8I", data)
    if magic != MAGIC:
        raise ValueError("this is no 64-bit Mach-O")
    at = 32
    for _ in range(count):
        kind, size = struct.unpack_from("<2I", data, at)
        yield kind, data[at : at + size]
        at += size


def _names(data, *kinds):
    for kind, command in _commands(data):
        if kind in kinds:
            (start,) = struct.unpack_from("<I", command, 8)
            yield command[start:].rstrip(b"\0").decode()


def libraries(data):
    """The libraries that it needs."""
    return _names(data, LOAD_DYLIB, LOAD_WEAK_DYLIB, REEXPORT_DYLIB)


def paths(data):
    """Where it looks for libraries besides where the system does."""
    return _names(data, RPATH)


def processor(data):
    """What it is for, in Rust's words."""
    return PROCESSORS.get(struct.unpack_from("<I", data, 4)[0])


def oldest(data):
    """The oldest macOS that it says it runs on."""
    for kind, command in _commands(data):
        if kind in (BUILD_VERSION, VERSION_MIN_MACOSX):
            (version,) = struct.unpack_from("<I", command, 12 if kind == BUILD_VERSION else 8)
            return f"{version >> 16}.{version >> 8 & 0xFF}"
    return None


def signature(data):
    """What is wrong with its signature, nothing if it fits: macOS on Apple's processors ends what has one that does not.

    The pages' hashes are compared (cs_blobs.h of XNU); a signature of this kind names nobody.
    """
    places = [struct.unpack_from("<2I", command, 8) for kind, command in _commands(data) if kind == CODE_SIGNATURE]
    if not places:
        return "there is none"
    ((start, size),) = places
    blob = data[start : start + size]
    magic, _, count = struct.unpack_from(">3I", blob)
    if magic != SUPERBLOB:
        return "it is none"
    for number in range(count):
        _, at = struct.unpack_from(">2I", blob, 12 + 8 * number)
        if struct.unpack_from(">I", blob, at)[0] == CODE_DIRECTORY:
            return _pages(data, blob[at:])
    return "it has no hashes"


def _pages(data, directory):
    hashes, _, _, pages, limit = struct.unpack_from(">5I", directory, 16)
    width, kind, _, page = struct.unpack_from(">4B", directory, 36)
    if kind != SHA256 or (pages - 1) << page >= limit or pages << page < limit:
        return "it is not of the kind that is known here"
    for number in range(pages):
        part = data[number << page : min((number + 1) << page, limit)]
        had = directory[hashes + number * width : hashes + (number + 1) * width]
        if hashlib.sha256(part).digest() != had:
            return f"page {number} of {pages} was changed after it was signed"
    return ""


if __name__ == "__main__":
    content = pathlib.Path(sys.argv[1]).read_bytes()
    print(json.dumps({"processor": processor(content), "oldest": oldest(content), "libraries": list(libraries(content)),
                      "paths": list(paths(content)), "signature": signature(content)}))
