//! In-process virtual arm whose clock is stepped.

use std::time::Duration;

use magician::Result;
use magician_protocol::INTER_BYTE_TIMEOUT_MS;
use magician_sim::{ArmInstant, Controller, ExternalEvent, LinkId, Profile, World};

use super::Target;
use crate::step::Observable;

/// In-process virtual arm whose clock this target steps.
#[derive(Clone, Debug)]
pub struct SimTarget {
    profile: Profile,
    arm: Controller,
    link: LinkId,
}

impl SimTarget {
    /// Creates virtual arms with this firmware.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        Self {
            arm: Controller::new(profile.clone()),
            profile,
            link: LinkId(0),
        }
    }

    /// Returns the arm of the current case.
    pub fn arm(&mut self) -> &mut Controller {
        &mut self.arm
    }

    fn drain(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        while let Some(frame) = self.arm.poll_transmit(self.link) {
            bytes.extend_from_slice(frame.bytes());
        }
        bytes
    }

    fn advance(&mut self, span: Duration) {
        self.arm.advance(self.arm.now() + span);
        // An incomplete frame expires here, because the controller has no separate clock for the
        // line.
        if span >= Duration::from_millis(INTER_BYTE_TIMEOUT_MS) {
            self.arm.expire(self.link);
        }
    }
}

impl Default for SimTarget {
    /// Creates arms with the built-in firmware profile.
    fn default() -> Self {
        Self::new(Profile::default())
    }
}

impl Target for SimTarget {
    async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.arm.receive(self.link, bytes);
        Ok(())
    }

    async fn receive(&mut self, within: Duration) -> Result<Vec<u8>> {
        let bytes = self.drain();
        // Replies that are ready take no time of the arm's clock.
        if !bytes.is_empty() || within.is_zero() {
            return Ok(bytes);
        }
        self.advance(within);
        Ok(self.drain())
    }

    async fn pass(&mut self, span: Duration) -> Result<()> {
        self.advance(span);
        Ok(())
    }

    async fn go_on(&mut self, at_most: Duration) -> Result<()> {
        let latest = self.arm.now() + at_most;
        // Without a pending event nothing changes before `latest`.
        let next = self.arm.poll_timeout().unwrap_or(latest);
        self.arm.advance(next.min(latest));
        Ok(())
    }

    fn stepped(&self) -> Option<ArmInstant> {
        Some(self.arm.now())
    }

    fn power_up(&mut self, world: World) -> bool {
        self.arm = Controller::in_world(self.profile.clone(), world);
        self.link = LinkId(0);
        true
    }

    fn happens(&mut self, event: ExternalEvent) -> bool {
        self.arm.inject(event);
        true
    }

    fn sees(&mut self, observable: Observable) -> Option<f64> {
        let state = self.arm.state();
        Some(match observable {
            Observable::Laser => state.laser_power,
            Observable::Suction => state.suction.reached.into(),
            Observable::Gripper => state.gripper.reached.into(),
            Observable::Holding => state.holding.into(),
            Observable::Pulses(output) => self.arm.steppers().get(output)?.pulses,
        })
    }

    fn select(&mut self, link: u8) -> bool {
        self.link = LinkId(link.into());
        true
    }
}
