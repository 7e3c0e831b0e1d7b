"""Serial ports at which a library that looks once for its answer finds it, on a machine that is slow to answer.

pydobot looks 100 ms after it has asked, whatever there is, and for good is one answer behind when there is nothing. On a busy
machine that says nothing about the arm. Here a look lasts until there is a whole frame; the library is as it is.
"""

import time

try:
    import serial
except ImportError:
    # Ours in its place needs none.
    serial = None

# Some of pydobot's commands get no answer, for their checksum is wrong: they are waited for as long, s.
LONGEST = 5


def read_all(port):
    """What is there, from a whole frame on."""
    data, end = b"", time.monotonic() + LONGEST
    while len(data) < 3 or len(data) < data[2] + 4:
        if time.monotonic() > end:
            break
        if port.in_waiting:
            data += port.read(port.in_waiting)
        else:
            time.sleep(0.001)
    return data


if serial:
    serial.Serial.read_all = read_all
