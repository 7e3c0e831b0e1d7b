use std::ffi::c_int;
use std::sync::{Arc, PoisonError};

use magician::blocking;

use super::{ARMS, Session};
use crate::code::Connected;
use crate::pointer::{Buffer, Out, Text};
use crate::structure::ConnectInfo;

fn connect(port: Text, id: c_int) -> Connected {
    let name = String::from_utf8_lossy(&port.bytes()).into_owned();
    let Ok(arm) = name
        .parse()
        .and_then(|target| blocking::Arm::connect(&target))
    else {
        return Connected::Occupied;
    };
    let mut arms = ARMS.write().unwrap_or_else(PoisonError::into_inner);
    arms.insert(id, Arc::new(Session { arm }));
    Connected::NoError
}

/// `ConnectDobot` of `v1`.
pub fn connect_v1(port: Text, _baud: u32, firmware: Buffer, version: Buffer) -> c_int {
    firmware.put(b"DobotSerial", 100);
    version.put(b"0.0.0", 100);
    connect(port, 0) as c_int
}

/// `ConnectDobot` of `v2`.
pub fn connect_v2(
    port: Text,
    _baud: u32,
    firmware: Buffer,
    version: Buffer,
    id: Out<i32>,
) -> c_int {
    firmware.put(b"DobotSerial", 100);
    version.put(b"0.0.0", 100);
    id.put(0);
    connect(port, 0) as c_int
}

/// `ConnectDobot` of `v3`.
pub fn connect_v3(port: Text, _baud: u32, _info: Out<ConnectInfo>) -> c_int {
    connect(port, 0) as c_int
}
