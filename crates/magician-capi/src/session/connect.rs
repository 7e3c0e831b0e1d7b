//! `ConnectDobot` of all families.
//!
//! The port is opened and probed for an arm. As in the vendor's library, connecting succeeds even
//! if nothing answers. If the caller wants the name of the firmware and a serial port is silent, a
//! probe in text follows (`text_probe`), because the controller may run a firmware for 3-D
//! printing.

use std::ffi::c_int;
use std::sync::Arc;
use std::time::Duration;

use magician::commands::{DeviceTime, DeviceVersion};
use magician::protocol::BAUD_RATE;
use magician::{ErrorKind, Options, Target, blocking};

use super::place::variable_of;
use super::pool::Lease;
use super::registry::{Slot, lock};
use super::text_probe::{self, Firmware};
use super::{Registry, Session};
use crate::code::{Code, ConnectCode, Fault};
use crate::notice;
use crate::pointer::{Buffer, Out, Text};
use crate::structure::ConnectInfo;

/// Name of the function in messages.
const NAME: &str = "ConnectDobot";
/// Timeout of a virtual arm. It answers at once, except on a computer under load.
const VIRTUAL_TIMEOUT: Duration = Duration::from_secs(10);

/// Result of probing a port.
enum ProbeResult {
    /// An arm answered.
    Arm(Session),
    /// No known device answered. Connected nevertheless, with an explanation.
    Silence(Session, String),
    /// Another firmware answered in text.
    Firmware(Firmware),
}

/// Successful connection, with the id assigned to it.
struct Connection {
    id: c_int,
    /// Name and version in the vendor's terms.
    firmware: Firmware,
    /// Arm, if one answered.
    arm: Option<Arc<Session>>,
    /// `DevType` of the vendor's `ConnectInfo`.
    kind: i32,
}

/// `ConnectDobot` of each family (docs/guide/VENDOR-LIBRARY.md).
impl Registry {
    /// `ConnectDobot` of `v1`: closes an earlier connection first, so connecting to the same port
    /// reopens it.
    pub fn connect_v1(&self, port: Text, baud: u32, firmware: Buffer, version: Buffer) -> c_int {
        // In a forked child the claim fails. Do not take the lock then: a thread of the parent may
        // have held it during the fork, and it stays locked.
        let claim = self.claim().ok();
        let _turn = claim.as_ref().map(|_| lock(&self.turn));
        self.remove(0);
        let connect = || self.connect(port, baud, Some(0), !firmware.is_null());
        self.report(port, connect, |outcome| {
            if let Some(connection) = outcome {
                put_text(firmware, connection.firmware.name);
                put_text(version, &connection.firmware.version);
            }
        })
    }

    /// `ConnectDobot` of `v2`: the id is the smallest free one, or -1 on failure.
    pub fn connect_v2(
        &self,
        port: Text,
        baud: u32,
        firmware: Buffer,
        version: Buffer,
        id: Out<i32>,
    ) -> c_int {
        let connect = || self.connect(port, baud, None, !firmware.is_null());
        self.report(port, connect, |outcome| match outcome {
            Some(connection) => {
                put_text(firmware, connection.firmware.name);
                put_text(version, &connection.firmware.version);
                id.put(connection.id);
            }
            None => id.put(-1),
        })
    }

    /// `ConnectDobot` of `v3`: the arm is a master without slaves.
    pub fn connect_v3(&self, port: Text, baud: u32, info: Out<ConnectInfo>) -> c_int {
        let connect = || self.connect(port, baud, None, true);
        self.report(port, connect, |outcome| {
            if let Some(connection) = outcome {
                info.put(to_connect_info(connection));
            }
        })
    }

    fn connect(
        &self,
        port: Text,
        baud: u32,
        id: Option<c_int>,
        probes_text: bool,
    ) -> Result<Connection, (ConnectCode, Fault)> {
        let occupied = |fault| (ConnectCode::Occupied, fault);
        let _claim = self.claim().map_err(occupied)?;
        let name = name_of(port);
        let target = self.resolve(&name)?;
        if baud != BAUD_RATE && is_serial(&target) {
            tracing::warn!(
                "{NAME}: {target} is opened at {BAUD_RATE} baud, the arm's speed, not at {baud}"
            );
        }
        let probed = self.open(&target, probes_text).map_err(|error| {
            let redirect_hint = match name.trim() {
                "" => String::new(),
                name => format!(" ({}=PORT sends this name elsewhere)", variable_of(name)),
            };
            occupied(Fault::new(Code::Timeout, format!("{error}{redirect_hint}")))
        })?;
        Ok(self.store(probed, &target, id))
    }

    /// Connects, passes the connection, or `None` on failure, to `write_results`, and returns the
    /// code for C.
    fn report(
        &self,
        port: Text,
        connect: impl FnOnce() -> Result<Connection, (ConnectCode, Fault)>,
        write_results: impl FnOnce(Option<&Connection>),
    ) -> c_int {
        let arguments = || format!("\"{}\"", name_of(port));
        notice::host(NAME, arguments, || match connect() {
            Ok(connection) => {
                write_results(Some(&connection));
                notice::succeeded(NAME);
                ConnectCode::NoError as c_int
            }
            Err((code, fault)) => {
                write_results(None);
                match self.check_process() {
                    Ok(()) => notice::fault(NAME, &fault),
                    Err(_) => notice::remember_unlogged(NAME, &fault),
                };
                code as c_int
            }
        })
    }

    fn resolve(&self, name: &str) -> Result<Target, (ConnectCode, Fault)> {
        match self.environment.resolve(name) {
            Some(Ok(target)) => Ok(target),
            Some(Err(error)) => Err((ConnectCode::Occupied, error.into())),
            None => {
                let message = "no port was given and no serial port looks like an arm's: is it \
                    plugged in and switched on? MAGICIAN_PORT=PORT gives one, MAGICIAN_PORT=sim a \
                virtual arm";
                Err((ConnectCode::NotFound, Fault::new(Code::Timeout, message)))
            }
        }
    }

    /// Stores the result of probing under an id.
    fn store(&self, probed: ProbeResult, target: &Target, id: Option<c_int>) -> Connection {
        let arm = |session: Session, answers: bool| {
            let arm = Arc::new(session);
            let name = match target {
                Target::Udp { .. } => "DobotWifi",
                _ => "DobotSerial",
            };
            Connection {
                id: self.assign_id(id, Slot::Arm(Arc::clone(&arm))),
                firmware: Firmware {
                    name,
                    version: "0.0.0".to_owned(),
                },
                arm: Some(arm).filter(|_| answers),
                kind: DEV_TYPE_MAGICIAN,
            }
        };
        match probed {
            ProbeResult::Arm(session) => arm(session, true),
            ProbeResult::Silence(session, message) => {
                notice::warn(NAME, &message);
                arm(session, false)
            }
            ProbeResult::Firmware(firmware) => {
                let message = format!(
                    "{target} runs {} {}, a firmware for 3-D printing that does not speak the arm's protocol, and was \
                     closed again",
                    firmware.name, firmware.version
                );
                notice::warn(NAME, &message);
                Connection {
                    id: self.assign_id(id, Slot::Other(message)),
                    firmware,
                    arm: None,
                    kind: DEV_TYPE_IDLE,
                }
            }
        }
    }

    /// Opens a port and probes it.
    fn open(&self, target: &Target, probes_text: bool) -> magician::Result<ProbeResult> {
        // If the file of known arms is unreadable, fail: without it the arm's fence would be
        // missing.
        let variable = |name: &str| (self.environment.variable)(name).map(Into::into);
        let known = match magician::arms::file_by(variable) {
            Some(file) => magician::arms::load_from(&file)?,
            None => Vec::new(),
        };
        let options = self.options().for_arm(magician::arms::at(&known, target));
        if let Target::Sim(speed) = target {
            return self.open_virtual(self.pool.take(*speed), options);
        }
        let timeout = if is_serial(target) {
            self.timeouts.serial
        } else {
            self.timeouts.network
        };
        let silence = match blocking::Arm::connect_with(target, options.clone().timeout(timeout)) {
            Ok(arm) => {
                start_queue(&arm);
                return Ok(ProbeResult::Arm(self.session(arm, None, true)));
            }
            Err(error) if is_silence(error.kind()) => error,
            Err(error) => return Err(error),
        };
        if probes_text
            && is_serial(target)
            && let Some(firmware) = text_probe::probe(target, self.timeouts.text)
        {
            return Ok(ProbeResult::Firmware(firmware));
        }
        let arm = blocking::Arm::connect_with(target, options.probe(false))?;
        let message = format!("connected, as the vendor's library would be, but {silence}");
        Ok(ProbeResult::Silence(
            self.session(arm, None, false),
            message,
        ))
    }

    fn open_virtual(&self, lease: Lease, options: Options) -> magician::Result<ProbeResult> {
        let arm = blocking::Arm::simulated(lease.arm.clone(), options.timeout(VIRTUAL_TIMEOUT))?;
        start_queue(&arm);
        Ok(ProbeResult::Arm(self.session(arm, Some(lease), true)))
    }

    fn session(&self, arm: blocking::Arm, lease: Option<Lease>, queue_was_read: bool) -> Session {
        let standing = self.timeouts.standing;
        Session::new(
            arm,
            Arc::clone(self.allowed()),
            lease,
            queue_was_read,
            standing,
        )
    }
}

/// Starts the queue if it is empty. Many programs expect a running queue, because they were written
/// on an arm where another program had started it.
fn start_queue(arm: &blocking::Arm) {
    if let Err(error) = arm.queue().start_if_empty() {
        notice::warn(NAME, &format!("the queue was not started: {error}"));
    }
}

fn name_of(port: Text) -> String {
    String::from_utf8_lossy(&port.bytes()).into_owned()
}

/// True for a port at which a firmware may answer in text.
fn is_serial(target: &Target) -> bool {
    matches!(
        target,
        Target::Serial(_) | Target::Usb { .. } | Target::Arm(_)
    )
}

/// True if the port is open but no arm answered.
fn is_silence(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::Timeout | ErrorKind::Unexpected)
}

/// Writes a short text with a final NUL. The caller does not pass the size of its buffer; programs
/// provide at least 64 bytes, far more than is written.
fn put_text(buffer: Buffer, text: &str) {
    buffer.put(text.as_bytes(), text.len() + 1);
}

/// `DevType` if another firmware than the arm's is connected.
const DEV_TYPE_IDLE: i32 = 0;
/// `DevType` of a Magician.
const DEV_TYPE_MAGICIAN: i32 = 2;

/// Builds the `ConnectInfo` of `v3`, with the arm as the master.
fn to_connect_info(connection: &Connection) -> ConnectInfo {
    let (name, version, run_time) = match &connection.arm {
        Some(arm) => ("Dobot", version_of(arm), run_time_of(arm)),
        None => (
            connection.firmware.name,
            connection.firmware.version.clone(),
            0.0,
        ),
    };
    let mut info = [0; 336];
    let mut write = |at: usize, bytes: &[u8]| {
        if let Some(field) = info.get_mut(at..at + bytes.len()) {
            field.copy_from_slice(bytes);
        }
    };
    write(0, &connection.id.to_le_bytes());
    write(4, &connection.kind.to_le_bytes());
    write(8, truncated(name));
    write(58, truncated(&version));
    write(108, &f32::to_le_bytes(run_time));
    ConnectInfo(info)
}

/// Truncates a text to the 50 bytes of its field, with a NUL.
fn truncated(text: &str) -> &[u8] {
    let bytes = text.as_bytes();
    bytes.get(..49).unwrap_or(bytes)
}

fn version_of(arm: &Session) -> String {
    let version = arm.get::<DeviceVersion>().map(|version| {
        format!(
            "{}.{}.{}",
            version.major_version, version.minor_version, version.revision
        )
    });
    version.unwrap_or_else(|_| "0.0.0".to_owned())
}

/// Time since the arm was switched on, s. 0 if it cannot be read.
fn run_time_of(arm: &Session) -> f32 {
    let time = arm.get::<DeviceTime>();
    time.map_or(0.0, |time| time.g_systick as f32 / 1000.0)
}
