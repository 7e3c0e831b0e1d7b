//! State of the laser, from the commands sent and the arm's replies.

use std::ops::{BitOr, BitOrAssign, SubAssign};

use magician_protocol::commands::{
    CpLeCmd, EndEffectorLaser, IoDo, IoPwm, PtpPoCmd, PtpPoWithLCmd, SetEndEffectorLaser,
};
use magician_protocol::{Frame, Layout, Readable, Set, Writable};

use crate::burning::{LASER_POWER, LASER_SUPPLY, burns};

/// Set of the ways in which the laser can be lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Channels(u8);

impl Channels {
    /// `SetEndEffectorLaser`.
    pub(super) const BEAM: Self = Self(1);
    /// Power of a path's segment.
    pub(super) const PATH: Self = Self(2);
    /// Level of EIO 2.
    const SUPPLY: Self = Self(4);
    /// Level of EIO 4.
    const POWER: Self = Self(8);
    /// PWM on EIO 4.
    const PULSES: Self = Self(16);
    pub(super) const PINS: Self = Self(4 | 8 | 16);
    pub(super) const ALL: Self = Self(31);

    pub(super) const fn intersects(self, other: Self) -> bool {
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

/// Effect of a command on the laser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LaserEffect {
    pub(super) channels: Channels,
    pub(super) burns: bool,
}

impl LaserEffect {
    /// Effect of a command. `None` if it leaves the laser unchanged. A command that cannot be
    /// decoded counts as burning.
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
            // Either pin may be switched during the move.
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
            // A list that raises no laser pin does not count as switching one off: if in doubt, the
            // laser counts as burning.
            Set::PtpPoCmd(_) | Set::PtpPoWithLCmd(_) if !burns => return None,
            _ => channels,
        };
        Some(Self { channels, burns })
    }
}

/// Knowledge of the laser's state, without the effect of the commands that wait in the queue.
#[derive(Clone, Debug, Default)]
pub(super) struct LaserPicture {
    /// Ways in which commands of this connection lit it.
    lit: Channels,
    /// State of `SetEndEffectorLaser`, as read or set last. `None` if unknown.
    register: Option<bool>,
    /// True if one of the laser's pins was high when they were last read. `None` if unknown.
    pins: Option<bool>,
    /// True if the queue holds commands of other programs. The host cannot read them back from the
    /// arm.
    foreign: bool,
    /// True if this connection may have lit the laser before an apparent reset of the arm.
    before_reset: bool,
}

impl LaserPicture {
    /// Notes a command that is executed immediately, or has finished.
    pub(super) fn set(&mut self, effect: LaserEffect) {
        let LaserEffect { channels, burns } = effect;
        if burns {
            self.lit |= channels;
        } else {
            self.lit -= channels;
        }
        if channels.intersects(Channels::BEAM) {
            self.register = Some(burns);
            if !burns {
                // Switching off also ends the power of a path.
                self.lit -= Channels::PATH;
                self.before_reset = false;
            }
        }
    }

    /// Notes an immediate command that is sent: from now on it may burn.
    pub(super) fn sent(&mut self, effect: LaserEffect) {
        if effect.burns {
            self.lit |= effect.channels;
        }
    }

    /// Processes the reply to a get.
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

    /// Notes that the laser was switched off and its pins are low.
    pub(super) fn darkened(&mut self) {
        self.lit = Channels::default();
        (self.register, self.pins) = (Some(false), Some(false));
        self.before_reset = false;
    }

    /// Discards evidence of darkness, because others may light the laser.
    pub(super) fn forget(&mut self) {
        (self.register, self.pins) = (None, None);
    }

    pub(super) fn reset(&mut self) {
        // The reset may be false: if the clock was misread, a burning laser must not count as off.
        *self = Self {
            before_reset: self.before_reset || self.lit.intersects(Channels::ALL),
            ..Self::default()
        };
    }

    /// True if the laser may burn, false if it is certainly off, `None` if unknown. `waiting` is
    /// true if a command in the queue may light it.
    pub(super) fn state(&self, waiting: bool, laser_pins: bool) -> Option<bool> {
        let of_interest = if laser_pins {
            Channels::ALL
        } else {
            Channels::BEAM | Channels::PATH
        };
        let pins = if laser_pins { self.pins } else { Some(false) };
        if waiting
            || self.lit.intersects(of_interest)
            || self.register == Some(true)
            || pins == Some(true)
        {
            return Some(true);
        }
        // Dark needs proof from both the register and the pins; for burning one sign suffices.
        let dark = self.register == Some(false) && pins == Some(false) && !self.foreign;
        dark.then_some(false)
    }

    /// True if commands of this connection may have lit it in one of these ways.
    pub(super) fn may_be_lit(&self, channels: Channels) -> bool {
        self.lit.intersects(channels) || self.before_reset && channels == Channels::ALL
    }
}
