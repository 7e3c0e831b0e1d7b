//! Position reads during the arm's own jog: they show the end of its axis and the approach to a
//! fence.

use magician_protocol::commands::{Pose, PoseL};
use magician_protocol::{FrameBuf, Layout, NoArgs};

use super::ANSWER_TIMEOUT;
use crate::Result;
use crate::arm::driver::{Driver, ReplyTarget};
use crate::arm::fenced_jog::FencedJog;
use crate::connection::{Micros, Request};
use crate::gate::{JogEnd, JogId};

/// Interval of position reads during a jog under a fence. Choice: four reads of a serial line's 10
/// ms each fit into it, and the fence is checked 25 times a second.
const FENCED_LOOK_INTERVAL: Micros = 40_000;
/// Interval of position reads during any other jog. A read costs 10 ms of a serial line, and three
/// in a row show an arm at rest at the end of its axis.
const LOOK_INTERVAL: Micros = 200_000;
/// Shortest time between two compared reads. The controller moves in periods of 20 ms, and even the
/// slowest jog (1 % of 1 mm/s) moves further than binary32 resolves in this time.
const STUCK_TIME: Micros = 180_000;
/// Equal successive reads after which a jog counts as blocked. One is not enough: a jog that
/// reverses passes each position twice, at equal times before and after its turning point.
const STUCK_READS: u32 = 2;

/// Position reads of the current jog.
pub(super) struct Looks {
    jog: JogId,
    /// True if it moves the rail, which the pose does not show.
    rail: bool,
    fence: Option<FencedJog>,
    /// Time of the next read; `None` while one is in flight.
    at: Option<Micros>,
    /// Last compared position, with its time.
    seen: Option<(Place, Micros)>,
    /// Number of successive reads equal to the one before.
    equal: u32,
}

/// Position during a jog: the pose, or the position on the rail.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Arm(Pose),
    Rail(f32),
}

/// Returns the request for a position.
pub(super) fn place_request(rail: bool) -> Option<Request> {
    let request = if rail {
        Request::get::<PoseL>(&NoArgs)
    } else {
        Request::get::<Pose>(&NoArgs)
    };
    request.ok()
}

fn place(rail: bool, answer: Result<FrameBuf>) -> Option<Place> {
    let reply = answer.ok()?;
    let reply = reply.frame();
    if rail {
        let at = PoseL::decode(reply.params()).ok()?;
        Some(Place::Rail(at.pose_l))
    } else {
        Pose::decode(reply.params()).ok().map(Place::Arm)
    }
}

impl Looks {
    pub(super) fn new(jog: JogId, rail: bool, fence: Option<FencedJog>, now: Micros) -> Self {
        let mut looks = Self {
            jog,
            rail,
            fence,
            at: None,
            seen: None,
            equal: 0,
        };
        looks.look_again(now);
        looks
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.at
    }

    fn look_again(&mut self, now: Micros) {
        let interval = match self.fence {
            Some(_) => FENCED_LOOK_INTERVAL,
            None => LOOK_INTERVAL,
        };
        self.at = Some(now.saturating_add(interval));
    }

    /// True if the jog has stopped moving.
    fn is_stuck(&mut self, place: Place, now: Micros) -> bool {
        match self.seen {
            // A sooner read is skipped: two within one period of the controller are equal anyway.
            Some((before, at)) if now.saturating_sub(at) >= STUCK_TIME => {
                self.equal = if place == before { self.equal + 1 } else { 0 };
                self.seen = Some((place, now));
            }
            None => self.seen = Some((place, now)),
            Some(_) => {}
        }
        self.equal >= STUCK_READS
    }

    /// Returns the bound of the jog: the end of its axis, or the fence. With a fence, a lost read
    /// ends the jog at once, because its position is unknown; without one it means nothing.
    fn bound(
        &mut self,
        place: Option<Place>,
        asked: Micros,
        now: Micros,
    ) -> Option<(Micros, JogEnd)> {
        if place.is_some_and(|place| self.is_stuck(place, now)) {
            return Some((now, JogEnd::Limit));
        }
        let fence = self.fence.as_ref()?;
        match place {
            // An arm faster than its settings has to be stopped sooner.
            Some(Place::Arm(pose)) => Some((fence.latest_after(asked, &pose), JogEnd::Fence)),
            // A fence bounds the arm, not the rail.
            Some(Place::Rail(_)) => None,
            None => Some((now, JogEnd::Fence)),
        }
    }
}

impl Driver {
    pub(super) fn look_at_jog(&mut self, now: Micros) {
        let looks = self.jogging.looks.as_mut();
        let Some(looks) = looks.filter(|looks| looks.at.is_some_and(|at| at <= now)) else {
            return;
        };
        looks.at = None;
        let (jog, request) = (looks.jog, place_request(looks.rail));
        let deadline = self.at(now.saturating_add(ANSWER_TIMEOUT));
        if let Some(request) = request {
            self.submit(request, deadline, ReplyTarget::JogLook(jog, now));
        }
    }

    /// Handles the position as of the request.
    pub(in crate::arm::driver) fn jog_seen(
        &mut self,
        answer: Result<FrameBuf>,
        jog: JogId,
        asked: Micros,
    ) {
        let now = self.now();
        let looks = self.jogging.looks.as_mut();
        let Some(looks) = looks.filter(|looks| looks.jog == jog) else {
            return;
        };
        looks.look_again(now);
        let place = place(looks.rail, answer);
        if let Some((at, why)) = looks.bound(place, asked, now) {
            self.shared.gate().bound(jog, at, why);
            self.mind_deadline(now);
        }
    }
}
