//! Laws that must hold after every event.

use magician_station::control::{LEASE_TIMEOUT, RECONNECT_GRACE, SessionId};

use crate::world::{ARM, Event, SLOT, StationModel, World};

/// `Err` names the broken law.
pub(crate) type Checked = Result<(), String>;

pub(crate) fn must(good: bool, what: &str) -> Checked {
    if good { Ok(()) } else { Err(what.to_owned()) }
}

impl World {
    pub(crate) fn check(&self, before: &Self, event: Event) -> Checked {
        for (at, model) in self.stations.iter().enumerate() {
            let holder = model.control.holder(ARM);
            for motion in model.motions.iter().filter(|motion| !motion.free) {
                must(
                    holder == Some(motion.session),
                    "what moves an arm belongs to its holder",
                )?;
            }
            let Some(holder) = holder else {
                self.check_end(&before.stations[at], model, at, event)?;
                continue;
            };
            let left = model.left.iter().find(|(gone, _)| *gone == holder);
            let soon = left.is_some_and(|(_, left)| model.now - *left < RECONNECT_GRACE);
            must(
                soon || self.user_of(at, holder).is_some(),
                "a lease ends with its line",
            )?;
            let person = holder.0 % 3;
            must(is_in_slot(model, person), "nobody holds outside of a slot")?;
        }
        Ok(())
    }

    /// Returns the user whose line has this session.
    fn user_of(&self, at: usize, session: SessionId) -> Option<usize> {
        self.lines.iter().position(|lines| {
            let line = lines[at].as_ref();
            let end = line.and_then(|line| line.end.as_ref());
            end.is_some_and(|end| end.session == session)
        })
    }

    /// Checks that a lease that ended as time passed was due to end by the station's own clock.
    fn check_end(
        &self,
        before: &StationModel,
        model: &StationModel,
        at: usize,
        event: Event,
    ) -> Checked {
        let (Some(holder), Event::Pass(_)) = (before.control.holder(ARM), event) else {
            return Ok(());
        };
        let gone = { before.left.iter() }
            .any(|(gone, left)| *gone == holder && model.now - *left >= RECONNECT_GRACE);
        let ends = self.lines.iter().filter_map(|lines| lines[at].as_ref());
        let mut ends = ends
            .filter_map(|line| line.end.as_ref())
            .filter(|end| end.session == holder);
        let silent = ends.any(|end| model.now - end.heard >= LEASE_TIMEOUT);
        must(
            gone || silent || !is_in_slot(model, holder.0 % 3),
            "a slot is by the station's own clock",
        )
    }
}

/// True if the person may hold an arm by the clock of its station: the first one in the first slot,
/// the second one in the next, and the third one, a teacher, always.
fn is_in_slot(model: &StationModel, person: u64) -> bool {
    match person {
        0 => model.now < model.slot,
        1 => model.now >= model.slot && model.now < model.slot + SLOT,
        _ => true,
    }
}
