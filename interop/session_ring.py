"""Recordings of a station, counted by three readers: session_ring.py PTY UDP TCP SPEED MAGICIAN

A station has an arm on a line of its own. Its ring buffer of the last minutes, its recordings, and
the file written on an alarm are read by PyPI's `mcap`, by the MCAP reader of PyPI's `rosbags`, and
by `magician replay`. All counts must agree. Then the station is killed.

`rosbags` reads bags of ROS 2 only. It refuses a file whose profile is not `ros2`, and schemas in
other languages. With these checks disabled, its reader finds chunks, topics and counts, and returns
every message as bytes. It cannot decode them, as they are JSON.
"""

import collections
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat
from rosbags.rosbag2 import storage_mcap
from rosbags.rosbag2.errors import ReaderError

from checks import TIMEOUT, Checks
from station import Client, Station, now


class AnyProfile(storage_mcap.McapReader):
    """The reader of `rosbags`, modified to accept JSON."""

    def open(self):
        plain, first = storage_mcap.read_string, [True]

        def profile(bio):
            text = plain(bio)
            return "ros2" if first and first.pop() else text

        definitions = storage_mcap.get_msgdef
        storage_mcap.read_string = profile
        storage_mcap.get_msgdef = lambda schema: MessageDefinition(MessageDefinitionFormat.NONE, "")
        try:
            super().open()
        finally:
            storage_mcap.read_string, storage_mcap.get_msgdef = plain, definitions


def by_mcap(path):
    """Returns counts by topic: of the messages, and those in the summary."""
    counts = collections.Counter()
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        directions = collections.Counter()
        for _, channel, message in reader.iter_messages():
            counts[channel.topic] += 1
            if channel.topic == "/frames":
                directions[json.loads(message.data)["direction"]] += 1
        told = {summary.channels[id].topic: n for id, n in summary.statistics.channel_message_counts.items()}
    return dict(counts), told, directions, len(summary.chunk_indexes)


def by_rosbags(path):
    reader = AnyProfile(pathlib.Path(path))
    reader.open()
    try:
        topics = {connection.id: connection.topic for connection in reader.connections}
        told = {topics[id]: n for id, n in reader.statistics.channel_message_counts.items()}
        counts = collections.Counter(connection.topic for connection, _, _ in reader.messages(list(reader.connections)))
        return dict(counts), told, len(reader.chunks)
    finally:
        reader.close()


def by_replay(magician, path):
    """Returns the number of explained frames, and of requests sent to a virtual arm."""
    replay = lambda *more: subprocess.run(
        [magician, "replay", path, "--json", *more], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT
    )
    explained = [json.loads(line) for line in replay("--to", "decode").stdout.splitlines()]
    played = json.loads(replay().stdout.splitlines()[-1])
    return collections.Counter(frame["direction"] for frame in explained), played["requests"]


def counted(checks, magician, path, what):
    print(f"  {what}")
    counts, told, directions, chunks = by_mcap(path)
    topics = {"/pose", "/joints", "/tf", "/scene", "/queue", "/alarms", "/frames"}
    checks.ok("topics", topics <= counts.keys(), counts)
    checks.equal("mcap: its messages are those of the summary", counts, told)
    try:
        plain = storage_mcap.McapReader(pathlib.Path(path))
        plain.open()
        checks.ok("rosbags refuses what is no bag of ROS 2", False)
    except ReaderError as error:
        checks.ok("rosbags refuses what is no bag of ROS 2", "ros2" in str(error), error)
    counts_too, told_too, chunks_too = by_rosbags(path)
    checks.equal("rosbags: its counts are those of mcap", (counts_too, told_too, chunks_too), (counts, told, chunks))
    explained, requests = by_replay(magician, path)
    checks.equal("replay explains every frame", explained, directions)
    checks.equal("and sends every request", requests, directions["request"])
    return counts


def waited(client, event):
    """Waits for an event and returns its parameters."""
    until = now() + TIMEOUT
    while now() < until:
        message = client.read()
        if message and message.get("method") == "arm.event" and message["params"]["event"] == event:
            return message["params"]
    raise AssertionError(f"no {event}")


def agreed(checks, magician, station, folder):
    print("what a station keeps, records, and writes when an alarm comes")
    client = Client(station.port, "ring")
    client.call("lease.take")
    for y in (40, -40):
        client.call("arm.move", to=[220, y, 50, 0])
    name = client.call("record.start", rate=50)["name"]
    client.call("arm.move", to=[240, 0, 30, 0])
    over = client.call("record.stop")
    path = os.path.join(folder, name)
    checks.equal("record.stop says how long the file is", over["bytes"], os.path.getsize(path))
    counted(checks, magician, path, "a recording")
    saved = client.call("record.save_last", seconds=600)["name"]
    counts = counted(checks, magician, os.path.join(folder, saved), "the last minutes")
    checks.ok("nobody has watched, and all is there", counts["/pose"] > 50 and counts["/frames"] > 400, counts)

    client.call("arm.subscribe", rate=1)
    client.call("arm.enqueue", command="PTPCmd", fields={"ptp_mode": 1, "x": 400, "y": 0, "z": 0, "r": 0})
    told = waited(client, "recording-saved")
    path = os.path.join(folder, told["name"])
    checks.equal("an alarm has a file written, and says which", told["bytes"], os.path.getsize(path))
    counts = counted(checks, magician, path, "what led to an alarm")
    with open(path, "rb") as file:
        words = [json.loads(m.data)["message"] for _, _, m in make_reader(file).iter_messages(topics=["/events"])]
    checks.ok("the alarm is in it", any(word.startswith("alarm-raised") for word in words), words)


def killed(checks, magician, station, folder):
    print("a station that is killed")
    client = Client(station.port, "kill")
    client.call("lease.take")
    client.call("arm.clear_alarms")
    name = client.call("record.start", rate=50)["name"]
    for y in (40, -40, 40):
        client.call("arm.move", to=[220, y, 50, 0])
    at = time.time()
    station.process.kill()
    station.process.wait()
    path = os.path.join(folder, name)
    topics, counts, last = {}, collections.Counter(), 0
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message):
                    counts[topics[record.channel_id]] += 1
                    last = max(last, record.log_time / 1e9)
        except (McapError, struct.error):
            pass
    checks.ok("all is there up to the last second or so", 0 <= at - last < 1.5, f"{at - last:.2f} s before it was killed")
    explained, requests = by_replay(magician, path)
    checks.equal("replay reads as far as mcap", sum(explained.values()), counts["/frames"])
    checks.ok("and sends what was sent", requests > 100, requests)


def main():
    magician = sys.argv[5]
    checks = Checks()
    with tempfile.TemporaryDirectory(prefix="magician-ring-") as home:
        station = Station(magician, home, "--no-studio")
        folder = os.path.join(home, "magician", "recordings")
        try:
            checks.section(agreed, magician, station, folder)
            checks.section(killed, magician, station, folder)
        finally:
            station.end()
    checks.finish()


if __name__ == "__main__":
    main()
