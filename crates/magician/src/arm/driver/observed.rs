//! What passes anyway says something about the arm: the state for onlookers, and what has happened.

use magician_protocol::commands::{
    AlarmsState, DeviceSn, IoAdc, IoDi, IoDo, Pose, QueuedCmdClear, QueuedCmdCurrentIndex,
    QueuedCmdLeftSpace,
};
use magician_protocol::{AlarmSet, Frame, Layout, QueuedCmdIndex, Readable, Writable};
use tokio::time::Instant;

use super::Driver;
use super::greeting::serial_number;
use crate::arm::events::Event;
use crate::arm::link::Link;
use crate::arm::shared::held;
use crate::arm::state::{Level, Pin, Status};

/// What was seen of the arm last.
#[derive(Debug, Default)]
pub(super) struct ObservedState {
    pose: Option<(Pose, Instant)>,
    current: Option<u64>,
    /// The index up to which the end of commands was told.
    finished: Option<u64>,
    left_space: Option<u32>,
    alarms: Option<AlarmSet>,
    pins: Vec<Level>,
}

impl ObservedState {
    fn pin(&mut self, pin: Pin, value: u16) {
        match self.pins.iter_mut().find(|level| level.pin == pin) {
            Some(level) => level.value = value,
            None => self.pins.push(Level { pin, value }),
        }
    }
}

impl Driver {
    /// A request was answered.
    pub(super) fn observe(&mut self, request: &Frame<'_>, reply: &Frame<'_>) {
        let written = request.ctrl().write();
        let params = reply.params();
        match request.id() {
            id if id == <DeviceSn as Readable>::ROW.id => {
                let said = if written { request.params() } else { params };
                self.serial = serial_number(said);
            }
            id if id == QueuedCmdClear::ROW.id && written => self.shared.own().clear(),
            _ if written || request.ctrl().queued() => {}
            id if id == <Pose as Readable>::ROW.id => {
                if let Ok(pose) = Pose::decode(params) {
                    self.observed.pose = Some((pose, Instant::now()));
                }
            }
            id if id == <QueuedCmdCurrentIndex as Readable>::ROW.id => {
                if let Ok(read) = QueuedCmdCurrentIndex::decode(params) {
                    self.see_current(read.queued_cmd_current_index);
                }
            }
            id if id == <QueuedCmdLeftSpace as Readable>::ROW.id => {
                if let Ok(read) = QueuedCmdLeftSpace::decode(params) {
                    self.observed.left_space = Some(read.left_space);
                }
            }
            id if id == <AlarmsState as Readable>::ROW.id => {
                if let Ok(read) = AlarmsState::decode(params) {
                    self.see_alarms(read.alarms_state);
                }
            }
            id => self.see_pin(id, params),
        }
    }

    /// The index that was read last.
    pub(super) fn current_index(&self) -> Option<u64> {
        self.observed.current
    }

    fn see_current(&mut self, current: u64) {
        self.observed.current = Some(current);
        match self.observed.finished {
            Some(before) if before < current => {
                // Arms begin with 2 (model section 14): there is no command 1 to have finished.
                let first = before.saturating_add(1).max(current.min(2));
                self.happens(Event::CommandFinished {
                    first: QueuedCmdIndex(first),
                    last: QueuedCmdIndex(current),
                });
                self.observed.finished = Some(current);
            }
            // One that goes back is of a reset, which is told by itself, or was held up on its way.
            Some(_) => {}
            None => self.observed.finished = Some(current),
        }
    }

    fn see_alarms(&mut self, alarms: AlarmSet) {
        if let Some(before) = self.observed.alarms.replace(alarms) {
            for code in alarms.codes().filter(|code| !before.contains(*code)) {
                self.happens(Event::AlarmRaised { code });
            }
            for code in before.codes().filter(|code| !alarms.contains(*code)) {
                self.happens(Event::AlarmCleared { code });
            }
        }
    }

    fn see_pin(&mut self, id: u8, params: &[u8]) {
        let seen = match id {
            id if id == <IoDi as Readable>::ROW.id => IoDi::decode(params)
                .ok()
                .map(|read| (Pin::Input(read.address), read.level.is_on().into())),
            id if id == <IoDo as Readable>::ROW.id => IoDo::decode(params)
                .ok()
                .map(|read| (Pin::Output(read.address), read.level.is_on().into())),
            id if id == <IoAdc as Readable>::ROW.id => IoAdc::decode(params)
                .ok()
                .map(|read| (Pin::Analog(read.address), read.value)),
            _ => None,
        };
        if let Some((pin, value)) = seen {
            self.observed.pin(pin, value);
        }
    }

    /// The indices begin anew.
    pub(super) fn see_reset(&mut self) {
        self.observed.finished = Some(0);
    }

    /// Notifies the listeners, if any.
    pub(super) fn happens(&self, event: Event) {
        let _ = self.events.send(event);
    }

    /// Shows the onlookers what was seen, once all of it was.
    pub(super) fn publish_status(&self) {
        let observed = &self.observed;
        let (Some((pose, at)), Some(current), Some(left_space), Some(alarms)) = (
            observed.pose,
            observed.current,
            observed.left_space,
            observed.alarms,
        ) else {
            return;
        };
        let watched = held(&self.shared.watches).pins();
        let pins = (observed.pins.iter().copied()).filter(|level| watched.contains(&level.pin));
        self.shared.status.send_replace(Some(Status {
            pose,
            current: QueuedCmdIndex(current),
            left_space,
            homed: self.shared.known().homed_under(&alarms),
            alarms,
            pins: pins.collect(),
            link: self.shared.link.borrow().clone(),
            at: at.into_std(),
        }));
    }

    /// The line was lost or found: observers see it at once.
    pub(super) fn publish_link(&self, link: Link) {
        self.shared.link.send_replace(link.clone());
        self.shared.status.send_if_modified(|status| match status {
            Some(status) => {
                status.link = link;
                true
            }
            None => false,
        });
    }
}
