//! The controller behind its links: its parts, and what happens between them.
//!
//! Each part owns its state and knows none of the others: [`Queues`], [`Motion`], [`Io`],
//! [`Alarms`], [`Store`], [`Teaching`], [`Record`]. A frame becomes a command in `request.rs`; its
//! handler (`handlers/`) is lent a [`Context`] and returns effects, which `apply.rs` applies.
//! `moving.rs` begins and ends motions, `schedule.rs` lets time pass and takes commands from the
//! queue, `external.rs` is what keys, hands and faults do.

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
    /// When the controller was switched on or reset last.
    booted: ArmInstant,
    /// The controller has reset and its links do not know yet.
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
        if device.firmware.profile.power_up.reset_alarm {
            device.raise(Alarm::ResetOccurred);
            device.record.assume(Assumption::ResetAlarm);
        }
        device
    }

    /// As power finds it, but for what the flash keeps, the world and what is written down. Nothing
    /// may move.
    fn restart(&mut self) {
        let profile = &self.firmware.profile;
        self.store.reset(&self.firmware);
        self.queues = Queues::new(profile);
        self.alarms = Alarms::new(profile.queue.alarms_hold);
        self.motion = Motion::at(&self.firmware.model);
        self.io = Io::new(profile, self.io.reported());
        self.teaching = Teaching::at(self.now, self.teaching.held(), micros(profile.teach.period));
        self.booted = self.now;
        self.restarted = true;
        if profile.power_up.reset_alarm {
            // It stands from the start and is not raised: the log says that the controller has
            // reset.
            self.alarms.set(Alarm::ResetOccurred);
        }
    }

    /// Whether the controller has reset since this was asked last.
    pub(crate) fn take_restarted(&mut self) -> bool {
        std::mem::take(&mut self.restarted)
    }

    /// What a handler is lent.
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

    /// The arm, to plan its motions by.
    pub(crate) fn view(&self) -> ArmView<'_> {
        ArmView {
            now: self.now,
            firmware: &self.firmware,
            settings: &self.store.settings,
            motion: &self.motion,
        }
    }

    /// Lets the tools follow their wires, and tells the world what has become of them.
    fn update_tools(&mut self) {
        if let Some(tool) = self.io.update_tools(self.now) {
            let pose = self.motion.true_pose(self.now);
            // What is to come of a motion looks different with another tool.
            self.motion.end_path(self.now, &mut self.world);
            self.world.set_tool(self.now, tool, &pose);
            self.motion.show_path(self.now, &mut self.world);
            self.record_world_events();
        }
    }

    /// What has happened in the world goes into the log.
    fn record_world_events(&mut self) {
        while let Some(event) = self.world.poll_event() {
            self.record.event(Event::World(event));
        }
    }
}
