//! Looks at where the arm's own jog is: what bounds its way shows in its position.

use magician_protocol::commands::{Pose, PoseL};
use magician_protocol::{FrameBuf, Layout, NoArgs};

use super::PATIENCE;
use crate::Result;
use crate::arm::driver::{Driver, To};
use crate::arm::fenced_jog::FencedJog;
use crate::connection::{Micros, Request};
use crate::gate::{JogEnd, JogId};

/// Interval of position reads during a jog under a fence.
const FENCED_LOOK_INTERVAL: Micros = 40_000;
/// Interval of position reads during any other jog: a read costs 10 ms of a serial line, and three show an arm that stands at
/// the end of its axis.
const LOOK_INTERVAL: Micros = 200_000;
/// Shortest time between two reads that are compared. The controller moves in periods of 20 ms, and the slowest jog (1 % of 1 mm/s)
/// by more than binary32 resolves.
const STUCK_TIME: Micros = 180_000;
/// Reads in succession that are equal to the one before when a jog does not move. One is not enough: a jog that turns round
/// passes each place twice, at equal times before and after its turning point.
const STUCK_READS: u32 = 2;

/// Looks at where a jog under way is.
pub(super) struct Looks {
    jog: JogId,
    /// True if it moves the rail, which the pose does not show.
    rail: bool,
    fence: Option<FencedJog>,
    /// When to look next; `None` while a look is out.
    at: Option<Micros>,
    /// Last position that was compared, and when it was read.
    seen: Option<(Place, Micros)>,
    /// How many reads in succession were equal to the one before.
    equal: u32,
}

/// Position during a jog: the pose, or the position on the rail.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Arm(Pose),
    Rail(f32),
}

/// The request for a position.
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

    /// True if the jog does not move any more.
    fn is_stuck(&mut self, place: Place, now: Micros) -> bool {
        match self.seen {
            Some((before, at)) if now.saturating_sub(at) >= STUCK_TIME => {
                self.equal = if place == before { self.equal + 1 } else { 0 };
                self.seen = Some((place, now));
            }
            None => self.seen = Some((place, now)),
            Some(_) => {}
        }
        self.equal >= STUCK_READS
    }

    /// What bounds the jog: the end of its axis, or the fence. A look that was lost leaves the fence without a place; without a
    /// fence it says nothing.
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
            // An arm that is faster than it says has to stop sooner.
            Some(Place::Arm(pose)) => Some((fence.latest_after(asked, &pose), JogEnd::Fence)),
            // A fence bounds no rail: what it bounds is where the arm is.
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
        let deadline = self.at(now.saturating_add(PATIENCE));
        if let Some(request) = request {
            self.submit(request, deadline, To::JogLook(jog, now));
        }
    }

    /// Its position, as of the request.
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
