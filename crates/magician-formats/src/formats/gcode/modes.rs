//! Modal state that a program can read through predefined parameters (`#5420`, `#<_feed>`).

use super::arc::Plane;
use super::block::Block;
use super::motion::AXES;
use super::offsets::{Offsets, Setting};

/// Length of an inch, mm.
pub(super) const MM_PER_INCH: f64 = 25.4;
/// G codes of the motion group in tenths, as `#<_motion_mode>` returns them.
const MOTIONS: [u32; 14] = [
    0, 10, 20, 30, 50, 51, 800, 730, 810, 820, 830, 850, 860, 890,
];

/// State of a program between two lines.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub(super) unit: f64,
    pub(super) relative: bool,
    absolute_centres: bool,
    plane: Plane,
    /// Modal motion, in tenths of its G code.
    motion: u32,
    pub(super) offsets: Offsets,
    /// Position of the tool assumed by the program, in machine coordinates.
    pub(super) at: [Option<f64>; 3],
    /// True if the machine's origin is unknown.
    placed: bool,
    /// Current F and S.
    feed: f64,
    speed: f64,
    /// 3 or 4 after M3 or M4.
    spindle: Option<u32>,
    mist: bool,
    flood: bool,
}

impl Modes {
    pub(super) fn new(begins_at: Option<[f64; 3]>, placed: bool) -> Self {
        Self {
            unit: 1.0,
            relative: false,
            absolute_centres: false,
            plane: Plane::default(),
            motion: 0,
            offsets: Offsets::default(),
            at: begins_at.map_or([None; 3], |at| at.map(Some)),
            placed,
            feed: 0.0,
            speed: 0.0,
            spindle: None,
            mist: false,
            flood: false,
        }
    }

    /// True if motions draw.
    pub(super) fn feeds(&self) -> bool {
        matches!(self.motion, 10 | 20 | 30 | 50 | 51)
    }

    /// True in a drilling cycle.
    pub(super) fn drills(&self) -> bool {
        self.motion > 51 && self.motion != 800
    }

    /// Updates the state by a line.
    pub(super) fn follow(&mut self, block: &Block) {
        if block.is_foreign() {
            return;
        }
        let cycle_ends = block.has(b'G', 80);
        for code in &block.codes {
            match (code.letter, code.tenths) {
                (b'G', 800) => {}
                (b'G', motion) if MOTIONS.contains(&motion) => self.motion = motion,
                (b'G', 170) => self.plane = Plane::Xy,
                (b'G', 180) => self.plane = Plane::Zx,
                (b'G', 190) => self.plane = Plane::Yz,
                (b'G', 200) => self.unit = MM_PER_INCH,
                (b'G', 210) => self.unit = 1.0,
                (b'G', 900) => self.relative = false,
                (b'G', 910) => self.relative = true,
                (b'G', 901) => self.absolute_centres = true,
                (b'G', 911) => self.absolute_centres = false,
                (b'G', tenths) => {
                    if let Some(system) = Offsets::system_of(tenths) {
                        self.offsets.select(system);
                    }
                }
                (_, 30 | 40) => self.spindle = Some(code.tenths / 10),
                (_, 50) => self.spindle = None,
                (_, 70) => self.mist = true,
                (_, 80) => self.flood = true,
                (_, 90) => (self.mist, self.flood) = (false, false),
                _ => {}
            }
        }
        if cycle_ends && !(block.codes.iter()).any(|code| is_motion(code.letter, code.tenths)) {
            self.motion = 800;
        }
        self.feed = block.number(b'F').unwrap_or(self.feed);
        self.speed = block.power().unwrap_or(self.speed);
        self.go(block);
    }

    /// Updates position and origin by a line.
    fn go(&mut self, block: &Block) {
        // Fast path: most lines contain only coordinates.
        if !block.has_g() {
            return self.arrive(block, false);
        }
        let has = |tenths: u32| {
            let mut codes = block.codes.iter();
            codes.any(|code| code.letter == b'G' && code.tenths == tenths)
        };
        if has(280) || has(282) || has(300) {
            for (at, letter) in self.at.iter_mut().zip(AXES) {
                if block.number(letter).is_some() || !block.has_any(&AXES) {
                    *at = None;
                }
            }
        } else if has(920) {
            let bare = !block.has_any(b"XYZE");
            for (axis, letter) in AXES.into_iter().enumerate() {
                let number = block.number(letter).or(bare.then_some(0.0));
                if let (Some(number), Some(at)) = (number, self.at[axis]) {
                    self.offsets.call(axis, at, number * self.unit);
                }
            }
        } else if let Some(tenths) = [921, 922, 923].into_iter().find(|tenths| has(*tenths)) {
            self.offsets.reset(tenths);
        } else if has(520) {
            for (axis, letter) in AXES.into_iter().enumerate() {
                if let Some(number) = block.number(letter) {
                    self.offsets.shift(axis, number * self.unit);
                }
            }
        } else if has(100) {
            let setting = Setting::of(block).filter(|setting| *setting != Setting::Tool);
            if let Some(setting) = setting {
                // Errors are reported when the machine executes the line.
                let _ = self.offsets.set(setting, block, self.unit, self.at);
            }
        } else if !(has(40) || has(281) || has(301)) {
            self.arrive(block, has(530));
        }
    }

    fn arrive(&mut self, block: &Block, machine: bool) {
        let zero = self.offsets.zero();
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(number) = block.number(letter).map(|number| number * self.unit) else {
                continue;
            };
            self.at[axis] = if machine {
                Some(number).filter(|_| !self.placed)
            } else if axis == 2 && self.drills() {
                // After the cycle the tool is up again, at R or at its initial height.
                None
            } else if self.relative {
                self.at[axis].map(|at| at + number)
            } else {
                Some(number + zero[axis])
            };
        }
    }

    /// Returns the position along an axis in current coordinates and unit.
    pub(super) fn place(&self, axis: usize) -> Option<f64> {
        let zero = self.offsets.zero().get(axis).copied()?;
        Some((self.at.get(axis).copied()?? - zero) / self.unit)
    }

    /// Returns the position along an axis in machine coordinates and the current unit.
    pub(super) fn machine_place(&self, axis: usize) -> Option<f64> {
        Some(self.at.get(axis).copied()?? / self.unit)
    }

    /// Returns a predefined named parameter.
    pub(super) fn named(&self, name: &str) -> Option<f64> {
        let is = |holds: bool| f64::from(u8::from(holds));
        Some(match name {
            "_metric" => is(self.unit == 1.0),
            "_imperial" => is(self.unit != 1.0),
            "_absolute" => is(!self.relative),
            "_incremental" => is(self.relative),
            "_ijk_absolute_mode" => is(self.absolute_centres),
            "_inverse_time" | "_units_per_rev" | "_tool_offset" => 0.0,
            "_lathe_diameter_mode" | "_lathe_radius_mode" | "_spindle_css_mode" => 0.0,
            "_units_per_minute" | "_spindle_rpm_mode" | "_retract_r_plane" => 1.0,
            "_retract_old_z" | "_feed_hold" | "_adaptive_feed" => 0.0,
            "_speed_override" | "_feed_override" => 1.0,
            "_task" | "_remap_level" => 0.0,
            "_ccomp" => 400.0,
            "_plane" => match self.plane {
                Plane::Xy => 170.0,
                Plane::Zx => 180.0,
                Plane::Yz => 190.0,
            },
            "_motion_mode" => f64::from(self.motion),
            "_coord_system" => match self.offsets.system() as f64 {
                system if system <= 6.0 => 530.0 + 10.0 * system,
                system => 584.0 + system,
            },
            "_feed" => self.feed,
            "_rpm" => self.speed,
            "_spindle_on" => is(self.spindle.is_some()),
            "_spindle_cw" => is(self.spindle == Some(3)),
            "_mist" => is(self.mist),
            "_flood" => is(self.flood),
            _ => return None,
        })
    }
}

fn is_motion(letter: u8, tenths: u32) -> bool {
    letter == b'G' && tenths != 800 && MOTIONS.contains(&tenths)
}
