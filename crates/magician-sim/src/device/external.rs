//! What happens to the controller from outside its protocol: keys, hands, faults.

use magician_motion::{JointAngles, Range, ToolBias};

use crate::convert::tool_to_wire;
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::device::handlers::teach::Teaching;
use crate::device::store::flash::Flash;
use crate::event::Event;
use crate::fidelity::Assumption;
use crate::scenario::Arm;
use crate::world::{Drawing, Happening, Look, Press};
use crate::{Micros, Profile, Scenario, World};

/// The cable between the arm and its host, for those who carry the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineState {
    /// Whether it is plugged in.
    pub plugged: bool,
    /// How often it has been pulled.
    pub pulls: u64,
    /// How much longer than usual answers take.
    pub delay: Micros,
}

impl Default for LineState {
    fn default() -> Self {
        Self {
            plugged: true,
            pulls: 0,
            delay: 0,
        }
    }
}

impl Device {
    /// Something happens to the arm at the present instant.
    pub(crate) fn meet(&mut self, happening: Happening) {
        match happening {
            Happening::Input => {}
            Happening::Touch { stalls, .. } => {
                if stalls {
                    self.stall();
                }
            }
            Happening::Slip { joint, degrees } => {
                self.log.push(Event::Slipped { joint, degrees });
                self.slip(joint, degrees);
            }
            Happening::Alarm(code) => self.raise(code),
            Happening::Reset => self.reset(),
            Happening::Cable { plugged } => {
                if plugged != self.line.plugged {
                    self.log.push(Event::Cable { plugged });
                    self.line.plugged = plugged;
                    self.line.pulls += u64::from(!plugged);
                }
            }
            Happening::Delay(delay) => self.line.delay = delay,
            Happening::Key(press) => {
                self.log.push(Event::Key { press });
                self.press(press);
            }
            Happening::Unlock(held) => {
                self.log.push(Event::Unlocked { held });
                self.unlock(held);
            }
            Happening::Guide(joints) => self.guide(joints),
        }
        self.feel_grip();
    }

    /// The base key runs the program in the flash or stops it; held, it homes the arm. It has no effect while the
    /// unlock key is held.
    fn press(&mut self, press: Press) {
        if self.teaching.held() {
            return;
        }
        self.assume(match press {
            Press::Short => Assumption::BaseKey,
            Press::Long => Assumption::BaseKeyHeld,
        });
        match press {
            Press::Short => self.toggle_program(),
            Press::Long => {
                self.stop_program();
                // As an immediate command: nothing waits for it.
                let _: Step = self.home();
            }
        }
    }

    /// What has happened in the world goes into the log.
    pub(crate) fn tell_incidents(&mut self) {
        while let Some(incident) = self.world.poll_incident() {
            self.log.push(Event::World(incident));
        }
    }

    /// The controller starts anew: what it was told is forgotten, but for what its flash keeps. The arm stays where it
    /// is, and of that J2 and J3 are known by their sensors.
    fn reset(&mut self) {
        self.halt();
        self.rest_steppers();
        let really = self.posture();
        let world = std::mem::take(&mut self.world);
        let mut anew = Self::new(self.profile.clone(), world, self.flash.clone());
        anew.flash_writes = self.flash_writes;
        anew.teaching = Teaching::at(self.now, self.teaching.held());
        anew.now = self.now;
        anew.booted = self.now;
        anew.restarted = true;
        anew.line = self.line;
        anew.grip = self.grip;
        anew.log = std::mem::take(&mut self.log);
        anew.fidelity = std::mem::take(&mut self.fidelity);
        anew.wake_at(really.joints);
        anew.motion.rail.slip = really.rail;
        *self = anew;
        self.log.push(Event::Reset);
        self.assume(Assumption::FlashKeeps);
        self.assume(Assumption::ResetAlarm);
        self.feel_grip();
    }

    /// Power comes while the arm really stands somewhere: J1 reads what it reads at power-up, J2 and J3 what their
    /// sensors say.
    fn wake_at(&mut self, really: JointAngles) {
        let reported = self.arm().joints;
        let j1 = reported.j1;
        self.place_at(JointAngles { j1, ..really });
        self.motion.forget_base(really.j1 - j1);
    }

    /// The controller is switched on in a world, which may know how the arm stands.
    pub(crate) fn switched_on(mut profile: Profile, world: World, flash: Flash) -> Self {
        if let Some(tool) = world.scenario().and_then(Scenario::chosen_tool) {
            profile.power_up.tool = tool.bias();
        }
        let mut core = Self::new(profile, world, flash);
        let stands = core.world.scenario().map(|scenario| *scenario.arm());
        if let Some(Arm { base_angle, homed }) = stands {
            let joints = core.arm().joints;
            let j1 = joints.j1 + base_angle;
            core.wake_at(JointAngles { j1, ..joints });
            core.homed = homed;
        }
        core
    }

    /// Another tool was chosen before the controller was switched on.
    pub(crate) fn had_tool(&mut self, tool: ToolBias) {
        self.profile.power_up.tool = tool;
        self.settings.bias = tool_to_wire(tool);
    }

    /// The controller was switched on while the arm really stood there.
    pub(crate) fn stood_at(&mut self, joints: JointAngles) {
        let usual = self.model.power_up.joints;
        let really = self.bent_to(joints, usual);
        self.wake_at(really);
        self.homed = false;
    }

    /// Where the joints come to when they are bent to given angles: no further than the limits, and what is not a
    /// number stays as it was.
    pub(crate) fn bent_to(&self, joints: JointAngles, before: JointAngles) -> JointAngles {
        let limits = self.model.limits;
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

impl crate::Controller {
    /// Lets something happen to the arm now: a key is pressed, a joint slips, the cable is pulled.
    pub fn inject(&mut self, happening: Happening) {
        self.core.meet(happening);
        self.core.settle();
        self.forget_links();
    }

    /// The world around the arm at the present instant: where its objects are, and what the tool holds.
    #[must_use]
    pub fn look(&self) -> Look<'_> {
        self.core.world.look(self.core.now, &self.core.posture())
    }

    /// What pen and laser have left by now.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        self.core.drawing()
    }

    /// Presses the base key: short, it runs the program in the flash or stops it; long, it homes the arm.
    pub fn press(&mut self, press: Press) {
        self.inject(Happening::Key(press));
    }

    /// Presses or releases the unlock key on the forearm. While it is held the motors are released: what moves ends,
    /// the queue waits, immediate motions are refused, and [`guide`](Self::guide) moves the arm.
    pub fn unlock(&mut self, held: bool) {
        self.inject(Happening::Unlock(held));
    }

    /// Moves the arm by hand to where its joints really are to stand, deg, as far as the limits let it; what is not a
    /// number stays. Without the unlock key the motors hold it where it is.
    ///
    /// ```
    /// let mut arm = magician_sim::Controller::default();
    /// arm.unlock(true);
    /// arm.guide([20.0, 30.0, 40.0, 0.0].into());
    /// arm.unlock(false);
    /// assert_eq!(arm.state().joints.to_array(), [20.0, 30.0, 40.0, 0.0]);
    /// ```
    pub fn guide(&mut self, joints: JointAngles) {
        self.inject(Happening::Guide(joints));
    }

    /// The state of the cable, for those who carry the bytes.
    #[must_use]
    pub fn line(&self) -> LineState {
        self.core.line
    }

    /// After a reset nobody is owed an answer.
    pub(crate) fn forget_links(&mut self) {
        if std::mem::take(&mut self.core.restarted) {
            self.links.clear();
        }
    }
}
