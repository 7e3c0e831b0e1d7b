//! What happens to the controller from outside its protocol: keys, hands, faults.

use crate::Micros;
use crate::core::Core;
use crate::event::Event;
use crate::world::Happening;

/// The cable between the arm and its host, for those who carry the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineState {
    /// Whether it is plugged in.
    pub plugged: bool,
    /// How much longer than usual answers take.
    pub delay: Micros,
}

impl Default for LineState {
    fn default() -> Self {
        Self {
            plugged: true,
            delay: 0,
        }
    }
}

impl Core {
    /// Something happens to the arm at the present instant.
    pub(crate) fn meet(&mut self, happening: Happening) {
        match happening {
            Happening::Input => {}
            Happening::Touch { thing, stalls } => {
                self.log.push(Event::Touched { thing, stalls });
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
                self.log.push(Event::Cable { plugged });
                self.line.plugged = plugged;
            }
            Happening::Delay(delay) => self.line.delay = delay,
            Happening::Key(press) => self.log.push(Event::Key { press }),
            Happening::Unlock(held) => self.log.push(Event::Unlocked { held }),
            Happening::Guide(_) => {}
        }
    }

    /// The controller starts anew: what it was told is forgotten, but for what its flash keeps. The arm stays where it
    /// is, and of that J2 and J3 are known by their sensors.
    fn reset(&mut self) {
        self.halt();
        self.rest_steppers();
        let really = self.posture();
        let mut anew = Self::new(self.profile.clone(), std::mem::take(&mut self.world));
        anew.now = self.now;
        anew.booted = self.now;
        anew.restarted = true;
        anew.line = self.line;
        anew.grip = self.grip;
        anew.log = std::mem::take(&mut self.log);
        anew.wake_at(really.joints);
        anew.motion.rail.slip = really.rail;
        *self = anew;
        self.log.push(Event::Reset);
        self.feel_grip();
    }

    /// Power comes while the arm really stands somewhere: J1 reads what it reads at power-up, J2 and J3 what they are.
    fn wake_at(&mut self, really: magician_motion::JointAngles) {
        let reported = self.arm().joints;
        self.place_at(magician_motion::JointAngles {
            j1: reported.j1,
            ..really
        });
        self.motion.slip = [really.j1 - reported.j1, 0.0, 0.0, 0.0];
    }
}

impl crate::Controller {
    /// Lets something happen to the arm now: a key is pressed, a joint slips, the cable is pulled.
    pub fn inject(&mut self, happening: Happening) {
        self.core.meet(happening);
        self.core.settle();
        self.forget_links();
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
