"""Recordings of the virtual arm, read with the Python library for MCAP: session_record.py PTY UDP
TCP SPEED MAGICIAN

The runner's arm is not used. Each part serves its own arm, drives it, ends it and reads the file.
"""

import json
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message, Metadata, Schema
from mcap.stream_reader import StreamReader

import arm as model
from checks import TIMEOUT, Checks
from sim import Sim
from wire import ALARMS, SET, Tcp, floats, split

PERIOD = 20_000_000
SECOND = 1_000_000_000
START, CLEAR, PTP, WAIT, SUCTION = 240, 20, 84, 110, 62
TOPICS = {
    "/pose": "foxglove.PoseInFrame",
    "/joints": "foxglove.JointStates",
    "/tf": "foxglove.FrameTransform",
    "/scene": "foxglove.SceneUpdate",
    "/events": "foxglove.Log",
    "/queue": "magician.Queue.v1",
    "/io": "magician.Io.v1",
    "/alarms": "magician.Alarms.v1",
    "/status": "magician.Status.v1",
    "/frames": "magician.Frame.v1",
}


def f32(value):
    """Rounds to binary32 as on the wire."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


class Recording:
    """Messages of a finished file by topic, as (time on the arm's clock in ns, value)."""

    def __init__(self, path):
        with open(path, "rb") as file:
            reader = make_reader(file, validate_crcs=True)
            self.summary = reader.get_summary()
            self.metadata = {m.name: m.metadata for m in reader.iter_metadata()}
            self.epoch = int(self.metadata["magician"]["epoch_ns"])
            self.topics = {}
            for _, channel, message in reader.iter_messages(log_time_order=False):
                at = message.log_time - self.epoch
                self.topics.setdefault(channel.topic, []).append((at, json.loads(message.data)))


def off_the_grid(times):
    """Returns the first times that are not 20 ms after the previous one, starting at 0."""
    return [(k, at) for k, at in enumerate(times) if at != k * PERIOD][:3]


def pose_of(value):
    """Returns x y z r in mm and degrees."""
    position, turn = value["pose"]["position"], value["pose"]["orientation"]
    r = math.degrees(2 * math.atan2(turn["z"], turn["w"]))
    return (*(position[axis] * 1000 for axis in "xyz"), r)


def joints_of(value):
    return tuple(math.degrees(joint["position"]) for joint in value["joints"])


def move(mode, *target):
    return struct.pack("<B4f", mode, *target)


def drive(link):
    """Sends commands of every kind. Returns the index of the last one, and the poses that were
    answered meanwhile."""
    link.ask(CLEAR, SET)
    link.ask(START, SET)
    link.queue(PTP, move(model.MOVJ_XYZ, 220, 60, 40, 15))
    link.queue(PTP, move(model.MOVL_XYZ, 240, -50, 10, -20))
    link.queue(SUCTION, b"\1\1")
    link.queue(WAIT, struct.pack("<I", 130))
    last = link.queue(PTP, move(model.JUMP_XYZ, 200, 80, 20, 0))
    poses = [link.pose()]
    while link.index() < last:
        poses.append(link.pose())
        time.sleep(0.002)
    # And during a rest long enough for two samples.
    came = link.time()
    while link.time() < came + 100:
        time.sleep(0.002)
        poses.append(link.pose())
    return last, poses


def finished(checks, magician, home, speed):
    print(f"a recording at speed {speed}, ended with SIGTERM")
    path = os.path.join(home, f"arm-{speed}.mcap")
    sim = Sim(magician, os.path.join(home, "arm"), speed, "--record", path)
    link = Tcp(sim.tcp)
    last, poses = drive(link)
    # Out of reach: an alarm, and the queue stops.
    refused = link.queue(PTP, move(model.MOVJ_XYZ, 400, 0, 0, 0))
    link.wait(refused)
    alarms = link.ask(ALARMS)
    clock = link.time()
    link.close()
    for what, kept in sim.stop():
        checks.ok(what, kept)
    checks.equal("exit status", sim.process.returncode, 0)

    recording = Recording(path)
    described(checks, recording)
    sampled(checks, recording, clock)
    answered(checks, recording, poses)
    seen(checks, recording)
    happened(checks, recording, last, alarms)


def seen(checks, recording):
    """Checks that the frames lead to the tip, and that each link is attached to one of them."""
    topics = recording.topics
    poses = {at: pose_of(v) for at, v in topics["/pose"]}
    frames, off, told = {}, [], 0
    by_time = {}
    for at, v in topics["/tf"]:
        by_time.setdefault(at, []).append(v)
    for at in range(0, max(poses) + 1, SECOND // 5):
        for v in by_time.pop(at, []):
            frames[v["child_frame_id"]] = v
        frame, point = "tip", (0.0, 0.0, 0.0)
        while frame in frames:
            v = frames[frame]
            point = tuple(a + v["translation"][axis] for a, axis in zip(turned(v["rotation"], point), "xyz"))
            frame = v["parent_frame_id"]
        told += 1
        off.append(max(abs(a * 1000 - b) for a, b in zip(point, poses[at])) if frame == "base" else math.inf)
    checks.ok("the frames lead from base to the pose", max(off) < 0.005, f"{max(off):.4f} mm at most, {told} instants")
    checks.equal("frames are written at their instants only", list(by_time), [])
    first = topics["/scene"][0][1]["entities"]
    known = {"base", *frames}
    checks.equal("links", {e["id"] for e in first}, {f"arm/{name}" for name in known})
    parts = [(e["frame_id"], e["cubes"] + e["spheres"] + e["cylinders"]) for e in first]
    checks.ok("each has its shape in its frame", all(f in known and len(shapes) == 1 for f, shapes in parts))


def turned(rotation, point):
    x, y, z, w = (rotation[name] for name in "xyzw")
    cross = lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    t = tuple(2 * v for v in cross((x, y, z), point))
    return tuple(p + w * a + b for p, a, b in zip(point, t, cross((x, y, z), t)))


def drawn(checks, magician, home):
    print("a pen on paper, as an arm that is served and a host that runs a job record it")
    svg, way = os.path.join(home, "line.svg"), os.path.join(home, "way.mcap")
    with open(svg, "w") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm"><path d="M0 0H60V40" transform="scale(3.7795)" fill="none" stroke="black"/></svg>')
    draw = [magician, "--port", "sim", "draw", svg, "--at", "230,0", "--surface", "-60", "--record", way]
    done = subprocess.run(draw, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT)
    checks.equal("exit status", (done.returncode, done.stderr if done.returncode else ""), (0, ""))
    entities = {}
    for _, value in Recording(way).topics["/scene"]:
        if value["deletions"]:
            entities.clear()
        entities.update((e["id"], e) for e in value["entities"])
    length = 0.0
    for line in (line for e in entities.values() for line in e["lines"]):
        checks.equal("a list of lines", line["type"], 2)
        ends = [tuple(line["points"][k][axis] for axis in "xyz") for k in line["indices"]]
        length += sum(math.dist(a, b) for a, b in zip(ends[::2], ends[1::2]))
    checks.ok("as long as what was drawn, but for ends between readings", 0.08 < length < 0.1005, f"{length * 1000:.1f} mm of 100")


def described(checks, recording):
    summary, topics = recording.summary, recording.topics
    schemas = {schema.id: schema for schema in summary.schemas.values()}
    named = {c.topic: schemas[c.schema_id].name for c in summary.channels.values()}
    checks.equal("topics and their schemas", named, TOPICS)
    texts = [json.loads(schema.data) for schema in schemas.values()]
    checks.equal("each schema says its name", {text["title"] for text in texts}, set(TOPICS.values()))
    encodings = {c.message_encoding for c in summary.channels.values()} | {s.encoding for s in schemas.values()}
    checks.equal("encodings", encodings, {"json", "jsonschema"})
    counts = {summary.channels[id].topic: n for id, n in summary.statistics.channel_message_counts.items()}
    checks.equal("counts in the summary", counts, {topic: len(all) for topic, all in topics.items()})
    required = {text["title"]: set(text["required"]) for text in texts}
    lacking = [(t, v) for t, all in topics.items() for _, v in all if not required[TOPICS[t]] <= v.keys()]
    checks.equal("messages that lack what their schema requires", lacking[:3], [])


def sampled(checks, recording, clock):
    poses, joints = recording.topics["/pose"], recording.topics["/joints"]
    checks.equal("/pose off the 20 ms grid", off_the_grid([at for at, _ in poses]), [])
    checks.equal("/joints off the 20 ms grid", off_the_grid([at for at, _ in joints]), [])
    end = max(at for all in recording.topics.values() for at, _ in all)
    checks.ok("the last sample is at most 20 ms before the end", end - poses[-1][0] < PERIOD, f"{end} ns")
    checks.ok("the file reaches to the end", end >= clock * 1_000_000, f"{len(poses)} samples, {clock} ms")
    worst = max(
        max(abs(a - b) for a, b in zip(pose_of(p), model.forward(joints_of(j))))
        for (_, p), (_, j) in zip(poses, joints)
    )
    checks.ok("poses are those of the joints", worst < 1e-9, f"{worst:.1e} mm")


def answered(checks, recording, poses):
    frames = recording.topics["/frames"]
    for at, value in frames:
        split(bytes.fromhex(value["hex"]))
    checks.equal("frames that were not understood", [v for _, v in frames if not v["ok"]][:3], [])
    requests = [v for _, v in frames if v["direction"] == "request"]
    checks.equal("as many replies as requests", len(frames) - len(requests), len(requests))
    checks.ok("links have names", all(v["link"].startswith("tcp:") for _, v in frames), frames[0][1]["link"])
    replies = [(at, v) for at, v in frames if v["command"] == "GetPose" and v["direction"] == "reply"]
    got = [floats(split(bytes.fromhex(v["hex"]))[0][0][2]) for _, v in replies]
    checks.equal("GetPose replies are the ones that the host got", got, poses)
    decoded = [(v["params"]["x"], v["params"]["joint_angle"]) for _, v in replies]
    checks.ok("and are decoded", all(f32(x) == g[0] and len(j) == 4 for (x, j), g in zip(decoded, got)))

    samples = [(*pose_of(p), *joints_of(j)) for (_, p), (_, j) in zip(*(recording.topics[t] for t in ("/pose", "/joints")))]
    still, between = [], []
    for (at, _), reply in zip(replies, got):
        if at // PERIOD + 1 >= len(samples):
            continue
        before, after = samples[at // PERIOD], samples[at // PERIOD + 1]
        if before == after:
            still.append(tuple(map(f32, before)) == reply)
        else:
            slack = [max(1.0, abs(b - a)) for a, b in zip(before, after)]
            between.append(all(min(a, b) - s <= r <= max(a, b) + s for a, b, r, s in zip(before, after, reply, slack)))
    checks.ok("at rest a GetPose reply equals the sample, bit for bit", still and all(still), f"{len(still)} replies")
    checks.ok("on the way it lies between two", all(between), f"{len(between)} replies")


def happened(checks, recording, last, alarms):
    topics = recording.topics
    checks.equal("the queue's last index", topics["/queue"][-1][1]["current_index"], last + 1)
    first = next(at for at, v in topics["/queue"] if v["current_index"] == last)
    log = [(at, v["message"]) for at, v in topics["/events"]]
    checks.equal("it finished when the event says", [at for at, m in log if m == f"{last} PTPCmd finished"], [first])
    waited = [at for at, m in log if m in (f"{last - 1} WAITCmd started", f"{last - 1} WAITCmd finished")]
    checks.equal("a wait of 130 ms takes", waited[1] - waited[0], 130_000_000)
    on = [at for at, v in topics["/io"] if v["suction"]["commanded"]]
    checks.ok("suction is on from its command on", bool(on) and on[0] <= waited[0])
    standing = [a["code"] for a in topics["/alarms"][-1][1]["standing"]]
    want = [8 * byte + bit for byte in range(16) for bit in range(8) if alarms[byte] >> bit & 1]
    checks.equal("alarms at the end are those of GetAlarmsState", standing, want)
    checks.equal("at power-up the reset alarm stood", [a["code"] for a in topics["/alarms"][0][1]["standing"]], [0])
    raised = [at for at, m in log if m.startswith(f"alarm {want[0]:#04x}") and m.endswith("raised")]
    checks.ok("each was raised at its instant", raised and raised[0] in [at for at, _ in topics["/alarms"]])
    seconds = {at for at, _ in topics["/status"]}
    checks.ok("status at every second", all(k * SECOND in seconds for k in range(topics["/pose"][-1][0] // SECOND + 1)))


def killed(checks, magician, home, speed):
    print("a recording whose program was killed")
    path = os.path.join(home, "killed.mcap")
    sim = Sim(magician, os.path.join(home, "arm"), speed, "--record", path)
    link = Tcp(sim.tcp)
    drive(link)
    clock = link.time()
    # Four seconds of the arm's clock: samples one second old are in the file by then.
    while link.time() < clock + 4000:
        time.sleep(0.01)
    sim.end(signal.SIGKILL)
    link.close()

    records, broke_off = [], None
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file).records:
                records.append(record)
        except (McapError, struct.error) as error:
            broke_off = error
    checks.ok("the reader comes to its end", broke_off is not None, repr(broke_off))
    checks.equal("schemas", {r.name for r in records if isinstance(r, Schema)}, set(TOPICS.values()))
    epoch = next(int(r.metadata["epoch_ns"]) for r in records if isinstance(r, Metadata))
    topics = {}
    channels = {r.id: r.topic for r in records if hasattr(r, "topic")}
    for record in records:
        if isinstance(record, Message):
            topics.setdefault(channels[record.channel_id], []).append(record.log_time - epoch)
    checks.equal("samples off the 20 ms grid", off_the_grid(topics["/pose"]), [])
    reached = topics["/pose"][-1] / 1e6
    checks.ok("all is there up to a second before the end", reached >= clock, f"{reached} ms, {clock} ms when asked")
    checks.ok("frames are there", len(topics["/frames"]) > 20, len(topics["/frames"]))


def errors(checks, magician, home):
    print("a file that cannot be written")
    command = [magician, "sim", "--tcp", "127.0.0.1:0", "--record", os.path.join(home, "no", "such.mcap")]
    refused = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT)
    checks.equal("no such directory: exit status and stdout", (refused.returncode, refused.stdout), (3, ""))
    checks.ok("with a word about it", "such.mcap" in refused.stderr, refused.stderr.strip())

    path = os.path.join(home, "arm")
    sim = Sim(magician, path, "20", "--record", "/dev/full", quiet=True)
    said = sim.says(rb".*recording ends here.*")[0]
    checks.ok("a full disk is told at once", sim.process.poll() is None, said.decode().strip())
    link = Tcp(sim.tcp)
    checks.equal("and the arm goes on", len(link.pose()), 8)
    link.close()
    ended, _ = sim.end()
    checks.equal("exit status", (ended, sim.process.returncode), (True, 4))
    checks.ok("which says why", b"incomplete" in sim.said[-1], sim.said[-1].decode().strip())


def main():
    magician = sys.argv[5]
    checks = Checks()
    with tempfile.TemporaryDirectory(prefix="magician-record-") as home:
        for speed in ("20", "max"):
            checks.section(finished, magician, home, speed)
        checks.section(killed, magician, home, "20")
        checks.section(drawn, magician, home)
        checks.section(errors, magician, home)
    checks.finish()


if __name__ == "__main__":
    main()
