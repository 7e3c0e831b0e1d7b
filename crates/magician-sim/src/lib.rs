//! A virtual Dobot Magician controller: bytes in, bytes out, time passes when you say so.
