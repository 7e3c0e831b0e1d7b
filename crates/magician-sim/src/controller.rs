//! The controller as its owner sees it.

use magician_motion::{ArmModel, JointAngles, ToolBias};
use magician_protocol::{Event as Found, FrameBuf};

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

    /// Switches on an arm whose flash keeps what an arm kept before: power comes back.
    #[must_use]
    pub fn with_flash(profile: Profile, world: World, flash: Flash) -> Self {
        Self {
            links: Links::default(),
            device: Device::switched_on(profile, world, flash),
        }
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
        self.device.had_tool(tool);
        self
    }

    /// Tells the arm apart from those at other places: its serial number follows from the place, unless its profile, its flash or
    /// a host has given it one of its own. `number` is the arm's among [several](crate::Identity::numbered), if it is one of several.
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

    /// Gives the arm this serial number under the rule of [`identify_at`](Self::identify_at).
    pub fn identify_as(&mut self, serial: String, number: Option<u32>) {
        let usual = Identity::default();
        let usual = number.map_or(usual.clone(), |number| usual.numbered(number));
        if self.serial() == usual.serial {
            self.device.had_serial(serial);
        }
    }

    /// Its serial number.
    #[must_use]
    pub fn serial(&self) -> String {
        self.flash().serial.device_sn.to_string()
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
        self.device.stood_at(joints);
        self
    }

    /// The arm's clock: microseconds since power-up.
    #[must_use]
    pub fn now(&self) -> ArmInstant {
        self.device.now
    }

    /// The numbers by which it plans motions.
    #[must_use]
    pub fn arm_model(&self) -> &ArmModel {
        &self.device.firmware.model
    }

    /// The world around the arm.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.device.world
    }

    /// The world around the arm at the present instant: where its objects are, and what the tool holds.
    #[must_use]
    pub fn look(&self) -> WorldView<'_> {
        let Device {
            now, motion, world, ..
        } = &self.device;
        world.look(*now, &motion.true_pose(*now))
    }

    /// What pen and laser have left by now.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        let Device {
            now, motion, world, ..
        } = &self.device;
        motion.drawing(*now, world)
    }

    /// What the arm keeps without power.
    #[must_use]
    pub fn flash(&self) -> &Flash {
        self.device.store.flash()
    }

    /// How often the flash has been written since power-up, a reset included: it has changed only if this has.
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

    /// The stepper outputs, 1 and 2.
    #[must_use]
    pub fn steppers(&self) -> [StepperState; 2] {
        self.device.io.steppers.states(self.device.now)
    }

    /// The state of the cable, for the code that carries the bytes.
    #[must_use]
    pub fn line(&self) -> LineState {
        self.device.line
    }

    /// What the answers have rested on since power-up, resets included.
    #[must_use]
    pub fn fidelity(&self) -> &Fidelity {
        self.device.record.fidelity()
    }

    /// Everything about the arm at the present instant.
    #[must_use]
    pub fn state(&self) -> ControllerState {
        ControllerState::of(&self.device)
    }

    /// The index of the queued command that was finished last.
    #[must_use]
    pub fn current_index(&self) -> u64 {
        self.device.queues.hosts().current()
    }

    /// Whether a motion without an end of its own runs: a jog.
    #[must_use]
    pub fn jogging(&self) -> bool {
        self.device.motion.is_jogging()
    }

    /// Whether the arm does something that ends by itself, a motion or a WAIT, or waits for an input that the scenario will change. A jog does not end
    /// by itself, a motor that runs on is no work of the arm's, and what a scenario says happens to an idle arm.
    #[must_use]
    pub fn busy(&self) -> bool {
        self.device.is_busy()
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
        let Self { links, device } = self;
        let heard = match input {
            [] => links.known(link),
            _ => Some(links.heard(link)),
        };
        let Some(peer) = heard else { return false };
        let Link { deframer, outbox } = peer;
        while let Some(found) = deframer.next(input) {
            match found {
                Found::Frame { frame, .. } => {
                    if !outbox.has_room() {
                        device.record.event(Event::Overrun { link });
                    } else if let Some(reply) = device.answer(link, &frame) {
                        outbox.push(&reply);
                    }
                    return true;
                }
                Found::Rejected { .. } => {
                    device.record.event(Event::BadFrame { link });
                    device.record.assume(Assumption::DamagedFrame);
                }
                Found::Noise { .. } => device.record.assume(Assumption::ForeignBytes),
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

    /// The same arm, with no peer on any link: as if all had [closed](Self::close).
    #[must_use]
    pub fn without_peers(mut self) -> Self {
        self.links.clear();
        self
    }

    /// Lets the arm's time pass up to `to`; an instant that has passed changes nothing.
    pub fn advance(&mut self, to: ArmInstant) {
        self.device.advance(to);
        self.forget_links();
    }

    /// The instant of the arm's clock at which something next happens by itself: the end of a motion, of a wait.
    /// `None` when nothing is scheduled.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<ArmInstant> {
        self.device.next_event()
    }

    /// The next reply to a link, oldest first.
    pub fn poll_transmit(&mut self, link: LinkId) -> Option<FrameBuf> {
        self.links.known(link)?.outbox.pop()
    }

    /// Takes bytes as [`receive`](Self::receive) does, and returns every reply that then waits for the link, oldest first.
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

    /// The next event, oldest first. At most 256 are kept; [`ControllerState::events_lost`] counts those that were not read in
    /// time.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.device.record.poll_event()
    }

    /// The events that wait to be polled, oldest first, each with its number, counted from 0 at power-up. Looking at
    /// them does not take them.
    pub fn events(&self) -> impl Iterator<Item = (u64, Event)> {
        self.device.record.log().waiting()
    }

    /// Lets something happen to the arm now: a key is pressed, a joint slips, the cable is pulled.
    pub fn inject(&mut self, event: ExternalEvent) {
        self.device.apply_external(event);
        self.device.run_until_idle();
        self.forget_links();
    }

    /// Presses the base key: short, it runs the program in the flash or stops it; long, it homes the arm.
    pub fn press(&mut self, press: Press) {
        self.inject(ExternalEvent::Key(press));
    }

    /// Presses or releases the unlock key on the forearm. While it is held the motors are released: what moves ends,
    /// the queue waits, immediate motions are refused, and [`guide`](Self::guide) moves the arm.
    pub fn unlock(&mut self, held: bool) {
        self.inject(ExternalEvent::Unlock(held));
    }

    /// Moves the arm by hand to where its joints really are to stand, deg, as far as the limits let it; what is not a
    /// number stays. Without the unlock key the motors hold it where it is.
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

    /// Puts an object of the world somewhere, by hand: the middle of its underside at x, y, z, mm. It falls onto what is below,
    /// and what stands on it comes along. `false` if there is no object of that name, or the place is no place.
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

    /// Lays a new sheet of paper: what pen and laser have left so far is gone.
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

    /// The arm after its power was switched off and on again, in another world: what its flash keeps is all it knows.
    #[must_use]
    pub fn switched_on_in(&self, world: World) -> Self {
        let profile = self.device.firmware.profile.clone();
        Self::with_flash(profile, world, self.flash().clone())
    }

    /// Drives an input, address 1 to 20, high or low from now on; a TRIG that waits for it sees it at once. `false` if
    /// there is no such address.
    pub fn set_input(&mut self, address: u8, level: bool) -> bool {
        let set = self.device.world.set_input(address, level);
        self.device.run_until_idle();
        set
    }

    /// Puts a voltage on an input, address 1 to 20: 0 to 4095 for 0 to 3.3 V, more counts as 4095. As
    /// [`set_input`](Self::set_input) otherwise.
    pub fn set_analog(&mut self, address: u8, value: u16) -> bool {
        let set = self.device.world.set_analog(address, value);
        self.device.run_until_idle();
        set
    }

    /// As [`advance`](Self::advance), by way of every instant that the observer is to see.
    pub fn advance_observed(&mut self, to: ArmInstant, observer: &mut impl Observer) {
        while !observer::advance(self, observer, to, &mut SampleBudget::new(u32::MAX)) {}
    }

    /// After a reset no reply is due.
    fn forget_links(&mut self) {
        if self.device.take_restarted() {
            self.links.clear();
        }
    }
}
