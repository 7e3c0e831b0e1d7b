//! What a program turns out to be when all of it has been looked at.

use super::SourceLine;
use super::block::Block;
use super::interpreter::{Interpreter, LineOutcome};
use super::mill::Mill;
use super::modes::Modes;
use super::power::Powers;
use super::servo::Angles;
use super::{Dialect, GcodeOptions};

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
    /// A pause (G4) whose P has a fraction, or a sign of a controller whose P counts seconds.
    seconds: bool,
    /// The highest that it says it goes to, mm.
    pub(super) highest_z: Option<f64>,
}

impl Survey {
    /// Looks at all lines as they are carried out. What is wrong with them is found later.
    pub(super) fn of(mut interpreter: Interpreter<'_, '_>, options: &GcodeOptions) -> Self {
        let mut survey = Self {
            switches: false,
            lights: false,
            fan: false,
            powers: Powers::default(),
            mill: Mill::new(options.burns),
            angles: Angles::new(options.dialect == Dialect::Servo),
            extrudes: false,
            m300: false,
            m280: false,
            seconds: false,
            highest_z: None,
        };
        let mut block = Block::default();
        while let Ok(Some((line, stepped))) = interpreter.step(&mut block) {
            survey.powers.read(&line);
            survey.mill.read(line.text);
            let setting = line.text.trim_start().starts_with('$');
            survey.seconds |= setting || line.text.contains("LightBurn");
            if stepped == LineOutcome::Words {
                survey.look(&block, &line, interpreter.modes());
            }
        }
        survey
    }

    /// Looks at a line; `modes` are those that it has set.
    fn look(&mut self, block: &Block, line: &SourceLine<'_>, modes: &Modes) {
        if block.is_foreign() || block.is_empty() {
            return;
        }
        self.lights |= block.has(b'M', 3) || block.has(b'M', 4);
        self.switches |= self.lights || block.has(b'M', 5);
        self.fan |= block.has(b'M', 106);
        self.extrudes |= block.number(b'E').is_some();
        let pause = block.number(b'P').filter(|_| block.has(b'G', 4));
        self.seconds |= pause.is_some_and(|pause| pause.fract() != 0.0);
        self.powers.look(block, line);
        let places = NOT_MOVED.iter().any(|code| block.has(b'G', *code));
        let marks = modes.feeds() && !places && block.has_any(b"XYIJ");
        self.mill.look(block, line, modes, (places, marks));
        self.angles.look(block, marks, line);
        self.m300 |= block.has(b'M', 300) && block.number(b'S').is_some_and(|s| s < 100.0);
        self.m280 |= block.has(b'M', 280) && block.number(b'S').is_some();
        let moves = block.number(b'Z').is_some() && !(modes.relative || places);
        // A drill is lifted to R.
        let lifted = block
            .number(b'R')
            .map(|r| r * modes.unit + modes.offsets.zero()[2]);
        let z = if modes.drills() { lifted } else { modes.at[2] };
        if let Some(z) = z.filter(|_| moves) {
            self.highest_z = Some(self.highest_z.map_or(z, |highest| highest.max(z)));
        }
    }

    /// True if P of a pause counts seconds, as GRBL and LinuxCNC have it, and not milliseconds.
    pub(super) fn pauses_in_seconds(&self) -> bool {
        self.seconds
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
                if !(self.lights || self.fan_lights() || power) {
                    Kind::Pen
                } else if self.mill.sign().is_some() {
                    Kind::Mill
                } else {
                    Kind::Laser
                }
            }
        }
    }

    /// Whether M106 is the laser: not beside M3 or M4, where it blows air.
    pub(super) fn fan_lights(&self) -> bool {
        self.fan && !self.extrudes && !self.lights
    }
}
