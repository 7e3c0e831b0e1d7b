//! Frames, the command table and alarms of the Dobot Magician protocol: bytes and values.
