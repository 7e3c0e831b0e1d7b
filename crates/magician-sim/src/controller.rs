//! The public interface of the virtual controller.

use magician_motion::{ArmModel, JointAngles, ToolBias};
use magician_protocol::{Event as StreamEvent, FrameBuf};

use crate::device::Device;
use crate::event::Event;
use crate::fidelity::{Assumption, Fidelity};
use crate::link::{Link, Links};
use crate::observer::{self, Observer, SampleBudget};
use crate::profile::{Identity, PINS, serial_at};
use crate::world::{Drawing, ExternalEvent, Press, WorldView};
use crate::{
    ArmInstant, ControllerState, Flash, LineState, LinkId, PinState, Profile, StepperState, World,
};

/// The controller of a Dobot Magician, without a clock and without I/O.
///
/// # Grammar
///
/// * **State**: [`now`](Self::now), [`state`](Self::state), [`jogging`](Self::jogging),
///   [`busy`](Self::busy), [`events`](Self::events) change nothing.
/// * **Input**: [`receive`](Self::receive) takes the bytes of a link and handles every frame in
///   them at the present instant. [`receive_one`](Self::receive_one) returns after each request,
///   for callers that let time pass in between. [`expire`](Self::expire) and [`close`](Self::close)
///   report that a link fell silent or is gone.
/// * **Time**: [`advance`](Self::advance) runs the arm's clock to an instant.
///   [`poll_timeout`](Self::poll_timeout) is the next instant at which something happens by itself.
/// * **Output**: [`poll_transmit`](Self::poll_transmit) returns the replies of a link until `None`,
///   [`poll_event`](Self::poll_event) the log.
/// * **Physical interaction**: [`press`](Self::press), [`unlock`](Self::unlock) and
///   [`guide`](Self::guide) act on the arm by hand; [`inject`](Self::inject) covers everything
///   else.
/// * **Snapshot**: a clone. It continues exactly as the original would, and neither affects the
///   other. Replacing the original by it goes back in time.
///
/// The caller's loop: `receive`, `poll_transmit` until `None`, `advance` to the earlier of the next
/// byte and `poll_timeout`.
///
/// # Guarantees
///
/// * Deterministic: the same calls give the same bytes, events and poses, bit for bit.
/// * `advance(a); advance(b)` equals `advance(b)`, and a move costs the same work however long it
///   takes.
/// * No bytes and no values make it panic.
/// * Memory is bounded: the queue by its depth, the stored program by the capacity of the profile,
///   each of at most 64 links by its decoder and 32 KiB of pending replies, the log by 256 events.
///   In steady state nothing is allocated.
#[derive(Clone)]
pub struct Controller {
    links: Links,
    device: Device,
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
    /// Powers up an arm with this firmware in an empty world.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        Self::in_world(profile, World::default())
    }

    /// Powers up an arm with this firmware in this world.
    ///
    /// The scenario of the world may set the true angle of the base, a homed arm, or the tool.
    #[must_use]
    pub fn in_world(profile: Profile, world: World) -> Self {
        let flash = Flash::new(&profile);
        Self::with_flash(profile, world, flash)
    }

    /// Powers up an arm with the flash of an earlier one, as after a power cycle.
    #[must_use]
    pub fn with_flash(profile: Profile, world: World, flash: Flash) -> Self {
        Self {
            links: Links::default(),
            device: Device::switched_on(profile, world, flash),
        }
    }

    /// Returns the arm with another tool bias at power-up, kept through a reset.
    ///
    /// This bias overrides that of the profile and of the scenario.
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
        self.device.set_initial_tool(tool);
        self
    }

    /// Derives the serial number from `place`, so that arms at different places can be
    /// distinguished.
    ///
    /// A serial number set by the profile, the flash or a host takes precedence. `number` is the
    /// arm's position among [several](crate::Identity::numbered).
    ///
    /// ```
    /// use magician_sim::Controller;
    ///
    /// let serial = |place: &str| {
    ///     let mut arm = Controller::default();
    ///     arm.identify_at(place, None);
    ///     arm.serial()
    /// };
    /// assert_eq!(serial("/tmp/arm"), serial("/tmp/arm"));
    /// assert_ne!(serial("/tmp/arm"), serial("/tmp/other"));
    /// ```
    pub fn identify_at(&mut self, place: &str, number: Option<u32>) {
        self.identify_as(serial_at(place), number);
    }

    /// Sets the serial number under the same rule as [`identify_at`](Self::identify_at).
    pub fn identify_as(&mut self, serial: String, number: Option<u32>) {
        let usual = Identity::default();
        let usual = number.map_or(usual.clone(), |number| usual.numbered(number));
        // Any other value was set on purpose, by a profile, a flash or a host.
        if self.serial() == usual.serial {
            self.device.set_initial_serial(serial);
        }
    }

    /// Serial number of the arm.
    #[must_use]
    pub fn serial(&self) -> String {
        self.flash().serial.device_sn.to_string()
    }

    /// Returns the arm as if it had been powered up with these true joint angles, deg; not homed.
    ///
    /// J1 still reads its value of power-up, because its sensor is incremental. J2 and J3 read
    /// their absolute sensors, and J4 its own angle (model section 11). Angles beyond a limit are
    /// clamped to it, and NaN keeps the value of the profile.
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
        self.device.set_initial_joints(joints);
        self
    }

    /// The arm's clock: microseconds since power-up.
    #[must_use]
    pub fn now(&self) -> ArmInstant {
        self.device.now
    }

    /// Numbers with which the arm plans motions.
    #[must_use]
    pub fn arm_model(&self) -> &ArmModel {
        &self.device.firmware.model
    }

    /// World around the arm.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.device.world
    }

    /// View of the world at the present instant: positions of the objects, and what the tool holds.
    #[must_use]
    pub fn look(&self) -> WorldView<'_> {
        let Device {
            now, motion, world, ..
        } = &self.device;
        world.look(*now, &motion.true_pose(*now))
    }

    /// Traces of pen and laser so far.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        let Device {
            now, motion, world, ..
        } = &self.device;
        motion.drawing(*now, world)
    }

    /// Contents of the flash, which survive a loss of power.
    #[must_use]
    pub fn flash(&self) -> &Flash {
        self.device.store.flash()
    }

    /// Number of writes to the flash since power-up, resets included. The flash is unchanged while
    /// this number is.
    #[must_use]
    pub fn flash_writes(&self) -> u64 {
        self.device.store.flash_writes()
    }

    /// The 20 EIO pins, address 1 first.
    #[must_use]
    pub fn pins(&self) -> [PinState; PINS] {
        let Device { now, io, world, .. } = &self.device;
        let mut address = 0;
        [(); PINS].map(|()| {
            address += 1;
            io.pins.state(address, world, *now)
        })
    }

    /// Stepper outputs, 1 and 2.
    #[must_use]
    pub fn steppers(&self) -> [StepperState; 2] {
        self.device.io.steppers.states(self.device.now)
    }

    /// State of the cable, for the code that carries the bytes.
    #[must_use]
    pub fn line(&self) -> LineState {
        self.device.line
    }

    /// Assumptions that the answers have relied on since power-up, resets included.
    #[must_use]
    pub fn fidelity(&self) -> &Fidelity {
        self.device.record.fidelity()
    }

    /// Complete state of the arm at the present instant.
    #[must_use]
    pub fn state(&self) -> ControllerState {
        ControllerState::of(&self.device)
    }

    /// Index of the queued command that finished last.
    #[must_use]
    pub fn current_index(&self) -> u64 {
        self.device.queues.hosts().current()
    }

    /// True while a jog runs, that is, a motion without a set end.
    #[must_use]
    pub fn jogging(&self) -> bool {
        self.device.motion.is_jogging()
    }

    /// True while the arm does something that ends by itself: a motion, a WAIT, or a wait for an
    /// input that the scenario will change.
    ///
    /// A jog does not end by itself, a running conveyor motor is not counted, and a scripted event
    /// happens to an idle arm.
    #[must_use]
    pub fn busy(&self) -> bool {
        self.device.is_busy()
    }

    /// Handles every frame in the bytes of a link, all at the present instant.
    pub fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        let mut input = bytes;
        while self.receive_one(link, &mut input) {}
    }

    /// Like [`receive`](Self::receive), but returns `true` after each handled request.
    ///
    /// Returns `false` when all of `input` has been consumed and no complete frame is left. The
    /// decoder may still hold requests after `input` is empty: call again until it returns `false`.
    pub fn receive_one(&mut self, link: LinkId, input: &mut &[u8]) -> bool {
        let Self { links, device } = self;
        // Without bytes only a known link can have anything left to handle. An unknown one must not
        // be admitted, because that could evict another.
        let heard = match input {
            [] => links.known(link),
            _ => Some(links.heard(link)),
        };
        // An unknown link without bytes: nothing can be pending.
        let Some(peer) = heard else { return false };
        let Link { deframer, outbox } = peer;
        // Noise and rejected candidates are skipped, so one call may consume several of them.
        while let Some(found) = deframer.next(input) {
            match found {
                StreamEvent::Frame { frame, .. } => {
                    // A peer that does not read its replies loses requests instead of growing
                    // memory. Handling a request without a reply would break hosts 1, one answer
                    // each.
                    if !outbox.has_room() {
                        device.record.event(Event::Overrun { link });
                    } else if let Some(reply) = device.answer(link, &frame) {
                        outbox.push(&reply);
                    }
                    return true;
                }
                // Neither answered nor acted on, as a real arm does (E10).
                StreamEvent::Rejected { .. } => {
                    device.record.event(Event::BadFrame { link });
                    device.record.assume(Assumption::DamagedFrame);
                }
                StreamEvent::Noise { .. } => device.record.assume(Assumption::ForeignBytes),
            }
        }
        false
    }

    /// Reports that a link has been silent for the inter-byte timeout: a partial frame will not be
    /// completed.
    ///
    /// Frames found inside the abandoned bytes are handled at the present instant. The caller
    /// measures the timeout on its own clock.
    pub fn expire(&mut self, link: LinkId) {
        if let Some(peer) = self.links.known(link) {
            peer.deframer.expire();
            self.receive(link, &[]);
        }
    }

    /// Drops a peer, with its partial frame and its pending replies.
    pub fn close(&mut self, link: LinkId) {
        self.links.close(link);
    }

    /// Returns the arm with all links [closed](Self::close).
    #[must_use]
    pub fn without_peers(mut self) -> Self {
        self.links.clear();
        self
    }

    /// Advances the arm's clock to `to`. An instant in the past changes nothing.
    pub fn advance(&mut self, to: ArmInstant) {
        self.device.advance(to);
        self.forget_links();
    }

    /// Next instant of the arm's clock at which something happens by itself, such as the end of a
    /// motion or a wait. `None` if nothing is scheduled.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<ArmInstant> {
        self.device.next_event()
    }

    /// Returns the next reply to a link, oldest first.
    pub fn poll_transmit(&mut self, link: LinkId) -> Option<FrameBuf> {
        self.links.known(link)?.outbox.pop()
    }

    /// Handles bytes like [`receive`](Self::receive) and returns all pending replies of the link,
    /// oldest first.
    ///
    /// ```
    /// use magician_sim::{Controller, LinkId, Profile};
    ///
    /// let mut arm = Controller::new(Profile::default());
    /// let version = arm.exchange(LinkId(0), &[0xAA, 0xAA, 0x02, 0x02, 0x00, 0xFE]);
    /// assert_eq!(version[0].frame().params()[..2], [3, 6]);
    /// ```
    pub fn exchange(&mut self, link: LinkId, bytes: &[u8]) -> Vec<FrameBuf> {
        self.receive(link, bytes);
        std::iter::from_fn(|| self.poll_transmit(link)).collect()
    }

    /// Returns the next event, oldest first.
    ///
    /// The log holds 256 events; [`ControllerState::events_lost`] counts the events dropped unread.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.device.record.poll_event()
    }

    /// Pending events, oldest first, each with its number since power-up, from 0. They stay
    /// pending.
    pub fn events(&self) -> impl Iterator<Item = (u64, Event)> {
        self.device.record.log().waiting()
    }

    /// Applies an external event now: a key press, a slipping joint, a pulled cable.
    pub fn inject(&mut self, event: ExternalEvent) {
        self.device.apply_external(event);
        self.device.run_until_idle();
        self.forget_links();
    }

    /// Presses the base key. A short press runs or stops the stored program, a long one homes the
    /// arm.
    pub fn press(&mut self, press: Press) {
        // Keys, hands and faults share one entry, so a script and a caller cause the same.
        self.inject(ExternalEvent::Key(press));
    }

    /// Presses or releases the unlock key on the forearm.
    ///
    /// While it is held the motors are released: the running motion ends, the queue waits,
    /// immediate motions are refused, and [`guide`](Self::guide) moves the arm.
    pub fn unlock(&mut self, held: bool) {
        self.inject(ExternalEvent::Unlock(held));
    }

    /// Moves the arm by hand to these true joint angles, deg, clamped to the limits.
    ///
    /// NaN leaves a joint where it is. Without the unlock key the motors hold the arm.
    ///
    /// ```
    /// let mut arm = magician_sim::Controller::default();
    /// arm.unlock(true);
    /// arm.guide([20.0, 30.0, 40.0, 0.0].into());
    /// arm.unlock(false);
    /// assert_eq!(arm.state().joints.to_array(), [20.0, 30.0, 40.0, 0.0]);
    /// ```
    pub fn guide(&mut self, joints: JointAngles) {
        self.inject(ExternalEvent::Guide(joints));
    }

    /// Moves an object of the world by hand: the middle of its underside to x, y, z, mm.
    ///
    /// The object falls onto whatever is below, and takes along what stands on it. Returns `false`
    /// if there is no object of that name, or if a coordinate is not finite.
    ///
    /// ```
    /// use magician_sim::{Controller, Profile, Scenario, World};
    ///
    /// let scenario = Scenario::from_toml(
    ///     "table = { height = -60 }\nobject = [{ name = 'cube', size = [20, 20, 20], at = [220, 0] }]",
    /// )?;
    /// let mut arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    /// assert!(arm.place("cube", [200.0, 80.0, 0.0]));
    /// let cube = arm.look().object("cube").unwrap().place();
    /// assert_eq!((cube.x, cube.y, cube.z), (200.0, 80.0, -60.0));
    /// assert!(!arm.place("ball", [200.0, 80.0, 0.0]));
    /// # Ok::<(), magician_sim::ScenarioError>(())
    /// ```
    pub fn place(&mut self, name: &str, at: [f64; 3]) -> bool {
        let placed = self.device.place(name, at);
        self.device.run_until_idle();
        placed
    }

    /// Replaces the sheet of paper: all traces of pen and laser are removed.
    ///
    /// ```
    /// use magician_sim::Controller;
    ///
    /// let mut arm = Controller::default();
    /// arm.clear_drawing();
    /// assert!(arm.drawing().is_empty());
    /// ```
    pub fn clear_drawing(&mut self) {
        self.device.clear_drawing();
    }

    /// Returns the arm after a power cycle in another world. Only the contents of its flash
    /// survive.
    #[must_use]
    pub fn switched_on_in(&self, world: World) -> Self {
        let profile = self.device.firmware.profile.clone();
        Self::with_flash(profile, world, self.flash().clone())
    }

    /// Sets an input, address 1 to 20, high or low. A TRIG that waits for it sees it at once.
    ///
    /// Returns `false` if there is no such address.
    pub fn set_input(&mut self, address: u8, level: bool) -> bool {
        // Run at once: a TRIG that is met must not wait for the next byte or deadline.
        let set = self.device.world.set_input(address, level);
        self.device.run_until_idle();
        set
    }

    /// Applies a voltage to an input, address 1 to 20: 0 to 4095 for 0 to 3.3 V, clamped.
    ///
    /// Otherwise like [`set_input`](Self::set_input).
    pub fn set_analog(&mut self, address: u8, value: u16) -> bool {
        let set = self.device.world.set_analog(address, value);
        self.device.run_until_idle();
        set
    }

    /// Like [`advance`](Self::advance), stopping at every instant that the observer asks for.
    pub fn advance_observed(&mut self, to: ArmInstant, observer: &mut impl Observer) {
        // An unlimited budget: this call has no other peers to serve meanwhile.
        while !observer::advance(self, observer, to, &mut SampleBudget::new(u32::MAX)) {}
    }

    /// Drops pending replies after a reset: a restarted controller has forgotten its requests.
    fn forget_links(&mut self) {
        if self.device.take_restarted() {
            self.links.clear();
        }
    }
}
