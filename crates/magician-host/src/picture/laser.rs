//! The laser, by the commands that were sent and by what the arm says of it.

use std::ops::{BitOr, BitOrAssign, SubAssign};

use magician_protocol::commands::{
    CpLeCmd, EndEffectorLaser, IoDo, IoPwm, PtpPoCmd, PtpPoWithLCmd, SetEndEffectorLaser,
};
use magician_protocol::{Frame, Layout, Readable, Set, Writable};

use crate::burning::{LASER_POWER, LASER_SUPPLY, burns};

/// What can light the laser, as a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Channels(u8);

impl Channels {
    /// `SetEndEffectorLaser`.
    pub(super) const BEAM: Self = Self(1);
    /// The power of a path's segment.
    pub(super) const PATH: Self = Self(2);
    /// The level of EIO 2.
    const SUPPLY: Self = Self(4);
    /// The level of EIO 4.
    const POWER: Self = Self(8);
    /// Pulses on EIO 4.
    const PULSES: Self = Self(16);
    pub(super) const PINS: Self = Self(4 | 8 | 16);
    pub(super) const ALL: Self = Self(31);

    pub(super) const fn meet(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl BitOr for Channels {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Channels {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl SubAssign for Channels {
    fn sub_assign(&mut self, other: Self) {
        self.0 &= !other.0;
    }
}

/// What a command does to the laser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Light {
    pub(super) channels: Channels,
    pub(super) burns: bool,
}

impl Light {
    /// `None` for a command that leaves the laser as it is. One that cannot be read counts as one that burns.
    pub(super) fn of(request: &Frame<'_>) -> Option<Self> {
        let id = request.id();
        let channels = if id == SetEndEffectorLaser::ROW.id {
            Channels::BEAM
        } else if id == CpLeCmd::ROW.id {
            Channels::PATH
        } else if id == <IoDo as Writable>::ROW.id {
            Channels::SUPPLY | Channels::POWER
        } else if id == <IoPwm as Writable>::ROW.id {
            Channels::PULSES
        } else if id == PtpPoCmd::ROW.id || id == PtpPoWithLCmd::ROW.id {
            // Along its way, whichever of them.
            Channels::SUPPLY | Channels::POWER
        } else {
            return None;
        };
        let Ok(command) = Set::decode(id, request.params()) else {
            let burns = true;
            return Some(Self { channels, burns });
        };
        let burns = burns(&command, true);
        let channels = match command {
            Set::IoDo(output) => match output.address {
                LASER_SUPPLY => Channels::SUPPLY,
                LASER_POWER => Channels::POWER,
                _ => return None,
            },
            Set::IoPwm(output) if output.address != LASER_POWER => return None,
            // One of its outputs may be raised after it was lowered.
            Set::PtpPoCmd(_) | Set::PtpPoWithLCmd(_) if !burns => return None,
            _ => channels,
        };
        Some(Self { channels, burns })
    }
}

/// The laser without the commands that wait in the queue.
#[derive(Clone, Debug, Default)]
pub(super) struct LaserPicture {
    /// Lit by commands of this connection.
    lit: Channels,
    /// What the arm says of `SetEndEffectorLaser`, or was told since; `None` if not known.
    register: Option<bool>,
    /// Whether one of the laser's pins is high, as they were read last.
    pins: Option<bool>,
    /// Commands of other programs are in the queue, which cannot be read there.
    foreign: bool,
    /// It may have been lit over this connection before the arm seemed to be reset.
    before_reset: bool,
}

impl LaserPicture {
    /// This was sent to be done at once, or is done.
    pub(super) fn set(&mut self, light: Light) {
        let Light { channels, burns } = light;
        if burns {
            self.lit |= channels;
        } else {
            self.lit -= channels;
        }
        if channels.meet(Channels::BEAM) {
            self.register = Some(burns);
            if !burns {
                // Off ends the power of a path, too.
                self.lit -= Channels::PATH;
                self.before_reset = false;
            }
        }
    }

    /// This goes out to be done at once: from here on it may burn.
    pub(super) fn sent(&mut self, light: Light) {
        if light.burns {
            self.lit |= light.channels;
        }
    }

    /// The arm has answered a get.
    pub(super) fn read(&mut self, reply: &Frame<'_>) {
        if reply.id() != <EndEffectorLaser as Readable>::ROW.id {
            return;
        }
        if let Ok(laser) = EndEffectorLaser::decode(reply.params()) {
            let on = laser.is_ctrl_enabled.is_on() && laser.is_on.is_on();
            self.register = Some(on);
            if !on {
                self.lit -= Channels::BEAM;
            }
        }
    }

    pub(super) fn note_pins(&mut self, high: Option<bool>) {
        self.pins = high;
    }

    pub(super) const fn knows_pins(&self) -> bool {
        self.pins.is_some()
    }

    pub(super) fn note_foreign(&mut self, foreign: bool) {
        self.foreign = foreign;
    }

    /// It was switched off, and its pins are low.
    pub(super) fn darkened(&mut self) {
        self.lit = Channels::default();
        (self.register, self.pins) = (Some(false), Some(false));
        self.before_reset = false;
    }

    /// What was seen dark may be lit by others.
    pub(super) fn forget(&mut self) {
        (self.register, self.pins) = (None, None);
    }

    pub(super) fn reset(&mut self) {
        *self = Self {
            before_reset: self.before_reset || self.lit.meet(Channels::ALL),
            ..Self::default()
        };
    }

    /// Whether it may burn; `None` if not known. `waiting`: a command in the queue may light it.
    pub(super) fn told(&self, waiting: bool, laser_pins: bool) -> Option<bool> {
        let of_interest = if laser_pins {
            Channels::ALL
        } else {
            Channels::BEAM | Channels::PATH
        };
        let pins = if laser_pins { self.pins } else { Some(false) };
        if waiting
            || self.lit.meet(of_interest)
            || self.register == Some(true)
            || pins == Some(true)
        {
            return Some(true);
        }
        let dark = self.register == Some(false) && pins == Some(false) && !self.foreign;
        dark.then_some(false)
    }

    /// Whether commands of this connection may have lit it by one of these.
    pub(super) fn may_be_lit(&self, channels: Channels) -> bool {
        self.lit.meet(channels) || self.before_reset && channels == Channels::ALL
    }
}
