//! The controller as those who hold it see it.

use magician_motion::{ArmModel, JointAngles, ToolBias};
use magician_protocol::{Event as Found, Frame, FrameBuf, Row};

use crate::device::Device;
use crate::event::Event;
use crate::fidelity::Assumption;
use crate::link::{Link, Links, Outbox};
use crate::{Flash, LinkId, Micros, Profile, State, World};

/// A Dobot Magician's controller, without a clock and without a wire.
///
/// # Grammar
///
/// * **Look**: [`now`](Self::now), [`state`](Self::state), [`jogging`](Self::jogging), [`busy`](Self::busy),
///   [`events`](Self::events) change nothing.
/// * **Bytes in**: [`receive`](Self::receive) takes what came over a link and acts on every frame in it at the present
///   instant; [`receive_one`](Self::receive_one) stops after each request, for callers that let time pass between
///   them. [`expire`](Self::expire) and [`close`](Self::close) say that a link fell silent or is gone.
/// * **Time**: [`advance`](Self::advance) lets the arm's clock run to an instant.
///   [`poll_timeout`](Self::poll_timeout) is the next instant at which something happens by itself.
/// * **Out**: [`poll_transmit`](Self::poll_transmit) gives the replies of a link until `None`,
///   [`poll_event`](Self::poll_event) what happened.
/// * **Hands**: [`press`](Self::press), [`unlock`](Self::unlock) and [`guide`](Self::guide) do what a hand does to the
///   arm, [`inject`](Self::inject) whatever else may happen to it.
/// * **Copy**: a clone is a snapshot. It goes on from there as the original does, bit for bit, and neither knows of the
///   other; putting it back in the original's place goes back in time.
///
/// A driver of it repeats: `receive`, `poll_transmit` until `None`, `advance` to the earlier of the next byte and
/// `poll_timeout`.
///
/// # Promises
///
/// The same calls give the same bytes, events and poses, bit for bit. `advance(a); advance(b)` is `advance(b)`. A move
/// costs the same whether it takes a second or an hour. No bytes and no values make it panic, and its memory is bounded:
/// the queue by its depth, the program in the flash by the profile's capacity, each of at most 64 links by its decoder and
/// 32 KiB of replies not taken, the log by 256 events. Once its buffers have grown to what is in use it allocates nothing.
#[derive(Clone)]
pub struct Controller {
    pub(crate) links: Links,
    pub(crate) core: Device,
}

impl std::fmt::Debug for Controller {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Controller")
            .field("state", &self.state())
            .finish_non_exhaustive()
    }
}

impl Default for Controller {
    /// A Magician with firmware 3.6.14 in an empty world.
    fn default() -> Self {
        Self::new(Profile::default())
    }
}

impl Controller {
    /// Switches on an arm with this firmware in an empty world.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        Self::in_world(profile, World::default())
    }

    /// Switches on an arm with this firmware in this world. A scenario may say where its base really stands, that it has
    /// been homed, or which tool is on it.
    #[must_use]
    pub fn in_world(profile: Profile, world: World) -> Self {
        let flash = Flash::new(&profile);
        Self::with_flash(profile, world, flash)
    }

    /// The same arm, but with another tool chosen before it was switched on; it keeps that through a reset. The profile and
    /// a scenario say which one otherwise.
    ///
    /// ```
    /// use magician_motion::ToolBias;
    /// use magician_sim::Controller;
    ///
    /// assert_eq!(Controller::default().state().pose.x.round(), 259.0);
    /// let arm = Controller::default().with_tool(ToolBias::NONE);
    /// assert_eq!(arm.state().pose.x.round(), 199.0);
    /// ```
    #[must_use]
    pub fn with_tool(mut self, tool: ToolBias) -> Self {
        self.core.had_tool(tool);
        self
    }

    /// The same arm, but switched on while it really stood there, deg: J1 reads what it reads at power-up wherever the
    /// base stands, J2 and J3 read what their sensors say, J4 what it is. Angles beyond the limits count as the limit,
    /// and what is not a number as what the profile says. Not homed.
    ///
    /// ```
    /// use magician_sim::Controller;
    ///
    /// let arm = Controller::default().standing_at([30.0, 20.0, 10.0, 0.0].into());
    /// let state = arm.state();
    /// assert_eq!(state.joints.to_array(), [0.0, 20.0, 10.0, 0.0]);
    /// assert_eq!(state.true_joints.to_array(), [30.0, 20.0, 10.0, 0.0]);
    /// ```
    #[must_use]
    pub fn standing_at(mut self, joints: JointAngles) -> Self {
        self.core.stood_at(joints);
        self
    }

    /// The arm's clock: microseconds since power-up.
    #[must_use]
    pub fn now(&self) -> Micros {
        self.core.now
    }

    /// The numbers by which it plans motions.
    #[must_use]
    pub fn arm_model(&self) -> &ArmModel {
        &self.core.model
    }

    /// The world around the arm.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.core.world
    }

    /// Everything about the arm at the present instant.
    #[must_use]
    pub fn state(&self) -> State {
        State::of(&self.core)
    }

    /// The index of the queued command that was finished last.
    #[must_use]
    pub fn current_index(&self) -> u64 {
        self.core.hosts().current
    }

    /// Whether a motion without an end of its own runs: a jog.
    #[must_use]
    pub fn jogging(&self) -> bool {
        self.core.motion.is_jogging()
    }

    /// Whether the arm does something that ends by itself, a motion or a WAIT, or waits for an input that the scenario will change. A jog does not end
    /// by itself, a motor that runs on is no work of the arm's, and what a scenario says happens to an idle arm.
    #[must_use]
    pub fn busy(&self) -> bool {
        self.core.is_busy()
    }

    /// Takes bytes from a link and handles every frame in them, all at the present instant.
    pub fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        let mut input = bytes;
        while self.receive_one(link, &mut input) {}
    }

    /// As [`receive`](Self::receive), but returns `true` as soon as one request has been handled; `false` when all of
    /// `input` has been taken and no whole frame is left. Bytes taken from `input` may hold further requests: call
    /// again, even with an empty `input`, until it returns `false`.
    pub fn receive_one(&mut self, link: LinkId, input: &mut &[u8]) -> bool {
        let Self { links, core } = self;
        let heard = match input {
            [] => links.known(link),
            _ => Some(links.heard(link)),
        };
        let Some(peer) = heard else { return false };
        let Link { deframer, outbox } = peer;
        while let Some(found) = deframer.next(input) {
            match found {
                Found::Frame { frame, .. } => {
                    handle(core, link, outbox, &frame);
                    return true;
                }
                Found::Rejected { .. } => core.damaged_frame(link),
                Found::Noise { .. } => core.assume(Assumption::ForeignBytes),
            }
        }
        false
    }

    /// The line has been silent for the inter-byte timeout: a frame that has begun there will not be completed. Frames
    /// that this uncovers are handled at the present instant. The caller's clock decides, the arm's has no part in it.
    pub fn expire(&mut self, link: LinkId) {
        if let Some(peer) = self.links.known(link) {
            peer.deframer.expire();
            self.receive(link, &[]);
        }
    }

    /// The peer is gone: forgets its half-received frame and the replies it has not taken.
    pub fn close(&mut self, link: LinkId) {
        self.links.close(link);
    }

    /// Lets the arm's time pass up to `to`; an instant that has passed changes nothing.
    pub fn advance(&mut self, to: Micros) {
        self.core.advance(to);
        self.forget_links();
    }

    /// The instant of the arm's clock at which something next happens by itself: the end of a motion, of a wait.
    /// `None` when nothing is scheduled.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        self.core.next_event()
    }

    /// The next reply to a link, oldest first.
    pub fn poll_transmit(&mut self, link: LinkId) -> Option<FrameBuf> {
        self.links.known(link)?.outbox.pop()
    }

    /// The next event, oldest first. At most 256 are kept; [`State::events_lost`] counts those that were not read in
    /// time.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.core.log.pop()
    }

    /// The events that wait to be polled, oldest first, each with its number, counted from 0 at power-up. Looking at
    /// them does not take them.
    pub fn events(&self) -> impl Iterator<Item = (u64, Event)> {
        self.core.log.waiting()
    }
}

/// Handles one frame: exactly one reply for a request that the controller knows, silence for others (errata E09).
fn handle(core: &mut Device, link: LinkId, outbox: &mut Outbox, frame: &Frame<'_>) {
    if !outbox.has_room() {
        core.log.push(Event::Overrun { link });
        return;
    }
    if Row::with_id(frame.id()).is_none() {
        core.unknown_id(link, frame.id());
        return;
    }
    if !core.may_overflow(frame) {
        return;
    }
    let reply = core.answer(frame);
    // A reply holds what the controller stores, which fits a frame.
    if let Ok(reply) = reply.or_else(|_| FrameBuf::new(frame.id(), frame.ctrl(), &[])) {
        outbox.push(&reply);
    }
}
