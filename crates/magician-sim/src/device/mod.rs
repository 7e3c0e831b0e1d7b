//! The controller behind its links: its parts, and the code that connects them.
//!
//! Each part owns its state and knows no other part: [`Queues`], [`Motion`], [`Io`], [`Alarms`],
//! [`Store`], [`Teaching`], [`Record`]. A request passes through these files:
//!
//! * `request.rs` decodes a frame and decides between acting at once, queueing and silence.
//! * The handler in `handlers/` borrows a [`Context`] and returns effects.
//! * `apply.rs` applies the effects to the parts.
//! * `moving.rs` starts and ends motions.
//! * `schedule.rs` advances time and takes commands from the queue.
//! * `external.rs` handles keys, hands, faults and power.

mod alarms;
mod apply;
pub(crate) mod context;
pub(crate) mod effect;
mod external;
mod firmware;
mod handlers;
pub(crate) mod io;
pub(crate) mod motion;
mod moving;
pub(crate) mod queue;
pub(crate) mod record;
mod request;
mod schedule;
pub(crate) mod store;
mod teaching;

use magician_protocol::Alarm;

use crate::convert::micros;
use crate::event::Event;
use crate::fidelity::Assumption;
use crate::link::LineState;
use crate::world::ToolState;
use crate::{ArmInstant, Flash, Profile, World};
use alarms::Alarms;
use context::Context;
use firmware::Firmware;
use io::Io;
use motion::{ArmView, Motion};
use queue::program::Queues;
use record::Record;
use store::Store;
use teaching::Teaching;

/// The controller behind its links.
#[derive(Clone)]
pub(crate) struct Device {
    pub(crate) now: ArmInstant,
    /// Instant of power-up or of the latest reset.
    booted: ArmInstant,
    /// True until the links have learnt of a reset.
    restarted: bool,
    pub(crate) firmware: Firmware,
    pub(crate) store: Store,
    pub(crate) queues: Queues,
    pub(crate) alarms: Alarms,
    pub(crate) motion: Motion,
    pub(crate) io: Io,
    pub(crate) teaching: Teaching,
    pub(crate) world: World,
    pub(crate) line: LineState,
    pub(crate) record: Record,
}

impl Device {
    fn new(profile: Profile, world: World, flash: Flash) -> Self {
        let firmware = Firmware::new(profile);
        let profile = &firmware.profile;
        let mut device = Self {
            now: ArmInstant::ZERO,
            booted: ArmInstant::ZERO,
            restarted: false,
            store: Store::new(&firmware, flash),
            queues: Queues::new(profile),
            alarms: Alarms::new(profile.queue.alarms_hold),
            motion: Motion::at(&firmware.model),
            io: Io::new(profile, ToolState::default()),
            teaching: Teaching::at(ArmInstant::ZERO, false, micros(profile.teach.period)),
            world,
            line: LineState::default(),
            record: Record::new(profile.fidelity.strict),
            firmware,
        };
        // Raised, so that the log shows it at power-up; `restart` only sets it.
        if device.firmware.profile.power_up.reset_alarm {
            device.raise(Alarm::ResetOccurred);
            device.record.assume(Assumption::ResetAlarm);
        }
        device
    }

    /// Resets everything but flash, world and record. No motion may be under way.
    fn restart(&mut self) {
        let profile = &self.firmware.profile;
        self.store.reset(&self.firmware);
        self.queues = Queues::new(profile);
        self.alarms = Alarms::new(profile.queue.alarms_hold);
        self.motion = Motion::at(&self.firmware.model);
        // The world keeps its view of the tool; the next `update_tools` reports what the reset
        // switched off.
        self.io = Io::new(profile, self.io.reported());
        self.teaching = Teaching::at(self.now, self.teaching.held(), micros(profile.teach.period));
        self.booted = self.now;
        self.restarted = true;
        if profile.power_up.reset_alarm {
            // Set without an event: the log already has `Reset`.
            self.alarms.set(Alarm::ResetOccurred);
        }
    }

    /// True if the controller was reset since the last call.
    pub(crate) fn take_restarted(&mut self) -> bool {
        std::mem::take(&mut self.restarted)
    }

    /// Lends the parts to a handler.
    pub(crate) fn lend(&mut self) -> Context<'_> {
        Context {
            now: self.now,
            booted: self.booted,
            firmware: &self.firmware,
            store: &mut self.store,
            io: &mut self.io,
            teaching: &mut self.teaching,
            record: &mut self.record,
            motion: &self.motion,
            queues: &self.queues,
            alarms: &self.alarms,
            world: &self.world,
        }
    }

    /// The arm as seen by the planner.
    pub(crate) fn view(&self) -> ArmView<'_> {
        ArmView {
            now: self.now,
            firmware: &self.firmware,
            settings: &self.store.settings,
            motion: &self.motion,
        }
    }

    /// Updates the tools from the pins that drive them, and reports changes to the world.
    fn update_tools(&mut self) {
        if let Some(tool) = self.io.update_tools(self.now) {
            let pose = self.motion.true_pose(self.now);
            // The world has predicted contacts of the running motion with the old tool: end that
            // prediction first and start a new one after.
            self.motion.end_path(self.now, &mut self.world);
            self.world.set_tool(self.now, tool, &pose);
            self.motion.show_path(self.now, &mut self.world);
            self.record_world_events();
        }
    }

    /// Copies the world's events into the log.
    fn record_world_events(&mut self) {
        while let Some(event) = self.world.poll_event() {
            self.record.event(Event::World(event));
        }
    }
}
