"""The Wireshark dissector against `magician decode`: session_dissect.py PTY UDP TCP SPEED MAGICIAN

Records a trace of an arm of its own, with every command in every form and with damaged frames, and
lets tshark read it through docs/reference/wireshark/magician.lua. Every frame must have the fields and values
that `magician decode --json` reports. Then the same bytes are tried as UDP datagrams of several
frames, and as TCP segments cut at arbitrary positions.
"""

import json
import math
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

from checks import TIMEOUT, Checks
from sim import Sim
from wire import GET, QUEUED, SET, Tcp, frame, split

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "docs" / "reference" / "wireshark" / "magician.lua"
# Ignores the user's own settings and plugins.
SURROUNDINGS = {**os.environ, "WIRESHARK_CONFIG_DIR": "/nonexistent"}
ARM_PORT, HOST_PORT = 8899, 50000
TCP_PROTOCOL, UDP_PROTOCOL = 6, 17
RAW_IP = 101
PTP, PTPPO, MOTOR, HOME, START, ALARMS, CLEAR = 84, 88, 135, 31, 240, 20, 245
BLOCK_INTERFACE, BLOCK_PACKET = 1, 6


# ------------------------------------------------------------------------------------------------------- what is sent


def commands(magician):
    """Returns every command as listed by `magician commands`."""
    run = subprocess.run([magician, "commands", "--json"], capture_output=True, check=True)
    return [json.loads(line) for line in run.stdout.splitlines()][0]["commands"]


def layouts(magician, ident):
    run = subprocess.run([magician, "commands", str(ident), "--json"], capture_output=True, check=True)
    return [layout for layout in json.loads(run.stdout)["layouts"].values() if layout]


def counts(known):
    """Returns the numbers of parameter bytes to try: those of every layout, one less, one more and
    eight more."""
    sizes = {0, 1, 2, 3, 4, 8}
    for layout in known:
        fixed = layout["bytes"]
        sizes |= {fixed, max(fixed - 1, 0), fixed + 1, fixed + 8} if fixed is not None else {17, 18, 21, 22, 25, 26, 40}
    return sorted(sizes)


def parameters(rng, count, texts):
    """Returns random bytes, with text where text is expected, and with some floats of reasonable
    size."""
    if texts:
        return bytes(rng.choice(b"Dobi 3\xc3\xa4\0") if rng.random() < 0.05 else rng.randrange(32, 127) for _ in range(count))
    if rng.random() < 0.5:
        return bytes(rng.randrange(256) for _ in range(count))
    floats = b"".join(struct.pack("<f", rng.uniform(-300, 300)) for _ in range(count // 4 + 1))
    return (bytes([rng.randrange(3)]) * (count % 4) + floats)[:count]


def drive(link, magician):
    """Sends every kind of request to the arm. Returns the number of complete requests."""
    rng, sent = random.Random(8899), 0

    def ask(data):
        link.send(data)
        nonlocal sent
        sent += 1

    for row in commands(magician):
        known = layouts(magician, row["id"])
        texts = any(field["type"] == "text" for layout in known for field in layout["fields"])
        ask(frame(row["id"]))
        for count in counts(known):
            for ctrl in (GET, SET, 2, QUEUED):
                ask(frame(row["id"], ctrl, parameters(rng, count, texts)))
        while link.read(0.02):
            pass
    ask(frame(CLEAR, SET))
    ask(frame(ALARMS, SET))
    target = struct.pack("<B4f", 1, 200, 50, 30, 0)
    outputs = bytes([50, 4, 0, 1, 75, 5, 0, 0])
    for data in (
        frame(PTP, QUEUED, target),
        frame(PTPPO, QUEUED, target + outputs),
        frame(PTPPO, QUEUED, target + bytes([2]) + outputs),
        frame(PTPPO, QUEUED, target + bytes([9]) + outputs),
        frame(MOTOR, QUEUED, struct.pack("<BBf", 0, 1, 1000)),
        frame(HOME, QUEUED),
        frame(START, SET),
        frame(10, 0x14),
        frame(10, 0xC4),
        frame(238, QUEUED, b"what"),
        frame(1, SET, "Döbi ☃".encode() + b"\0"),
        frame(1),
    ):
        ask(data)
    while link.read(0.1):
        pass
    return sent


def damage(link):
    """Sends bytes that are no frame, each followed by a frame."""
    bad = bytearray(frame(PTP, QUEUED, struct.pack("<B4f", 1, 200, 50, 30, 0)))
    bad[-1] ^= 1
    for data in (b"M10\r\n", bytes(bad), b"Wrong \xaa data \r\n", b"\xaa\xaa\x01", b"\xaa\xaa\xff\x0a", bytes(40)):
        link.send(data + frame(10))
        link.replies(1)


# --------------------------------------------------------------------------------------------------- what came of it


def pairs(items):
    """Collects the pairs of an object in which keys may repeat."""
    found = {}
    for key, value in items:
        found.setdefault(key, []).append(value)
    return found


def fields(tree, into):
    """Collects all fields of a tree by name, with the displayed text and the bytes of every
    occurrence."""
    for key, values in tree.items():
        for value in values:
            if isinstance(value, dict):
                fields(value, into)
            elif key.endswith("_raw"):
                flat = value if isinstance(value, list) else [value]
                into.setdefault(key, []).append(flat[0])
            else:
                into.setdefault(key, []).append(value)
    return into


def dissected(path, *more):
    """Returns every frame and every run of foreign bytes in a file, as the fields that tshark
    reports."""
    command = ["tshark", "-n", "-X", f"lua_script:{SCRIPT}", *more, "-r", path, "-T", "json", "-x", "-J", "magician"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=10 * TIMEOUT, env=SURROUNDINGS)
    # tshark also writes a warning about the superuser to this stream.
    wrong = [line for line in run.stderr.splitlines() if "Lua" in line or "rror" in line]
    packets = json.loads(run.stdout, object_pairs_hook=pairs)
    found = []
    for packet in packets:
        layers = packet["_source"][0]["layers"][0]
        found += [fields(tree, {}) for tree in layers.get("magician", []) if isinstance(tree, dict)]
    return found, wrong + ([] if run.returncode == 0 else [f"status {run.returncode}"])


def decoded(magician, path):
    run = subprocess.run([magician, "decode", "--json", path], capture_output=True, timeout=5 * TIMEOUT)
    return [json.loads(line) for line in run.stdout.splitlines()]


# ---------------------------------------------------------------------------------------------------- are they equal


def is_frame(tree):
    return tree.get("magician.checksum.good") in (["1"], ["True"])


def same_number(shown, raw, value):
    """True if a field has a value: as text within the rounding of the text, and as bytes
    exactly."""
    if isinstance(value, str) and value.lower() in ("nan", "inf", "-inf"):
        return math.isnan(float(value)) and "nan" in shown.lower() or float(shown) == float(value)
    if isinstance(value, float) and len(raw) == 8:
        exact = struct.unpack("<f", bytes.fromhex(raw))[0]
        return exact == struct.unpack("<f", struct.pack("<f", value))[0] and math.isclose(float(shown), value, rel_tol=5e-6, abs_tol=1e-42)
    return float(shown) == float(value) if isinstance(value, float) else int(shown, 0) == value


def same_field(tree, name, value):
    """True if a frame has a field with the value that `decode` reports."""
    shown, raw = tree.get(name, []), tree.get(f"{name}_raw", [])
    if isinstance(value, list) and value and isinstance(value[0], dict):
        of = lambda part: [int(text) for text in tree.get(f"{name}.{part}", [])]
        entries = list(zip(of("ratio"), of("address"), of("level"), strict=True))
        return entries == [(entry["ratio"], entry["address"], entry["level"]) for entry in value]
    if isinstance(value, list) and name.endswith(".alarms_state"):
        return raw == [bytes(value).hex()]
    if isinstance(value, list):
        return len(shown) == len(value) and all(same_number(*pair) for pair in zip(shown, raw, value))
    if isinstance(value, str) and value not in ("NaN", "inf", "-inf"):
        return shown == [value] or raw == [value.lower()]
    return len(shown) == 1 and same_number(shown[0], raw[0], value)


def differences(tree, line):
    """Returns the differences between the two readings of a frame, and the number of its fields."""
    wrong, count = [], 0

    def check(what, kept):
        nonlocal count
        count += 1
        if not kept:
            wrong.append(what)

    ctrl = int(tree["magician.ctrl"][0], 0)
    check("id", tree["magician.id"] == [str(line["id"])])
    check("command", tree.get("magician.command", [None]) == [line["command"]])
    check("queued", bool(ctrl & 2) == line["queued"])
    check("understood", ("magician.params" not in tree) == (line["ok"] or not line["params"]["raw"]))
    if not line["ok"]:
        check("raw", tree.get("magician.params_raw", [""]) == [line["params"]["raw"].lower()])
        return wrong, count
    check("direction", tree["magician.direction"] == [line["direction"]])
    check("notes", tree.get("magician.note", []) == line["notes"])
    own = [name for name in tree if name.startswith("magician.") and not name.endswith("_raw") and name.count(".") == 2]
    own = [name for name in own if not name.startswith(("magician.ctrl.", "magician.checksum.", "magician.expert."))]
    prefix = own[0].rpartition(".")[0] if own else "magician"
    check("no other field", all(name.startswith(prefix + ".") for name in own))
    check("no more fields", {name.rpartition(".")[2] for name in own} <= set(line["params"]))
    for name, value in line["params"].items():
        where = "magician.queued_cmd_index" if name == "queued_cmd_index" else f"{prefix}.{name}"
        check(f"{name}={value}", value == [] and where not in tree or same_field(tree, where, value))
    return wrong, count


def compare(checks, what, trees, lines):
    """Compares all frames with their lines, in order."""
    frames, wanted = [tree for tree in trees if is_frame(tree)], [line for line in lines if "id" in line]
    checks.equal(f"{what}: number of frames", len(frames), len(wanted))
    wrong, count = [], 0
    for tree, line in zip(frames, wanted):
        of_frame, fields_of_frame = differences(tree, line)
        count += fields_of_frame
        wrong += [f"{line['hex']}: {field}" for field in of_frame]
    told = f"{len(frames)} frames, {count - len(wrong)} of {count} fields equal"
    checks.ok(f"{what}: all fields of all frames", not wrong and count, "; ".join([told, *wrong[:5]]))


def compare_damage(checks, trees, lines):
    bad = [tree["magician.damaged_raw"][0] for tree in trees if tree.get("magician.checksum.good") in (["0"], ["False"])]
    checks.equal("frames with a wrong checksum", bad, [l["hex"].lower() for l in lines if l.get("error") == "checksum"])
    checks.ok("there is one", bad)
    noise = "".join(tree["magician.noise_raw"][0] for tree in trees if "magician.noise_raw" in tree)
    checks.equal("foreign bytes", noise, "".join(l["hex"] for l in lines if l.get("error") == "noise").lower())


# ------------------------------------------------------------------------------------------------------------ networks


def packets(path):
    """Packets of a trace as (true if sent by the arm, bytes)."""
    data, at = pathlib.Path(path).read_bytes(), 0
    while at < len(data):
        kind, length = struct.unpack_from("<II", data, at)
        if kind == BLOCK_PACKET:
            count = struct.unpack_from("<I", data, at + 20)[0]
            options = at + 28 + (count + 3) // 4 * 4
            yield struct.unpack_from("<HHI", data, options)[2] & 3 == 1, data[at + 28 : at + 28 + count]
        at += length


def network(path, protocol, pieces):
    """Writes pieces, (true if sent by the arm, bytes), as IPv4 packets of a protocol."""
    sequence = {True: 1000, False: 2000}
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 1 << 18, RAW_IP))
        for number, (reply, data) in enumerate(pieces):
            ports = (ARM_PORT, HOST_PORT) if reply else (HOST_PORT, ARM_PORT)
            if protocol == UDP_PROTOCOL:
                head = struct.pack(">HHHH", *ports, 8 + len(data), 0)
            else:
                head = struct.pack(">HHIIBBHHH", *ports, sequence[reply], sequence[not reply], 0x50, 0x18, 8192, 0, 0)
                sequence[reply] += len(data)
            ends = (b"\x0a\0\0\x02", b"\x0a\0\0\x01") if reply else (b"\x0a\0\0\x01", b"\x0a\0\0\x02")
            whole = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(head) + len(data), number & 0xFFFF, 0, 64, protocol, 0)
            whole += ends[0] + ends[1] + head + data
            file.write(struct.pack("<IIII", number, 0, len(whole), len(whole)) + whole)


def streams(path):
    """Returns the bytes of each direction, frames only, as a lossless network carries them."""
    found = {True: b"", False: b""}
    for reply, data in packets(path):
        if data[:2] == b"\xaa\xaa" and len(data) > 5 and sum(data[3:]) & 0xFF == 0:
            found[reply] += data
    return found


def over_networks(checks, magician, home, trace):
    rng, path = random.Random(48899), os.path.join(home, "network.pcap")
    both = streams(trace)
    for what, protocol in (("UDP", UDP_PROTOCOL), ("TCP", TCP_PROTOCOL)):
        for reply, side in ((False, "requests"), (True, "replies")):
            data, pieces = both[reply], []
            if protocol == UDP_PROTOCOL:
                frames = [frame(*found) for found in split(data)[0]]
                while frames:
                    count = rng.randrange(1, 6)
                    pieces.append((reply, b"".join(frames[:count])))
                    frames = frames[count:]
            while data and protocol == TCP_PROTOCOL:
                count = rng.randrange(1, 90)
                pieces.append((reply, data[:count]))
                data = data[count:]
            network(path, protocol, pieces)
            pathlib.Path(home, "bytes").write_bytes(both[reply])
            side_of = "arm" if reply else "host"
            run = [magician, "decode", "--json", "--from", side_of, os.path.join(home, "bytes")]
            lines = [json.loads(line) for line in subprocess.run(run, capture_output=True, timeout=5 * TIMEOUT).stdout.splitlines()]
            trees, wrong = dissected(path)
            checks.equal(f"{what} {side}: tshark has nothing to complain of", wrong, [])
            compare(checks, f"{what} {side}, {len(pieces)} packets", trees, lines)


def info_column(checks, trace):
    command = ["tshark", "-n", "-X", f"lua_script:{SCRIPT}", "-r", trace, "-T", "fields", "-e", "_ws.col.Info"]
    lines = subprocess.run([*command, "-Y", "magician.id == 10 && magician.pose.x"], capture_output=True, text=True, env=SURROUNDINGS).stdout
    checks.ok("the info column tells the pose", lines.startswith("GetPose reply x=259.104 y="), lines.split("\n")[0])
    command += ["-Y", "magician.ptp_cmd.ptp_mode == 1 && magician.ctrl.queued == 1"]
    lines = subprocess.run(command, capture_output=True, text=True, env=SURROUNDINGS).stdout
    checks.ok("a filter by a field's value finds a move", "SetPTPCmd request queued ptp_mode=MovjXyz" in lines, lines.split("\n")[0])


def main():
    magician = sys.argv[5]
    checks = Checks()
    with tempfile.TemporaryDirectory(prefix="magician-") as home:
        trace = os.path.join(home, "session.pcapng")
        sim = Sim(magician, os.path.join(home, "arm"), "max", "--trace", trace, quiet=True)
        link = Tcp(sim.tcp)
        sent = drive(link, magician)
        damage(link)
        for what, kept in sim.stop():
            checks.ok(what, kept)
        trees, wrong = dissected(trace)
        lines = decoded(magician, trace)
        checks.equal("tshark has nothing to complain of", wrong, [])
        requests = sum(line.get("direction") == "request" or "raw" in line.get("params", {}) for line in lines)
        checks.ok("every request is in the trace", requests >= sent, f"{requests} of {sent}")
        compare(checks, "trace", trees, lines)
        compare_damage(checks, trees, lines)
        info_column(checks, trace)
        over_networks(checks, magician, home, trace)
    checks.finish()


if __name__ == "__main__":
    main()
