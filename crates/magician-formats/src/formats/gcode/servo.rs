//! Servo that lifts a pen, and which of its angles mean down.

use magician_host::message;

use super::SourceLine;
use super::block::Block;
use crate::{Diagnostic, Origin};

/// S of M300 from which it is a tone and not an angle. Servos use 30 and 50.
const M300_MIN_TONE: f64 = 100.0;
/// Angle of M300 below which the pen is down, if both angles feed: 30 is down and 50 is up.
const M300_DOWN_ANGLE: f64 = 40.0;

/// State of the servo.
#[derive(Clone, Debug, Default)]
pub(super) struct Servo {
    /// True if M3, M4, M5 and S also move it.
    spindle: bool,
    /// Current S of M3, and true if M3 has switched it on.
    s: f64,
    on: bool,
    angle: Option<f64>,
}

/// Angles used by a program.
#[derive(Clone, Debug, Default)]
pub(super) struct Angles {
    servo: Servo,
    /// Each angle, true if X or Y feeds while it is in force, and the place where it was first set.
    used: Vec<(f64, bool, Origin)>,
    /// True if any is set by a code other than M300.
    other: bool,
}

impl Servo {
    pub(super) fn new(spindle: bool) -> Self {
        Self {
            spindle,
            ..Self::default()
        }
    }

    /// Follows a line. Returns the angle if the line moves the servo.
    pub(super) fn follow(&mut self, block: &Block) -> Option<f64> {
        let m = |number| block.has(b'M', number);
        let s = block.number(b'S');
        let given = if m(300) {
            s.filter(|angle| *angle < M300_MIN_TONE)
        } else if m(280) {
            s
        } else if self.spindle {
            self.turn(block)
        } else {
            None
        };
        if given.is_some() {
            self.angle = given;
        }
        given
    }

    /// Follows a servo on the spindle pin, where M5 means S0.
    fn turn(&mut self, block: &Block) -> Option<f64> {
        let m = |number| block.has(b'M', number);
        let s = block.power();
        self.s = s.unwrap_or(self.s);
        let switched = m(3) || m(4) || m(5);
        if switched {
            self.on = !m(5);
        }
        let moves = switched || (self.on && s.is_some());
        moves.then_some(if self.on { self.s } else { 0.0 })
    }
}

impl Angles {
    pub(super) fn new(spindle: bool) -> Self {
        Self {
            servo: Servo::new(spindle),
            ..Self::default()
        }
    }

    /// Examines a line; `feeds` is true if it feeds X or Y.
    pub(super) fn examine(&mut self, block: &Block, feeds: bool, line: &SourceLine<'_>) {
        if let Some(angle) = self.servo.follow(block) {
            self.other |= !block.has(b'M', 300);
            if !self.used.iter().any(|(known, ..)| *known == angle) {
                self.used.push((angle, false, line.origin(&block.range)));
            }
        }
        if let Some(angle) = self.servo.angle.filter(|_| feeds) {
            let mut used = self.used.iter_mut();
            if let Some(used) = used.find(|(known, ..)| *known == angle) {
                used.1 = true;
            }
        }
    }

    /// Returns the angles that mean down: those in force while X or Y feeds.
    pub(super) fn down(&self) -> Result<Vec<f64>, Diagnostic> {
        let all = |(_, feeds, _): &(f64, bool, Origin)| *feeds;
        let angles = self.used.iter().map(|(angle, ..)| *angle);
        match &self.used[..] {
            [_, _, ..] if !self.used.iter().all(all) => {
                let down = self.used.iter().filter(|used| all(used));
                Ok(down.map(|(angle, ..)| *angle).collect())
            }
            [_, (other, _, origin), ..] if self.other => {
                let (first, ..) = self.used[0];
                let message = message!(
                    "X and Y are fed with the servo at S{first} and at S{other}: it is unclear \
                        which of them is down",
                    first,
                    other
                );
                let help = message!("export the file with G0 for the moves between lines");
                Err(Diagnostic::new(*origin, message).help(help))
            }
            [_, _, ..] => Ok(angles.filter(|angle| *angle < M300_DOWN_ANGLE).collect()),
            one => Ok(one
                .iter()
                .filter(|used| all(used))
                .map(|(angle, ..)| *angle)
                .collect()),
        }
    }
}
