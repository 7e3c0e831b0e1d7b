//! What happens to the controller from outside its protocol: keys, hands, faults, power.

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
    /// Something happens to the arm at the present instant.
    pub(crate) fn apply_external(&mut self, event: ExternalEvent) {
        match event {
            ExternalEvent::Input => {}
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

    /// The base key runs the program in the flash or stops it; held, it homes the arm. It has no
    /// effect while the unlock key is held.
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
                self.stop_program();
                // As an immediate command: nothing waits for it.
                let _: Completion = self.home();
            }
        }
    }

    /// The unlock key is pressed or released. Pressed, it ends what moves and has the sensors read;
    /// released, the motors hold the arm where it is.
    fn unlock(&mut self, held: bool) {
        if held == self.teaching.held() {
            return;
        }
        self.lend().look_for_point();
        self.record.assume(Assumption::TeachKey);
        if held {
            self.halt();
            self.io.tools.burn(0.0);
            // J2 and J3 are commanded to be where their sensors say that they are, and J1 where its
            // encoder does.
            let really = self.motion.true_pose(self.now).joints;
            self.be_moved(really);
            self.teaching.press(self.now);
        } else {
            self.teaching.release(&self.store.settings);
        }
    }

    /// A hand moves the arm there, as far as it goes. Without the key the motors hold it where it
    /// is.
    fn guide(&mut self, joints: JointAngles) {
        if self.teaching.held() {
            let before = self.motion.true_pose(self.now).joints;
            let really = self.bent_to(joints, before);
            self.be_moved(really);
        }
    }

    /// A hand lays a new sheet of paper: what is drawn from now on stays.
    pub(crate) fn clear_drawing(&mut self) {
        self.motion.end_path(self.now, &mut self.world);
        self.world.clear_drawing();
        self.motion.show_path(self.now, &mut self.world);
    }

    /// A hand puts an object of the world somewhere; false if none has that name.
    pub(crate) fn place(&mut self, name: &str, at: [f64; 3]) -> bool {
        if at.iter().any(|part| !part.is_finite()) {
            return false;
        }
        let pose = self.motion.true_pose(self.now);
        // What is to come of a motion looks different where an object stands elsewhere.
        self.motion.end_path(self.now, &mut self.world);
        let placed = self.world.place(self.now, &pose, name, at);
        self.motion.show_path(self.now, &mut self.world);
        self.update_tools();
        placed
    }

    fn be_moved(&mut self, really: JointAngles) {
        let geometry = self.view().geometry();
        (self.motion).be_moved(self.now, &geometry, really, &mut self.world);
        self.drop_limit_alarms();
    }

    /// The controller starts anew: what it was told is forgotten, but for what its flash keeps. The
    /// arm stays where it is, and of that J2 and J3 are known by their sensors.
    fn reset(&mut self) {
        self.halt();
        self.rest_steppers();
        let really = self.motion.true_pose(self.now);
        self.restart();
        self.wake_at(really.joints);
        self.motion.forget_rail(really.rail);
        self.record.event(Event::Reset);
        self.record.assume(Assumption::FlashKeeps);
        self.record.assume(Assumption::ResetAlarm);
        self.update_tools();
    }

    /// Power comes while the arm really stands somewhere.
    fn wake_at(&mut self, really: JointAngles) {
        let geometry = self.view().geometry();
        self.motion.wake_at(self.now, &geometry, really);
        self.drop_limit_alarms();
    }

    /// The controller is switched on in a world, which may know how the arm stands.
    pub(crate) fn switched_on(mut profile: Profile, world: World, flash: Flash) -> Self {
        if let Some(tool) = world.scenario().and_then(Scenario::chosen_tool) {
            profile.power_up.tool = tool.bias();
        }
        let stands = world.scenario().map(|scenario| *scenario.arm());
        let mut device = Self::new(profile, world, flash);
        if let Some(Arm { base_angle, homed }) = stands {
            let joints = device.motion.joints(device.now);
            let j1 = joints.j1 + base_angle;
            device.wake_at(JointAngles { j1, ..joints });
            device.motion.set_homed(homed);
        }
        device
    }

    /// Another tool was chosen before the controller was switched on.
    pub(crate) fn had_tool(&mut self, tool: ToolBias) {
        self.firmware.had_tool(tool);
        self.store.settings.motion.tool = tool_to_wire(tool);
    }

    /// Another serial number was in the flash before the controller was switched on.
    pub(crate) fn had_serial(&mut self, serial: String) {
        let device_sn = Text::new(&serial).unwrap_or_default();
        self.store.begins_with_serial(DeviceSn { device_sn });
        self.firmware.profile.identity.serial = serial;
    }

    /// The controller was switched on while the arm really stood there.
    pub(crate) fn stood_at(&mut self, joints: JointAngles) {
        let usual = self.firmware.model.power_up.joints;
        let really = self.bent_to(joints, usual);
        self.wake_at(really);
        self.motion.set_homed(false);
    }

    /// Where the joints come to when they are bent to given angles: no further than the limits, and
    /// what is not a number stays as it was.
    fn bent_to(&self, joints: JointAngles, before: JointAngles) -> JointAngles {
        let limits = self.firmware.model.limits;
        let within = |range: Range, angle: f64| angle.max(range.min).min(range.max);
        let or = |angle: f64, before: f64| if angle.is_finite() { angle } else { before };
        let Range { min, max } = limits.j2_minus_j3;
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
