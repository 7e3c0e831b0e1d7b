//! The laser: permission to light it, its state, and switching it off.

use magician_protocol::commands::{
    EndEffectorLaser, GetIoDo, GetIoMultiplexing, GetIoPwm, IoDo, IoMultiplexing, IoPwm,
};
use magician_protocol::{Flag, Frame, IoFunction, Row, Set};

use super::{Arm, Shared};
use crate::build;
use crate::connection::Request;
use crate::{Action, Error, ErrorCode, ErrorKind, Result};
use magician_host::picture::QueueLook;
use magician_host::{
    LASER_POWER, LASER_SUPPLY, burns, check_power, frame_burns, frame_releases_queue,
};

/// The laser's pins.
const PINS: [u8; 2] = [LASER_SUPPLY, LASER_POWER];

/// Permission to light it.
impl Arm {
    /// A handle of the same connection whose calls may light the laser: see
    /// [`Options::allow_laser`](super::Options::allow_laser). Ask a person before.
    #[must_use]
    pub fn allowing_laser(&self) -> Self {
        Self {
            allows_laser: true,
            ..self.clone()
        }
    }

    /// Whether it is a virtual arm, where nothing burns: one in this process, or by the word of
    /// [`Options::virtual_arm`](super::Options::virtual_arm). Any other counts as real: it is impossible to tell them apart.
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        self.inner.in_process || self.inner.options.virtual_arm
    }

    /// Whether it is a virtual arm in this process, which ends with it.
    #[must_use]
    pub fn is_in_process(&self) -> bool {
        self.inner.in_process
    }

    /// Number that tells a virtual arm in this process from all others that this process has had; `None` for any other arm.
    #[must_use]
    pub fn virtual_number(&self) -> Option<u64> {
        #[cfg(feature = "sim")]
        return { self.inner.virtual_arm.as_ref() }.map(crate::VirtualArm::number);
        #[cfg(not(feature = "sim"))]
        None
    }

    /// Whether calls of this handle may light the laser, or there is none.
    #[must_use]
    pub fn may_burn(&self) -> bool {
        self.allows_laser || self.is_virtual()
    }

    /// Whether this command may light the laser of this arm: [`burns`](fn@crate::burns) for the pins of
    /// [`Options::laser_pins`](super::Options::laser_pins).
    #[must_use]
    pub fn burns(&self, command: &Set) -> bool {
        burns(command, self.inner.options.laser_pins)
    }

    /// Refuses commands of which one would start a jog that nothing holds, would burn where that is not allowed, or has a duty or a
    /// laser power out of its range; nothing is sent.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`], with [`ErrorCode::LaserNotAllowed`] or [`ErrorCode::Guarded`] for what is not allowed.
    pub fn permit<'a>(&self, commands: impl IntoIterator<Item = &'a Set>) -> Result<()> {
        let may_burn = self.may_burn();
        commands.into_iter().try_for_each(|command| {
            check_power(command)?;
            self.permit_command(command)?;
            if !may_burn && self.burns(command) {
                Err(self.refusal().with_command(command.row().set_name))
            } else {
                Ok(())
            }
        })
    }

    /// The same for a frame: the net below all doors.
    pub(super) fn permit_frame(&self, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let may = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        if may
            && (ctrl.write() || ctrl.queued())
            && let Ok(command) = Set::decode(frame.id(), frame.params())
        {
            check_power(&command)?;
        }
        if !self.may_burn() && frame_burns(frame, self.inner.options.laser_pins) {
            Err(self.refusal())
        } else {
            Ok(())
        }
    }

    /// Refuses to let a queue run in which commands of another program wait, where the laser may not burn: it is
    /// impossible to read
    /// them there.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] with [`ErrorCode::LaserNotAllowed`], else as [`get`](Self::get).
    pub async fn permit_queue(&self) -> Result<()> {
        if self.may_burn() {
            return Ok(());
        }
        match self.foreign_commands(&self.known().look_at_queue().await?) {
            0 => Ok(()),
            count => {
                let commands = if count == 1 { "command" } else { "commands" };
                let name = self.name();
                Err(Error::burning(format!(
                    "{count} {commands} in the queue of the arm at {name} that this program did not put there could \
                     light its laser; nothing was sent"
                )))
            }
        }
    }

    /// As [`permit_queue`](Self::permit_queue), for a frame that lets the queue run.
    pub(super) async fn permit_release(&self, frame: &Frame<'_>) -> Result<()> {
        if frame_releases_queue(frame) {
            self.permit_queue().await
        } else {
            Ok(())
        }
    }

    fn refusal(&self) -> Error {
        let name = self.name();
        Error::burning(format!(
            "this lights the laser of the arm at {name}; nothing was sent"
        ))
    }

    /// How many commands wait in the queue that this connection did not put there.
    pub(super) fn foreign_commands(&self, look: &QueueLook) -> u32 {
        let waiting = look.waiting();
        let picture = self.picture();
        let running = picture.motion().started() == Some(true);
        let ours = picture.own().waiting(look.current, running);
        if ours >= u64::from(waiting) {
            0
        } else {
            waiting
        }
    }
}

/// Whether it burns.
impl Arm {
    /// Whether the laser is on, as far as can be told: while commands of this connection that light it may be under way, and
    /// where the arm says so of the laser or of its pins. `None` where the arm does not say, and while commands of another
    /// program are in the queue: they may burn, and cannot be read there.
    ///
    /// # Errors
    /// As [`get`](Self::get), but for answers that some arms do not give.
    pub async fn laser(&self) -> Result<Option<bool>> {
        let told = self.laser_told().await?;
        if told != Some(false) {
            return Ok(told);
        }
        let foreign = self.foreign_commands(&self.known().look_at_queue().await?) > 0;
        self.picture().note_foreign_commands(foreign);
        Ok(told.filter(|_| !foreign))
    }

    /// The same without a look at the queue.
    pub(super) async fn laser_told(&self) -> Result<Option<bool>> {
        if self.may_have_lit() && self.moving() {
            return Ok(Some(true));
        }
        let told = answered(self.known().setting::<EndEffectorLaser>().await)?;
        let told = told.map(|laser| laser.is_ctrl_enabled.is_on() && laser.is_on.is_on());
        if told == Some(true) || !self.inner.options.laser_pins {
            return Ok(told);
        }
        Ok(match self.read_laser_pins().await? {
            Some(false) => told,
            high => high,
        })
    }

    /// Reads the laser's pins if their levels are not known: a laser that is on leaves them unread.
    pub(super) async fn learn_laser_pins(&self) -> Result<()> {
        let unknown = !self.picture().knows_laser_pins();
        if unknown && self.inner.options.laser_pins {
            self.read_laser_pins().await?;
        }
        Ok(())
    }

    async fn read_laser_pins(&self) -> Result<Option<bool>> {
        let high = self.laser_pin_is_high().await?;
        self.picture().note_laser_pins(high);
        Ok(high)
    }

    /// Whether one of the laser's pins is an output and high.
    async fn laser_pin_is_high(&self) -> Result<Option<bool>> {
        let mut state = Some(false);
        for address in PINS {
            match self.pin_is_high(address).await? {
                Some(true) => return Ok(Some(true)),
                Some(false) => {}
                None => state = None,
            }
        }
        Ok(state)
    }

    /// True if commands of this connection may have lit the laser.
    fn may_have_lit(&self) -> bool {
        self.picture().may_be_lit()
    }

    /// Whether this pin is an output and high.
    async fn pin_is_high(&self, address: u8) -> Result<Option<bool>> {
        let high = match self.function_of(address).await? {
            None => None,
            Some(IoFunction::DigitalOutput) => {
                let query = GetIoDo {
                    address: Some(address),
                };
                answered(self.get_with::<IoDo>(&query).await)?.map(|pin| pin.level.is_on())
            }
            Some(IoFunction::Pwm) => {
                let query = GetIoPwm {
                    address: Some(address),
                };
                answered(self.get_with::<IoPwm>(&query).await)?.map(|pin| pin.duty_cycle > 0.0)
            }
            Some(_) => Some(false),
        };
        Ok(high)
    }

    async fn function_of(&self, address: u8) -> Result<Option<IoFunction>> {
        let query = GetIoMultiplexing {
            address: Some(address),
        };
        let read = answered(self.known().setting_with::<IoMultiplexing>(&query).await)?;
        Ok(read.map(|read| read.multiplex))
    }

    /// Refuses to go on while the laser is on: whatever moves then would burn along its way.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] when it is on, else as [`laser`](Self::laser).
    pub async fn check_dark(&self) -> Result<()> {
        match self.laser_told().await? {
            Some(true) => Err(Error::new(
                ErrorCode::LaserOn,
                "the laser is on, and the arm would burn along its path; nothing was sent",
            )
            .remedy(Action::LaserOff, "switches it off")),
            _ => Ok(()),
        }
    }
}

/// How it is put out.
impl Arm {
    /// Switches the laser off at once, and lowers its pins where they are outputs.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub async fn darken(&self) -> Result<()> {
        self.set_any(&build::laser(false)).await?;
        if self.inner.options.laser_pins {
            for address in PINS {
                match self.function_of(address).await? {
                    Some(IoFunction::DigitalOutput) => {
                        let level = Flag::OFF;
                        self.set(&IoDo { address, level }).await?;
                    }
                    Some(IoFunction::Pwm) => {
                        self.set_any(&build::pwm(address, FREQUENCY, 0.0)).await?;
                    }
                    _ => {}
                }
            }
        }
        self.picture().darkened();
        Ok(())
    }

    /// As [`darken`](Self::darken), if this connection may have lit the laser and nothing of it is under way any more.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub async fn darken_after(&self) -> Result<()> {
        if self.may_have_lit() && !self.moving() {
            self.darken().await
        } else {
            Ok(())
        }
    }
}

/// Any frequency that the arm takes.
const FREQUENCY: f32 = 1000.0;

impl Shared {
    /// What has to be said besides to put a laser out whose pins were raised over this connection.
    pub(super) fn lowered_pins(&self) -> Vec<Request> {
        if self.picture().pins_may_be_high() {
            lowered_pins()
        } else {
            Vec::new()
        }
    }
}

/// The requests that lower the laser's pins, whatever they are at present.
fn lowered_pins() -> Vec<Request> {
    let level = Flag::OFF;
    let pulses = IoPwm {
        address: LASER_POWER,
        frequency: FREQUENCY,
        duty_cycle: 0.0,
    };
    let levels = PINS.map(|address| Request::set(&IoDo { address, level }));
    let requests = levels.into_iter().chain([Request::set(&pulses)]);
    let stop = |request: Request| request.priority(crate::connection::Priority::Stop);
    requests.flatten().map(stop).collect()
}

/// Nothing where an arm has no such thing.
pub(super) fn answered<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error) => match error.kind() {
            ErrorKind::Timeout | ErrorKind::Unsupported | ErrorKind::Unexpected => Ok(None),
            _ => Err(error),
        },
    }
}
