//! Last readings of an arm, and the events derived from them.

use std::collections::VecDeque;

use magician_protocol::commands::{
    AlarmsState, DeviceSn, IoAdc, IoDi, IoDo, Pose, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use magician_protocol::{AlarmSet, Frame, Layout, QueuedCmdIndex, Readable};

use crate::connection::Micros;

/// Largest number of events kept for a caller that does not poll.
// A single reply can make more than a hundred, one for each alarm.
const MAX_EVENTS: usize = 512;

/// A pin: its EIO address, 1 to 20, and the function assigned to it (`build::multiplex`).
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
    /// EIO address of the pin.
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
    /// Level 0 or 1; for an analog input counts, 4095 at 3.3 V.
    pub value: u16,
}

/// A change shown by a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureEvent {
    /// An alarm is active that was not at the last reading.
    AlarmRaised(u8),
    /// An alarm is no longer active.
    AlarmCleared(u8),
    /// Queued commands of any program have finished.
    Finished {
        /// Index of the first of them.
        first: QueuedCmdIndex,
        /// Index of the last of them.
        last: QueuedCmdIndex,
    },
}

/// Readings of one moment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StateReadings {
    /// Pose and joint angles.
    pub pose: Pose,
    /// Instant of the reply with the pose, us.
    pub at: Micros,
    /// Index of the command finished last.
    pub current: QueuedCmdIndex,
    /// Free places in the queue.
    pub left_space: u32,
    /// Active alarms.
    pub alarms: AlarmSet,
    /// Levels of all pins read so far.
    pub pins: Vec<Level>,
}

/// Reply to a get, classified for the parts that use it.
pub(super) enum Reading {
    Pose(Pose),
    Current(u64),
    LeftSpace(u32),
    Alarms(AlarmSet),
    Level(Level),
    Serial(Option<String>),
    /// A setting, or a reply that cannot be decoded.
    Other,
}

impl Reading {
    pub(super) fn of(reply: &Frame<'_>) -> Self {
        let params = reply.params();
        let level = |pin, value| Self::Level(Level { pin, value });
        let reading = match reply.id() {
            id if id == <Pose as Readable>::ROW.id => Pose::decode(params).map(Self::Pose),
            id if id == <QueuedCmdCurrentIndex as Readable>::ROW.id => {
                QueuedCmdCurrentIndex::decode(params)
                    .map(|read| Self::Current(read.queued_cmd_current_index))
            }
            id if id == <QueuedCmdLeftSpace as Readable>::ROW.id => {
                QueuedCmdLeftSpace::decode(params).map(|read| Self::LeftSpace(read.left_space))
            }
            id if id == <AlarmsState as Readable>::ROW.id => {
                AlarmsState::decode(params).map(|read| Self::Alarms(read.alarms_state))
            }
            id if id == <IoDi as Readable>::ROW.id => IoDi::decode(params)
                .map(|read| level(Pin::Input(read.address), read.level.is_on().into())),
            id if id == <IoDo as Readable>::ROW.id => IoDo::decode(params)
                .map(|read| level(Pin::Output(read.address), read.level.is_on().into())),
            id if id == <IoAdc as Readable>::ROW.id => {
                IoAdc::decode(params).map(|read| level(Pin::Analog(read.address), read.value))
            }
            id if id == <DeviceSn as Readable>::ROW.id => Ok(Self::Serial(serial_number(params))),
            _ => return Self::Other,
        };
        reading.unwrap_or(Self::Other)
    }
}

/// Last value of each reading.
#[derive(Clone, Debug, Default)]
pub(super) struct LastReadings {
    pub(super) pose: Option<(Pose, Micros)>,
    pub(super) current: Option<u64>,
    /// Index up to which finished commands were reported.
    finished: Option<u64>,
    pub(super) left_space: Option<u32>,
    pub(super) alarms: Option<AlarmSet>,
    /// Instant of the reading of the alarms. `None` once a command of this connection may have
    /// changed them.
    alarms_at: Option<Micros>,
    pins: Vec<Level>,
    pub(super) serial: Option<String>,
    pub(super) events: VecDeque<PictureEvent>,
}

impl LastReadings {
    fn happens(&mut self, event: PictureEvent) {
        // A caller that never polls loses the oldest.
        if self.events.len() >= MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    pub(super) fn read_current(&mut self, current: u64) {
        self.current = Some(current);
        match self.finished {
            Some(before) if before < current => {
                self.finished = Some(current);
                // Arms begin with index 2 (model section 14), so there was no command 1 to finish.
                let first = before.saturating_add(1).max(current.min(2));
                self.happens(PictureEvent::Finished {
                    first: QueuedCmdIndex(first),
                    last: QueuedCmdIndex(current),
                });
            }
            // A lower index belongs to a reset, which is reported separately, or was delayed on its
            // way.
            Some(_) => {}
            // The first reading: commands finished before it are not ours to report.
            None => self.finished = Some(current),
        }
    }

    pub(super) fn read_alarms(&mut self, now: Micros, alarms: AlarmSet) {
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

    pub(super) fn read_level(&mut self, level: Level) {
        match self.pins.iter_mut().find(|known| known.pin == level.pin) {
            Some(known) => *known = level,
            None => self.pins.push(level),
        }
    }

    /// Notes that the alarms may have changed.
    pub(super) fn doubt_alarms(&mut self) {
        self.alarms_at = None;
    }

    /// Notes that the indices start again.
    pub(super) fn reset(&mut self) {
        // After a reset the count starts at 0, so the next index reports what has finished since.
        self.finished = Some(0);
        self.alarms_at = None;
    }

    /// Alarms read at `since` or later. `None` if they were read earlier, or something may have
    /// changed them.
    pub(super) fn alarms_since(&self, since: Micros) -> Option<AlarmSet> {
        self.alarms_at.filter(|at| *at >= since).and(self.alarms)
    }

    /// All readings. `None` until each of them was read.
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

/// Serial number that distinguishes one arm from another. `None` if it is empty.
#[must_use]
pub fn serial_number(params: &[u8]) -> Option<String> {
    let serial = DeviceSn::decode(params).ok()?.device_sn.lossy().to_string();
    let serial = serial.trim();
    (!serial.is_empty()).then(|| serial.to_owned())
}
