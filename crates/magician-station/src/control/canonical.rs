//! Canonical form of a [`Control`], for the exhaustive search in `tests/lease`.
//!
//! Ids and absolute instants grow with each step, so two states that behave alike compare unequal.
//! The canonical form drops the ids, shifts all instants to a fixed present and clamps ages that no
//! longer matter. The search then recognises states it has visited.

use magician_protocol::HostInstant;

use super::{Control, JogId, LEASE_TIMEOUT, LeaseId, RECONNECT_GRACE};

/// The instant that stands for the present. One hour leaves room for all ages before it.
const PRESENT: HostInstant = HostInstant::from_micros(3_600_000_000);

impl Control {
    /// Returns the state reduced to what matters from `now` on: instants are relative to a fixed
    /// present, leases and jogs have no ids.
    ///
    /// Two controls with equal canonical forms behave equally from now on, except for the ids that
    /// they assign.
    #[doc(hidden)]
    #[must_use]
    pub fn canonical(&self, now: HostInstant) -> Self {
        // `-` saturates at zero, so exactly one of the two differences is nonzero.
        let from_present = |at: HostInstant| PRESENT + (at - now) - (now - at);
        let mut out = self.clone();
        out.ids = 0;
        // Deadlines of claims are shifted like all others.
        out.claims.canonical(from_present);
        #[cfg(feature = "class")]
        out.class.each_instant(|at| *at = from_present(*at));
        for arm in &mut out.arms {
            if let Some(held) = &mut arm.lease {
                held.id = LeaseId(0);
            }
            if let Some(jog) = &mut arm.jog {
                jog.id = JogId(0);
                jog.ends = from_present(jog.ends);
            }
        }
        for (session, presence) in &mut out.sessions {
            // Only the last message of a holder counts, because acquiring a lease counts as a
            // message.
            let counts = self.held_by(*session).next().is_some();
            let age = if counts {
                (now - presence.heard).min(LEASE_TIMEOUT)
            } else {
                LEASE_TIMEOUT
            };
            presence.heard = PRESENT - age;
            // After GRACE the session is over, however much later it is.
            presence.left =
                { presence.left }.map(|left| PRESENT - (now - left).min(RECONNECT_GRACE));
        }
        out
    }
}
