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

/// An answer to a get, for the parts that follow it.
pub(super) enum Reading {
    Pose(Pose),
    Current(u64),
    LeftSpace(u32),
    Alarms(AlarmSet),
    Level(Level),
    Serial(Option<String>),
    /// A setting, or an answer that cannot be read.
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

/// What was read last.
#[derive(Clone, Debug, Default)]
pub(super) struct LastReadings {
    pub(super) pose: Option<(Pose, Micros)>,
    pub(super) current: Option<u64>,
    /// Index up to which the end of commands was told.
    finished: Option<u64>,
    pub(super) left_space: Option<u32>,
    pub(super) alarms: Option<AlarmSet>,
    /// When the alarms were read; `None` as soon as they may have changed by a command of this connection.
    alarms_at: Option<Micros>,
    pins: Vec<Level>,
    pub(super) serial: Option<String>,
    pub(super) events: VecDeque<PictureEvent>,
}

impl LastReadings {
    fn happens(&mut self, event: PictureEvent) {
        if self.events.len() >= MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    pub(super) fn read_current(&mut self, current: u64) {
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
