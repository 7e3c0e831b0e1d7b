//! Stand-in for a C program: passes pointers and buffers to a session, and calls its functions.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int};
use std::time::Duration;

use magician::commands;
use magician_capi::pointer::{Buffer, In, Out, Text};
use magician_capi::session::{Environment, Registry, Session, Timeouts, last_error};
use magician_capi::structure::{ConnectInfo, HOMECmd, Pose};
use magician_capi::{Family, Outcome, call};

/// Timeout of every wait, far beyond what anything here takes.
pub(crate) const DEADLINE: Duration = Duration::from_secs(120);

/// Initial byte of memory for results; a result that still has it was not written.
pub(crate) const UNTOUCHED: u8 = 0x5A;

/// An environment without variables, ports and networks.
pub(crate) fn isolated_environment() -> Environment {
    Environment {
        variable: |_| None,
        ports: Vec::new,
        network: Vec::new,
    }
}

/// Timeouts so long that they never expire in a test.
pub(crate) fn long_timeouts() -> Timeouts {
    Timeouts {
        serial: DEADLINE,
        network: DEADLINE,
        text: DEADLINE,
        standing: DEADLINE,
    }
}

pub(crate) fn registry() -> Registry {
    Registry::new(isolated_environment(), long_timeouts())
}

/// Results of `ConnectDobot` of `v1` and `v2`.
#[derive(Debug, PartialEq)]
pub(crate) struct ConnectResult {
    pub(crate) code: c_int,
    pub(crate) firmware: String,
    pub(crate) version: String,
    pub(crate) id: c_int,
}

/// Text buffer of the size that wrappers use.
type TextBuffer = [c_char; 100];

fn buffer(text: &mut TextBuffer) -> Buffer {
    // SAFETY: the callers keep the text buffer alive for the whole call.
    unsafe { Buffer::new(text.as_mut_ptr()) }
}

fn string(buffer: &TextBuffer) -> String {
    let bytes: Vec<u8> = buffer.iter().map(|byte| byte.to_le_bytes()[0]).collect();
    let text = CStr::from_bytes_until_nul(&bytes).unwrap();
    text.to_str().unwrap().to_owned()
}

/// Runs `act` with a C string.
pub(crate) fn with_text<T>(text: &str, act: impl FnOnce(Text) -> T) -> T {
    let text = CString::new(text).unwrap();
    // SAFETY: `text` outlives the call.
    act(unsafe { Text::new(text.as_ptr()) })
}

pub(crate) fn no_text() -> Text {
    // SAFETY: null is allowed.
    unsafe { Text::new(std::ptr::null()) }
}

pub(crate) fn no_buffer() -> Buffer {
    // SAFETY: null is allowed.
    unsafe { Buffer::new(std::ptr::null_mut()) }
}

pub(crate) fn connect_v1(registry: &Registry, port: &str) -> ConnectResult {
    let (mut firmware, mut version) = ([0; 100], [0; 100]);
    let (firmware_at, version_at) = (buffer(&mut firmware), buffer(&mut version));
    let code = with_text(port, |port| {
        registry.connect_v1(port, 115_200, firmware_at, version_at)
    });
    ConnectResult {
        code,
        firmware: string(&firmware),
        version: string(&version),
        id: 0,
    }
}

/// Connects without buffers for text.
pub(crate) fn connect_without_buffers(registry: &Registry, port: &str) -> c_int {
    with_text(port, |port| {
        registry.connect_v1(port, 115_200, no_buffer(), no_buffer())
    })
}

pub(crate) fn connect_v2(registry: &Registry, port: &str) -> ConnectResult {
    let (mut firmware, mut version, mut id) = ([0; 100], [0; 100], 77);
    let (firmware_at, version_at) = (buffer(&mut firmware), buffer(&mut version));
    // SAFETY: `id` outlives the call.
    let id_at = unsafe { Out::new(&raw mut id) };
    let code = with_text(port, |port| {
        registry.connect_v2(port, 115_200, firmware_at, version_at, id_at)
    });
    ConnectResult {
        code,
        firmware: string(&firmware),
        version: string(&version),
        id,
    }
}

pub(crate) fn connect_v3(registry: &Registry, port: &str) -> (c_int, [u8; 336]) {
    let mut info = ConnectInfo([UNTOUCHED; 336]);
    // SAFETY: `info` outlives the call.
    let at = unsafe { Out::new(&raw mut info) };
    let code = with_text(port, |port| registry.connect_v3(port, 115_200, at));
    (code, info.0)
}

/// Calls `SearchDobot` with a buffer of `size` bytes. Returns the number of names and the list.
pub(crate) fn search(registry: &Registry, size: u32) -> (c_int, String) {
    let mut list = [0x7F; 100];
    let count = registry.search(buffer(&mut list), size);
    assert!(list[size as usize..].iter().all(|byte| *byte == 0x7F));
    (count, string(&list))
}

/// Runs the body of a function as the exported function does. Returns the code for C.
pub(crate) fn run(
    registry: &Registry,
    name: &'static str,
    id: c_int,
    body: impl FnOnce(&Session) -> Outcome,
) -> c_int {
    registry.run(Family::V2, name, id, body)
}

/// `GetPose`: return code, and the bytes of the result afterwards.
pub(crate) fn pose_of(registry: &Registry, id: c_int) -> (c_int, [u8; 32]) {
    let mut pose = Pose([UNTOUCHED; 32]);
    // SAFETY: `pose` outlives the call.
    let at = unsafe { Out::new(&raw mut pose) };
    let code = run(registry, "GetPose", id, |arm| call::get(arm, at));
    (code, pose.0)
}

pub(crate) fn pose(registry: &Registry) -> (c_int, [u8; 32]) {
    pose_of(registry, 0)
}

/// `SetHOMECmd`, which is always queued: return code and index. The index is 0 if none was written.
pub(crate) fn home(registry: &Registry) -> (c_int, u64) {
    let (command, mut index) = (HOMECmd([0; 4]), 0);
    // SAFETY: `command` and `index` outlive the call.
    let (command, at) = unsafe { (In::new(&raw const command), Out::new(&raw mut index)) };
    let code = run(registry, "SetHOMECmd", 0, |arm| {
        call::queue_in(arm, command, call::Queued::Always, at)
    });
    (code, index)
}

pub(crate) fn clear(registry: &Registry) -> c_int {
    run(registry, "SetQueuedCmdClear", 0, |arm| {
        call::set(arm, &commands::QueuedCmdClear {})
    })
}

/// Sentence of this thread's last fault.
pub(crate) fn fault() -> String {
    let mut text = [0; 1000];
    // SAFETY: `text` outlives the call.
    let at = unsafe { Buffer::new(text.as_mut_ptr()) };
    let length = last_error(at, 1000);
    let bytes: Vec<u8> = text
        .iter()
        .map(|byte: &c_char| byte.to_le_bytes()[0])
        .collect();
    let text = CStr::from_bytes_until_nul(&bytes).unwrap();
    assert_eq!(text.to_bytes().len(), usize::try_from(length).unwrap());
    text.to_str().unwrap().to_owned()
}

/// Calls `MagicianLastError` with a buffer of `size` bytes. Returns the length and the text.
pub(crate) fn fault_truncated_to(size: u32) -> (c_int, String) {
    let mut text = [0; 100];
    let length = last_error(buffer(&mut text), size);
    (length, string(&text))
}
