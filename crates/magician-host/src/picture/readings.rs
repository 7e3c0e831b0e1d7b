//! Last readings of an arm, and the events that follow from them.

use std::collections::VecDeque;

use magician_protocol::commands::{
    AlarmsState, DeviceSn, IoAdc, IoDi, IoDo, Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use magician_protocol::{AlarmSet, Frame, Layout, QueuedCmdIndex, Readable};

use crate::connection::Micros;

/// Events that are kept for a caller that does not poll: more than one answer makes.
const MOST_EVENTS: usize = 512;

/// A pin: its EIO address, 1 to 20, and the function that it was given (`build::multiplex`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Pin {
    /// A digital input.
    Input(u8),
    /// A digital output.
    Output(u8),
    /// An analog input.
    Analog(u8),
}

impl Pin {
    /// Its EIO address.
    #[must_use]
    pub const fn address(self) -> u8 {
        match self {
            Self::Input(address) | Self::Output(address) | Self::Analog(address) => address,
        }
    }
}

/// Level of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// The pin.
    pub pin: Pin,
    /// 0 or 1; counts (4095 at 3.3 V) for an analog one.
    pub value: u16,
}

/// Change that an answer shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureEvent {
    /// An alarm stands that did not at the last reading.
    AlarmRaised(u8),
    /// An alarm stands no more.
    AlarmCleared(u8),
    /// Queued commands have finished, of any program.
    Finished {
        /// Index of the first.
        first: QueuedCmdIndex,
        /// Index of the last.
        last: QueuedCmdIndex,
    },
}

/// Readings of one moment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StateReadings {
    /// Pose, and joints.
    pub pose: Pose,
    /// When the pose was answered, us.
    pub at: Micros,
    /// Queued command that finished last.
    pub current: QueuedCmdIndex,
    /// Free places in the queue.
    pub left_space: u32,
    /// Alarms that stand.
    pub alarms: AlarmSet,
    /// Levels of all pins that were read so far.
    pub pins: Vec<Level>,
}

/// What was read last.
#[derive(Clone, Debug, Default)]
pub(super) struct LastReadings {
    pose: Option<(Pose, Micros)>,
    current: Option<u64>,
    /// Index up to which the end of commands was told.
    finished: Option<u64>,
    left_space: Option<u32>,
    alarms: Option<AlarmSet>,
    /// When the alarms were read; `None` as soon as they may have changed by a command of this connection.
    alarms_at: Option<Micros>,
    pins: Vec<Level>,
    serial: Option<String>,
    events: VecDeque<PictureEvent>,
}

impl LastReadings {
    /// The answer to a get.
    pub(super) fn read(&mut self, now: Micros, reply: &Frame<'_>) {
        match reply.id() {
            id if id == <DeviceSn as Readable>::ROW.id => {
                self.serial = serial_number(reply.params());
            }
            id if id == <Pose as Readable>::ROW.id => {
                if let Ok(pose) = reply.read() {
                    self.pose = Some((pose, now));
                }
            }
            id if id == <QueuedCmdCurrentIndex as Readable>::ROW.id => {
                if let Ok(read) = reply.read::<QueuedCmdCurrentIndex>() {
                    self.read_current(read.queued_cmd_current_index);
                }
            }
            id if id == <QueuedCmdLeftSpace as Readable>::ROW.id => {
                if let Ok(read) = reply.read::<QueuedCmdLeftSpace>() {
                    self.left_space = Some(read.left_space);
                }
            }
            id if id == <AlarmsState as Readable>::ROW.id => {
                if let Ok(read) = reply.read::<AlarmsState>() {
                    self.read_alarms(now, read.alarms_state);
                }
            }
            _ => self.read_pin(reply),
        }
    }

    pub(super) fn poll_event(&mut self) -> Option<PictureEvent> {
        self.events.pop_front()
    }

    fn happens(&mut self, event: PictureEvent) {
        if self.events.len() >= MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    /// The arm was given a serial number.
    pub(super) fn named(&mut self, request: &Frame<'_>) {
        self.serial = serial_number(request.params());
    }

    fn read_current(&mut self, current: u64) {
        self.current = Some(current);
        match self.finished {
            Some(before) if before < current => {
                self.finished = Some(current);
                // Arms begin with 2 (model section 14): there is no command 1 to have finished.
                let first = before.saturating_add(1).max(current.min(2));
                self.happens(PictureEvent::Finished {
                    first: QueuedCmdIndex(first),
                    last: QueuedCmdIndex(current),
                });
            }
            // One that goes back is of a reset, which is told by itself, or was held up on its way.
            Some(_) => {}
            None => self.finished = Some(current),
        }
    }

    fn read_alarms(&mut self, now: Micros, alarms: AlarmSet) {
        self.alarms_at = Some(now);
        if let Some(before) = self.alarms.replace(alarms) {
            for code in alarms.codes().filter(|code| !before.contains(*code)) {
                self.happens(PictureEvent::AlarmRaised(code));
            }
            for code in before.codes().filter(|code| !alarms.contains(*code)) {
                self.happens(PictureEvent::AlarmCleared(code));
            }
        }
    }

    fn read_pin(&mut self, reply: &Frame<'_>) {
        let level = match reply.id() {
            id if id == <IoDi as Readable>::ROW.id => { reply.read().ok() }
                .map(|read: IoDi| (Pin::Input(read.address), read.level.is_on().into())),
            id if id == <IoDo as Readable>::ROW.id => { reply.read().ok() }
                .map(|read: IoDo| (Pin::Output(read.address), read.level.is_on().into())),
            id if id == <IoAdc as Readable>::ROW.id => {
                { reply.read().ok() }.map(|read: IoAdc| (Pin::Analog(read.address), read.value))
            }
            _ => None,
        };
        let Some((pin, value)) = level else {
            return;
        };
        match self.pins.iter_mut().find(|level| level.pin == pin) {
            Some(level) => level.value = value,
            None => self.pins.push(Level { pin, value }),
        }
    }

    /// The alarms may be others by now.
    pub(super) fn doubt_alarms(&mut self) {
        self.alarms_at = None;
    }

    /// The indices begin anew.
    pub(super) fn reset(&mut self) {
        self.finished = Some(0);
        self.alarms_at = None;
    }

    /// The alarms, if they were read at `since` or later and nothing changed them after that.
    pub(super) fn alarms_since(&self, since: Micros) -> Option<AlarmSet> {
        self.alarms_at.filter(|at| *at >= since).and(self.alarms)
    }

    pub(super) const fn alarms(&self) -> Option<&AlarmSet> {
        self.alarms.as_ref()
    }

    pub(super) const fn current(&self) -> Option<u64> {
        self.current
    }

    pub(super) fn serial(&self) -> Option<&str> {
        self.serial.as_deref()
    }

    /// `None` before all of it was read.
    pub(super) fn all(&self) -> Option<StateReadings> {
        let (pose, at) = self.pose?;
        Some(StateReadings {
            pose,
            at,
            current: QueuedCmdIndex(self.current?),
            left_space: self.left_space?,
            alarms: self.alarms?,
            pins: self.pins.clone(),
        })
    }
}

/// Serial number that can tell one arm from another; `None` if it is empty.
#[must_use]
pub fn serial_number(params: &[u8]) -> Option<String> {
    let serial = DeviceSn::decode(params).ok()?.device_sn.lossy().to_string();
    let serial = serial.trim();
    (!serial.is_empty()).then(|| serial.to_owned())
}
