//! What a program turns out to be when all of it has been looked at.

use super::block::Block;
use super::mill::Mill;
use super::options::{Dialect, GcodeOptions};
use super::power::Powers;
use super::servo::Angles;
use super::{Line, is_left_out};

/// G codes whose axis words are no places in the program's own coordinates.
const NOT_MOVED: [u32; 6] = [10, 28, 30, 52, 53, 92];

/// What a program is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Pen,
    Laser,
    /// A pen that a servo lifts.
    Servo,
    /// A mill: drawn as a pen's.
    Mill,
}

/// What the whole program tells about each of its lines.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// M3, M4 or M5 switches something.
    pub(super) switches: bool,
    lights: bool,
    fan: bool,
    pub(super) powers: Powers,
    pub(super) mill: Mill,
    pub(super) angles: Angles,
    /// E words: a program of a printer, whose fan is a fan.
    extrudes: bool,
    /// M300 or M280 moves a servo.
    m300: bool,
    m280: bool,
    /// The highest that it says it goes to, mm.
    pub(super) highest_z: Option<f64>,
    /// Units and distances as the program has set them by then, and whether motions feed.
    inches: bool,
    relative: bool,
    feeds: bool,
}

impl Survey {
    /// Looks at all lines up to the end of the program. What is wrong with them is found later.
    pub(super) fn of<'t>(lines: impl Iterator<Item = Line<'t>>, options: &GcodeOptions) -> Self {
        let mut survey = Self {
            switches: false,
            lights: false,
            fan: false,
            powers: Powers::default(),
            mill: Mill::default(),
            angles: Angles::new(options.dialect == Dialect::Servo),
            extrudes: false,
            m300: false,
            m280: false,
            highest_z: None,
            inches: false,
            relative: false,
            feeds: false,
        };
        let mut block = Block::default();
        for line in lines {
            survey.powers.read(&line);
            survey.mill.read(line.text);
            if is_left_out(line.text) {
                continue;
            }
            if block.fill(line.text).is_err() {
                break;
            }
            survey.look(&block, &line);
            if block.has(b'M', 2) || block.has(b'M', 30) {
                break;
            }
        }
        survey
    }

    fn look(&mut self, block: &Block, line: &Line<'_>) {
        if block.is_foreign() || block.is_empty() {
            return;
        }
        self.lights |= block.has(b'M', 3) || block.has(b'M', 4);
        self.switches |= self.lights || block.has(b'M', 5);
        self.fan |= block.has(b'M', 106);
        self.extrudes |= block.number(b'E').is_some();
        self.powers.look(block, line);
        self.inches = (self.inches || block.has(b'G', 20)) && !block.has(b'G', 21);
        self.relative = (self.relative || block.has(b'G', 91)) && !block.has(b'G', 90);
        for code in block.codes.iter().filter(|code| code.letter == b'G') {
            match code.tenths {
                0 | 800 => self.feeds = false,
                10 | 20 | 30 => self.feeds = true,
                _ => {}
            }
        }
        let places = NOT_MOVED.iter().any(|code| block.has(b'G', *code));
        let marks = self.feeds && !places && block.has_any(b"XYIJ");
        self.mill.look(block, line, (self.relative, places), marks);
        self.angles.look(block, marks, line);
        self.m300 |= block.has(b'M', 300) && block.number(b'S').is_some_and(|s| s < 100.0);
        self.m280 |= block.has(b'M', 280) && block.number(b'S').is_some();
        let moves = !(self.relative || places);
        if let Some(z) = block.number(b'Z').filter(|_| moves) {
            let z = if self.inches { z * 25.4 } else { z };
            self.highest_z = Some(self.highest_z.map_or(z, |highest| highest.max(z)));
        }
    }

    /// What it is for.
    pub(super) fn kind(&self, options: &GcodeOptions) -> Kind {
        // A printer moves the probe of its bed by M280, and a laser beeps by M300.
        let m280 = self.m280 && self.highest_z.is_none() && !self.extrudes;
        let servo = (self.m300 || m280) && !self.mill.has_laser();
        match options.dialect {
            Dialect::Laser => Kind::Laser,
            Dialect::Servo => Kind::Servo,
            _ if servo => Kind::Servo,
            Dialect::Pen => Kind::Pen,
            Dialect::Detect => {
                let power = self.powers.greatest.is_some() && !self.extrudes;
                match self.lights || self.fan_lights() || power {
                    true if self.mill.sign().is_some() => Kind::Mill,
                    true => Kind::Laser,
                    false => Kind::Pen,
                }
            }
        }
    }

    /// Whether M106 is the laser: not beside M3 or M4, where it blows air.
    pub(super) fn fan_lights(&self) -> bool {
        self.fan && !self.extrudes && !self.lights
    }
}
