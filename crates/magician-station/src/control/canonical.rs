//! A state of control without what only grows, so that a search knows a state that it has seen.

use magician_protocol::HostInstant;

use super::{Control, GRACE, JogId, LeaseId, TTL};

/// Where the present stands; what is longer ago than this does not count any more.
const PRESENT: HostInstant = HostInstant::from_micros(3_600_000_000);

impl Control {
    /// The state as far as it matters from `now` on: instants count from there, leases and jogs have no numbers. Two
    /// controls of which this is equal do the same from now on, but for the numbers that they give.
    #[doc(hidden)]
    #[must_use]
    pub fn canonical(&self, now: HostInstant) -> Self {
        let from_present = |at: HostInstant| PRESENT + (at - now) - (now - at);
        let mut out = self.clone();
        out.ids = 0;
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
            // A lease begins with a word: the last one counts for holders alone.
            let counts = self.held_by(*session).next().is_some();
            let age = if counts {
                (now - presence.heard).min(TTL)
            } else {
                TTL
            };
            presence.heard = PRESENT - age;
            presence.left = { presence.left }.map(|left| PRESENT - (now - left).min(GRACE));
        }
        out
    }
}
