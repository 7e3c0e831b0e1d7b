//! The view of the device that a handler borrows: parts that it may change, and parts that it may
//! read.

use magician_motion::{ArmState, Geometry, JointAngles};
use magician_protocol::Readable;
use magician_protocol::commands::EndEffectorParams;

use super::alarms::Alarms;
use super::firmware::Firmware;
use super::io::Io;
use super::motion::{ArmView, Motion};
use super::queue::Queue;
use super::queue::program::Queues;
use super::record::Record;
use super::store::Store;
use super::teaching::Teaching;
use crate::{ArmInstant, Flash, World};

/// The parts of the device for a handler. The mutable ones keep settings, pins, teaching and
/// record; motion, queues and alarms change by effects only.
pub(crate) struct Context<'a> {
    pub(crate) now: ArmInstant,
    /// Instant of power-up or of the latest reset.
    pub(crate) booted: ArmInstant,
    pub(crate) firmware: &'a Firmware,
    pub(crate) store: &'a mut Store,
    pub(crate) io: &'a mut Io,
    pub(crate) teaching: &'a mut Teaching,
    pub(crate) record: &'a mut Record,
    pub(crate) motion: &'a Motion,
    pub(crate) queues: &'a Queues,
    pub(crate) alarms: &'a Alarms,
    pub(crate) world: &'a World,
}

impl Context<'_> {
    /// The arm as seen by the planner.
    pub(crate) fn view(&self) -> ArmView<'_> {
        ArmView {
            now: self.now,
            firmware: self.firmware,
            settings: &self.store.settings,
            motion: self.motion,
        }
    }

    /// Commanded state of the arm.
    pub(crate) fn arm(&self) -> ArmState {
        self.view().arm()
    }

    /// Commanded position of the rail's carriage, mm.
    pub(crate) fn rail(&self) -> f64 {
        self.view().rail()
    }

    pub(crate) fn geometry(&self) -> Geometry {
        self.view().geometry()
    }

    pub(crate) fn has_rail(&self) -> bool {
        self.store.settings.motion.has_rail()
    }

    /// True joint angles.
    pub(crate) fn true_joints(&self) -> JointAngles {
        self.motion.true_pose(self.now).joints
    }

    /// Queue filled by hosts.
    pub(crate) fn hosts(&self) -> &Queue {
        self.queues.hosts()
    }

    /// True if this parameter set was set since power-up.
    pub(crate) fn was_set<T: Readable>(&self) -> bool {
        self.store.settings.set_ids.contains(T::ROW.id)
    }

    /// True if the tool bias was not set since power-up.
    pub(crate) fn has_tool_of_power_up(&self) -> bool {
        !self.was_set::<EndEffectorParams>()
    }

    /// Flash of a new arm.
    pub(crate) fn new_flash(&self) -> Flash {
        Flash::new(&self.firmware.profile)
    }

    pub(crate) fn digital(&self, address: u8) -> bool {
        self.io.pins.digital(address, self.world, self.now)
    }

    pub(crate) fn analog(&self, address: u8) -> u16 {
        self.io.pins.analog(address, self.world, self.now)
    }
}
