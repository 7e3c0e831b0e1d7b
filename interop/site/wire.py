"""Times at which stops reached the lines of arms, read from recordings: wire.py BEGAN FILE...

Prints, as JSON, the milliseconds from BEGAN (Unix seconds) to the first SetQueuedCmdForceStopExec
of each file after it; null if there is no such frame. Needs PyPI's `mcap`.
"""

import json
import sys

from mcap.reader import make_reader


def stopped(path, began):
    with open(path, "rb") as file:
        frames = make_reader(file).iter_messages(topics=["/frames"], start_time=int(began * 1e9))
        for _, _, message in frames:
            frame = json.loads(message.data)
            if frame["direction"] == "request" and frame.get("command") == "SetQueuedCmdForceStopExec":
                return (message.log_time / 1e9 - began) * 1e3
    return None


if __name__ == "__main__":
    print(json.dumps([stopped(path, float(sys.argv[1])) for path in sys.argv[2:]]))
