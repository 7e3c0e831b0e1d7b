//! What a program turns out to be when all of it has been looked at.

use super::block::Block;
use super::options::{Dialect, GcodeOptions};

/// What the whole program tells about each of its lines.
#[derive(Clone, Debug, Default)]
pub(super) struct Survey {
    /// M3, M4 or M5 switches something.
    pub(super) switches: bool,
    lights: bool,
    fan: bool,
    /// The greatest power S.
    pub(super) greatest: Option<f64>,
    /// E words: a program of a printer, whose fan is a fan.
    pub(super) extrudes: bool,
    /// M300 lifts a pen.
    pub(super) lifts: bool,
    /// The first height that it goes to, mm.
    pub(super) first_z: Option<f64>,
    /// Units and distances as the program has set them by then.
    inches: bool,
    relative: bool,
}

/// The servo of a pen stands at 30 or 50 degrees; higher numbers are a tone's.
pub(super) const HIGHEST_SERVO: f64 = 100.0;

impl Survey {
    /// Looks at all lines up to the end of the program. What is wrong with them is found later.
    pub(super) fn of<'t>(lines: impl Iterator<Item = &'t str>) -> Self {
        let mut survey = Self::default();
        let mut block = Block::default();
        for line in lines {
            if block.fill(line).is_err() {
                break;
            }
            survey.look(&block);
            if block.has(b'M', 2) || block.has(b'M', 30) {
                break;
            }
        }
        survey
    }

    fn look(&mut self, block: &Block) {
        if block.is_foreign() || block.is_empty() {
            return;
        }
        self.lights |= block.has(b'M', 3) || block.has(b'M', 4);
        self.switches |= self.lights || block.has(b'M', 5);
        self.fan |= block.has(b'M', 106);
        self.lifts |= block.has(b'M', 300)
            && block
                .number(b'S')
                .is_some_and(|angle| angle < HIGHEST_SERVO);
        self.extrudes |= block.number(b'E').is_some();
        let fan = block.number(b'S').filter(|_| block.has(b'M', 106));
        if let Some(power) = block.power().or(fan) {
            self.greatest = Some(self.greatest.map_or(power, |most| most.max(power)));
        }
        self.inches = (self.inches || block.has(b'G', 20)) && !block.has(b'G', 21);
        self.relative = (self.relative || block.has(b'G', 91)) && !block.has(b'G', 90);
        let moves = !(self.relative || block.has(b'G', 92) || block.has(b'G', 28));
        if let Some(z) = block
            .number(b'Z')
            .filter(|_| moves && self.first_z.is_none())
        {
            self.first_z = Some(if self.inches { z * 25.4 } else { z });
        }
    }

    /// Whether a laser draws.
    pub(super) fn is_laser(&self, options: &GcodeOptions) -> bool {
        match options.dialect {
            Dialect::Pen => false,
            Dialect::Laser => true,
            Dialect::Detect => {
                let power = self.greatest.is_some() && !self.extrudes;
                !self.lifts && (self.lights || self.fan_lights() || power)
            }
        }
    }

    /// Whether M106 is the laser.
    pub(super) fn fan_lights(&self) -> bool {
        self.fan && !self.extrudes
    }
}
