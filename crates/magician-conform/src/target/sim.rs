use std::time::Duration;

use magician::Result;
use magician_protocol::INTER_BYTE_TIMEOUT_MS;
use magician_sim::{Controller, ExternalEvent, LinkId, Micros, Profile, World};

use super::Target;

const LINK: LinkId = LinkId(0);

/// A virtual arm inside this program, whose clock this target steps.
#[derive(Clone, Debug)]
pub struct SimTarget {
    profile: Profile,
    arm: Controller,
}

impl SimTarget {
    /// Virtual arms with this firmware.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        Self {
            arm: Controller::new(profile.clone()),
            profile,
        }
    }

    fn drain(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        while let Some(frame) = self.arm.poll_transmit(LINK) {
            bytes.extend_from_slice(frame.bytes());
        }
        bytes
    }

    fn advance(&mut self, span: Duration) {
        let to = self.arm.now().saturating_add(micros(span));
        self.arm.advance(to);
        if span >= Duration::from_millis(INTER_BYTE_TIMEOUT_MS) {
            self.arm.expire(LINK);
        }
    }
}

impl Default for SimTarget {
    /// Arms with the built-in firmware profile.
    fn default() -> Self {
        Self::new(Profile::default())
    }
}

fn micros(span: Duration) -> Micros {
    Micros::try_from(span.as_micros()).unwrap_or(Micros::MAX)
}

impl Target for SimTarget {
    async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.arm.receive(LINK, bytes);
        Ok(())
    }

    async fn receive(&mut self, within: Duration) -> Result<Vec<u8>> {
        let bytes = self.drain();
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
        let latest = self.arm.now().saturating_add(micros(at_most));
        let next = self.arm.poll_timeout().unwrap_or(latest);
        self.arm.advance(next.min(latest));
        Ok(())
    }

    fn stepped(&self) -> Option<Micros> {
        Some(self.arm.now())
    }

    fn power_up(&mut self, world: World) -> bool {
        self.arm = Controller::in_world(self.profile.clone(), world);
        true
    }

    fn happens(&mut self, happening: ExternalEvent) -> bool {
        self.arm.inject(happening);
        true
    }
}
