//! Events from outside the protocol: keys, hands, faults, power.

use magician_model::tool_to_wire;
use magician_motion::{JointAngles, Range, ToolBias};
use magician_protocol::Text;
use magician_protocol::commands::DeviceSn;

use super::Device;
use super::effect::Completion;
use crate::event::Event;
use crate::fidelity::Assumption;
use crate::scenario::Arm;
use crate::world::{ExternalEvent, Press};
use crate::{Flash, Profile, Scenario, World};

impl Device {
    /// Applies an event at the present instant.
    pub(crate) fn apply_external(&mut self, event: ExternalEvent) {
        match event {
            // The world has changed the input already; the queue looks at it when it runs next.
            ExternalEvent::Input => {}
            // A touch that does not stall is an event for the log only.
            ExternalEvent::Touch { stalls, .. } => {
                if stalls {
                    self.motion.stall(self.now, &mut self.world);
                }
            }
            ExternalEvent::Slip { joint, degrees } => {
                self.record.event(Event::Slipped { joint, degrees });
                (self.motion).slip(self.now, joint, degrees, &mut self.world);
            }
            ExternalEvent::Alarm(code) => self.raise(code),
            ExternalEvent::Reset => self.reset(),
            ExternalEvent::Cable { plugged } => {
                // A repeated plug or unplug changes nothing, and must not count as a pull.
                if plugged != self.line.plugged {
                    self.record.event(Event::Cable { plugged });
                    self.line.plugged = plugged;
                    self.line.pulls += u64::from(!plugged);
                }
            }
            ExternalEvent::Delay(delay) => self.line.delay = delay,
            ExternalEvent::Key(press) => {
                self.record.event(Event::Key { press });
                self.press(press);
            }
            ExternalEvent::Unlock(held) => {
                self.record.event(Event::Unlocked { held });
                self.unlock(held);
            }
            ExternalEvent::Guide(joints) => self.guide(joints),
        }
        self.update_tools();
    }

    /// Presses the base key: short runs or stops the stored program, long homes the arm.
    ///
    /// The press has no effect while the unlock key is held, because the motors are released.
    fn press(&mut self, press: Press) {
        if self.teaching.held() {
            return;
        }
        self.record.assume(match press {
            Press::Short => Assumption::BaseKey,
            Press::Long => Assumption::BaseKeyHeld,
        });
        match press {
            Press::Short => self.toggle_program(),
            Press::Long => {
                // The program first: homing replaces its motion, and it must not continue
                // afterwards.
                self.stop_program();
                // Like an immediate command: no index waits for it.
                let _: Completion = self.home();
            }
        }
    }

    /// Presses or releases the unlock key.
    ///
    /// Pressing it ends the running motion and reads the sensors; after release the motors hold the
    /// arm where it is.
    fn unlock(&mut self, held: bool) {
        // A key cannot be pressed twice: the periods of teaching must not restart.
        if held == self.teaching.held() {
            return;
        }
        // Points are computed on demand: take a periodic point that fell due before the change.
        self.lend().look_for_point();
        self.record.assume(Assumption::TeachKey);
        if held {
            self.halt();
            // `halt` switches the laser off only if something moved.
            self.io.tools.burn(0.0);
            // Commanded J2 and J3 become what their absolute sensors read, and J1 what its encoder
            // reads (model section 12).
            let really = self.motion.true_pose(self.now).joints;
            self.move_by_hand(really);
            self.teaching.press(self.now);
        } else {
            self.teaching.release(&self.store.settings);
        }
    }

    /// Moves the arm by hand, as far as the limits allow. Without the key the motors hold it.
    fn guide(&mut self, joints: JointAngles) {
        if self.teaching.held() {
            let before = self.motion.true_pose(self.now).joints;
            let really = self.clamp_joints(joints, before);
            self.move_by_hand(really);
        }
    }

    /// Replaces the sheet of paper. A stroke in progress is split: only its rest stays.
    pub(crate) fn clear_drawing(&mut self) {
        self.motion.end_path(self.now, &mut self.world);
        self.world.clear_drawing();
        self.motion.show_path(self.now, &mut self.world);
    }

    /// Moves an object of the world by hand. Returns false if there is no object of that name.
    pub(crate) fn place(&mut self, name: &str, at: [f64; 3]) -> bool {
        // NaN would poison every later comparison of positions.
        if at.iter().any(|part| !part.is_finite()) {
            return false;
        }
        let pose = self.motion.true_pose(self.now);
        // The world has predicted contacts of the running motion with the old layout: end that
        // prediction first and start a new one after.
        self.motion.end_path(self.now, &mut self.world);
        // Also while the arm moves: the rest of its motion meets the object at its new place.
        let placed = self.world.place(self.now, &pose, name, at);
        self.motion.show_path(self.now, &mut self.world);
        self.update_tools();
        placed
    }

    fn move_by_hand(&mut self, really: JointAngles) {
        let geometry = self.view().geometry();
        (self.motion).move_by_hand(self.now, &geometry, really, &mut self.world);
        self.drop_limit_alarms();
    }

    /// Resets the controller: everything but the flash is forgotten. The arm stays where it is, and
    /// its J2 and J3 are known by their sensors.
    fn reset(&mut self) {
        self.halt();
        self.rest_steppers();
        let really = self.motion.true_pose(self.now);
        // Restart first: it puts the commanded joints to their values of power-up, from which the
        // true ones then differ.
        self.restart();
        self.wake_at(really.joints);
        self.motion.forget_rail(really.rail);
        self.record.event(Event::Reset);
        self.record.assume(Assumption::FlashKeeps);
        self.record.assume(Assumption::ResetAlarm);
        self.update_tools();
    }

    /// Applies power while the arm stands at these true joints.
    fn wake_at(&mut self, really: JointAngles) {
        let geometry = self.view().geometry();
        self.motion.wake_at(self.now, &geometry, really);
        self.drop_limit_alarms();
    }

    /// Powers up in a world whose scenario may define tool, base angle and homing.
    pub(crate) fn switched_on(mut profile: Profile, world: World, flash: Flash) -> Self {
        if let Some(tool) = world.scenario().and_then(Scenario::chosen_tool) {
            // A real arm keeps the bias chosen before (model section 6); the scenario says which.
            profile.power_up.tool = tool.bias();
        }
        let stands = world.scenario().map(|scenario| *scenario.arm());
        let mut device = Self::new(profile, world, flash);
        if let Some(Arm { base_angle, homed }) = stands {
            let joints = device.motion.joints(device.now);
            let j1 = joints.j1 + base_angle;
            device.wake_at(JointAngles { j1, ..joints });
            // After `wake_at`, which makes the base unknown.
            device.motion.set_homed(homed);
        }
        device
    }

    /// Changes the tool bias of power-up afterwards.
    pub(crate) fn set_initial_tool(&mut self, tool: ToolBias) {
        self.firmware.set_initial_tool(tool);
        self.store.settings.motion.tool = tool_to_wire(tool);
    }

    /// Changes the serial number in the flash afterwards; that does not count as a write.
    pub(crate) fn set_initial_serial(&mut self, serial: String) {
        let device_sn = Text::new(&serial).unwrap_or_default();
        self.store.begins_with_serial(DeviceSn { device_sn });
        self.firmware.profile.identity.serial = serial;
    }

    /// Changes the true joints of power-up afterwards.
    pub(crate) fn set_initial_joints(&mut self, joints: JointAngles) {
        let usual = self.firmware.model.power_up.joints;
        let really = self.clamp_joints(joints, usual);
        self.wake_at(really);
        self.motion.set_homed(false);
    }

    /// Clamps joint angles to the limits, including that of J2 - J3. A NaN or infinite value is
    /// replaced by `before`.
    fn clamp_joints(&self, joints: JointAngles, before: JointAngles) -> JointAngles {
        let limits = self.firmware.model.limits;
        let within = |range: Range, angle: f64| angle.max(range.min).min(range.max);
        let or = |angle: f64, before: f64| if angle.is_finite() { angle } else { before };
        let Range { min, max } = limits.j2_minus_j3;
        // J2 and J3 limit each other: clamp J2, then J3 to J2 and its own range, then J2 once more.
        let j2 = within(limits.j2, or(joints.j2, before.j2));
        let j3 = or(joints.j3, before.j3).max(j2 - max).min(j2 - min);
        let j3 = within(limits.j3, j3);
        JointAngles {
            j1: within(limits.j1, or(joints.j1, before.j1)),
            j2: j2.max(j3 + min).min(j3 + max),
            j3,
            j4: within(limits.j4, or(joints.j4, before.j4)),
        }
    }
}
