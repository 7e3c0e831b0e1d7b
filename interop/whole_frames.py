"""Serial ports for pydobot that wait for a whole frame, for machines under load.

pydobot reads once, 100 ms after its request. If no answer has arrived by then, it remains one
answer behind for ever. On a busy machine that is not a fault of the arm. Here each read waits for a
whole frame; the library itself is unmodified.
"""

import time

try:
    import serial
except ImportError:
    # Our own replacement of the library needs no patch.
    serial = None

# Timeout of a read, s. Some of pydobot's commands are never answered, because their checksum is
# wrong.
READ_TIMEOUT = 5


def read_all(port):
    """Reads until there is a whole frame."""
    data, end = b"", time.monotonic() + READ_TIMEOUT
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
