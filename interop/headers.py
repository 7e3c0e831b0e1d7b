"""Contents of the C headers, for comparison with the declarations in Python."""

import ctypes
import re

NUMBERS = {
    "int": ctypes.c_int32, "int32_t": ctypes.c_int32, "uint8_t": ctypes.c_uint8, "bool": ctypes.c_uint8,
    "uint16_t": ctypes.c_uint16, "uint32_t": ctypes.c_uint32, "uint64_t": ctypes.c_uint64, "float": ctypes.c_float,
    "char": ctypes.c_char,
}
# Structures with another name in Python.
PYTHON_NAMES = {"EndEffectorParams": "EndTypeParams"}


def plain(path):
    """Returns a header without its comments."""
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", path.read_text(), flags=re.S)


def structures(path):
    """Returns the packed size of every structure."""
    sizes = {name: ctypes.sizeof(kind) for name, kind in NUMBERS.items()}
    known = set(sizes)
    # All members of these unions have the same size: the first one replaces the union.
    text = re.sub(r"\w*\s*union\s*\{\s*([^;]*;)[^}]*\};", r"\1", plain(path))
    # The members of an anonymous structure are equivalent to members of the enclosing one.
    text = re.sub(r"struct\s*\{([^}]*)\}\s*\w+;", r"\1", text)
    for enum in re.findall(r"typedef enum.*?\}\s*(\w+);", text, re.S):
        sizes[enum] = 4
        known.add(enum)
    for body, name in re.findall(r"typedef struct\s*\w*\s*\{(.*?)\}\s*(\w+);", text, re.S):
        sizes[name] = 0
        for kind, stars, names in re.findall(r"(?:const\s+)?(\w+)\s+(\**)([^;]*);", body):
            one = ctypes.sizeof(ctypes.c_void_p) if "*" in stars + names else sizes[kind]
            for declared in names.split(","):
                sizes[name] += one * int((re.search(r"\[(\d+)\]", declared) or (0, 1))[1])
    return {name: size for name, size in sizes.items() if name not in known}


def functions(path):
    """Returns the argument types of every function as written."""
    found = {}
    for name, arguments in re.findall(r"DOBOTDLLSHARED_EXPORT int (\w+)\(([^)]*)\);", plain(path)):
        arguments = [] if arguments.strip() == "void" else arguments.split(",")
        found[name] = [re.match(r"\s*(?:const )?(\w+)\s*(\**)", argument).groups() for argument in arguments]
    return found


def is_compatible(c_type, ctypes_type):
    """True if ctypes passes what C expects."""
    kind, stars = c_type
    if not stars:
        return ctypes_type is NUMBERS.get(kind, ctypes.c_int32)
    if kind == "char":
        return ctypes_type is ctypes.c_char_p
    pointed = getattr(ctypes_type, "_type_", None)
    if kind in NUMBERS:
        # Bytes may also be returned into a string buffer.
        return pointed is NUMBERS[kind] or kind == "uint8_t" and ctypes_type is ctypes.c_char_p
    if isinstance(pointed, type) and issubclass(pointed, ctypes.Structure):
        return pointed.__name__ == PYTHON_NAMES.get(kind, kind)
    return pointed is ctypes.c_int32
