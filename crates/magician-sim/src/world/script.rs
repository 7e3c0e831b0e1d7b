//! Playback of scripted events: inputs over time, faults, keys and hands.

use magician_motion::JointAngles;

use super::ExternalEvent;
use crate::profile::{PINS, pin_index};
use crate::scenario::{Action, Script};
use crate::{ArmInstant, Micros};

/// Interval at which a hand that moves the arm is updated, us. A choice: the controller's period.
const HAND_PERIOD: Micros = 20_000;

/// Position in the script, and state of the inputs.
#[derive(Clone, Debug)]
pub(super) struct ScriptPlayer {
    /// Next timed action.
    cursor: usize,
    /// True for each index action that was triggered.
    set_off: Vec<bool>,
    /// Triggered actions that are still due, in order of time.
    soon: Vec<(ArmInstant, Action)>,
    hand: Option<Hand>,
    /// Levels and values at the inputs; `None` if nothing is connected.
    digital: [Option<bool>; PINS],
    analog: [Option<u16>; PINS],
}

/// A movement by hand in progress.
#[derive(Clone, Copy, Debug)]
struct Hand {
    from: JointAngles,
    to: JointAngles,
    start: ArmInstant,
    over: Micros,
    /// Part of the movement that was reported.
    told: Micros,
}

impl Hand {
    fn next(&self) -> ArmInstant {
        self.start.after_micros(self.told_next())
    }

    fn told_next(&self) -> Micros {
        self.over.min(self.told.saturating_add(HAND_PERIOD))
    }

    fn at(&self, elapsed: Micros) -> JointAngles {
        let share = elapsed as f64 / self.over as f64;
        let (from, to) = (self.from.to_array(), self.to.to_array());
        let joints = std::array::from_fn(|joint| {
            let (from, to): (f64, f64) = (from[joint], to[joint]);
            // The end is exact, without the rounding of the interpolation.
            if elapsed >= self.over {
                to
            } else {
                from + (to - from) * share
            }
        });
        JointAngles::from(joints)
    }
}

impl ScriptPlayer {
    pub(super) fn new(script: &Script) -> Self {
        let mut player = Self {
            cursor: 0,
            set_off: vec![false; script.at_index.len()],
            soon: Vec::new(),
            hand: None,
            digital: [None; PINS],
            analog: [None; PINS],
        };
        // Values of the inputs at power-up are not changes.
        while let Some((ArmInstant::ZERO, Action::Digital { .. } | Action::Analog { .. })) =
            script.timed.get(player.cursor)
        {
            player.step(script);
        }
        player
    }

    pub(super) fn digital(&self, address: u8) -> Option<bool> {
        self.digital[pin_index(address)?]
    }

    pub(super) fn analog(&self, address: u8) -> Option<u16> {
        self.analog[pin_index(address)?]
    }

    /// True if the script will still change an input.
    pub(super) fn will_change(&self, script: &Script, input: u8) -> bool {
        let rest = script.timed.get(self.cursor..).unwrap_or_default();
        rest.iter().chain(&self.soon).any(|(_, action)| {
            matches!(action, Action::Digital { address, .. } | Action::Analog { address, .. } if *address == input)
        })
    }

    /// Changes an input now. Returns false if there is no such address.
    pub(super) fn override_input(&mut self, now: ArmInstant, action: Action) -> bool {
        let (Action::Digital { address, .. } | Action::Analog { address, .. }) = action else {
            return false;
        };
        if pin_index(address).is_none() {
            return false;
        }
        self.act(now, action);
        self.look_again(now);
        true
    }

    /// Reports that inputs may have changed.
    pub(super) fn look_again(&mut self, now: ArmInstant) {
        let look = (now, Action::Do(ExternalEvent::Input));
        // One report per instant suffices.
        if !self.soon.contains(&look) {
            self.schedule(look.0, look.1);
        }
    }

    /// Triggers the actions of a queued command that has started.
    pub(super) fn index_started(&mut self, script: &Script, now: ArmInstant, index: u64) {
        for (nth, (wanted, delay, action)) in script.at_index.iter().enumerate() {
            let Some(set_off) = self.set_off.get_mut(nth) else {
                continue;
            };
            // Indices start anew after a reset: an action is triggered only once.
            if *wanted == index && !*set_off {
                *set_off = true;
                self.schedule(now.after_micros(*delay), *action);
            }
        }
    }

    fn schedule(&mut self, at: ArmInstant, action: Action) {
        // After those of the same instant: actions keep the order in which they were triggered.
        let place = self.soon.partition_point(|(other, _)| *other <= at);
        self.soon.insert(place, (at, action));
    }

    pub(super) fn next_event(&self, script: &Script) -> Option<ArmInstant> {
        let timed = script.timed.get(self.cursor).map(|(at, _)| *at);
        let soon = self.soon.first().map(|(at, _)| *at);
        let hand = self.hand.map(|hand| hand.next());
        [timed, soon, hand].into_iter().flatten().min()
    }

    /// Performs the earliest action that is due.
    pub(super) fn happen(&mut self, script: &Script, now: ArmInstant) -> Option<ExternalEvent> {
        let at = self.next_event(script).filter(|at| *at <= now)?;
        // The hand first: a key that is released in the same instant must find the arm where it was
        // guided.
        if self.hand.is_some_and(|hand| hand.next() == at) {
            return self.move_hand();
        }
        if self.soon.first().is_some_and(|(soon, _)| *soon == at) {
            let (at, action) = self.soon.remove(0);
            return Some(self.act(at, action));
        }
        self.step(script)
    }

    fn step(&mut self, script: &Script) -> Option<ExternalEvent> {
        let (at, action) = *script.timed.get(self.cursor)?;
        self.cursor += 1;
        Some(self.act(at, action))
    }

    fn act(&mut self, at: ArmInstant, action: Action) -> ExternalEvent {
        match action {
            Action::Do(event) => event,
            Action::Digital { address, level } => {
                if let Some(pin) = pin_index(address) {
                    self.digital[pin] = Some(level);
                }
                ExternalEvent::Input
            }
            Action::Analog { address, value } => {
                if let Some(pin) = pin_index(address) {
                    self.analog[pin] = Some(value);
                }
                ExternalEvent::Input
            }
            Action::Guide { from, to, over } => {
                self.hand = Some(Hand {
                    from,
                    to,
                    start: at,
                    over,
                    told: 0,
                });
                ExternalEvent::Guide(from)
            }
        }
    }

    fn move_hand(&mut self) -> Option<ExternalEvent> {
        let hand = self.hand.as_mut()?;
        hand.told = hand.told_next();
        let joints = hand.at(hand.told);
        if hand.told >= hand.over {
            self.hand = None;
        }
        Some(ExternalEvent::Guide(joints))
    }
}
