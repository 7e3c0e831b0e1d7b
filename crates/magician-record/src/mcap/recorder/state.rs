//! Messages that only a virtual arm can fill, made from its state.

use std::fmt;

use magician_motion::ToolBias;
use magician_protocol::IoFunction;
use magician_sim::{
    Controller, ControllerState, Event, PinState, QueueState, StepperState, ToolOutput,
};
use serde::Serialize;

use crate::mcap::message::{Log, Time, Vector3};

/// A value with the time at which it holds.
#[derive(Serialize)]
pub(super) struct At<'a, T> {
    timestamp: Time,
    #[serde(flatten)]
    value: &'a T,
}

impl From<ToolBias> for Vector3 {
    fn from(bias: ToolBias) -> Self {
        let ToolBias { x, y, z } = bias;
        Self { x, y, z }
    }
}

#[derive(Serialize)]
pub(super) struct Queue {
    timestamp: Time,
    capacity: usize,
    waiting: usize,
    running: Option<u64>,
    running_id: Option<u8>,
    current_index: u64,
    started: bool,
    held: bool,
    overflows: u64,
}

impl Queue {
    pub(super) fn new(timestamp: Time, queue: &QueueState) -> Self {
        Self {
            timestamp,
            capacity: queue.capacity,
            waiting: queue.waiting,
            running: queue.running,
            running_id: queue.running_id,
            current_index: queue.current_index,
            started: queue.started,
            held: queue.held,
            overflows: queue.overflows,
        }
    }
}

/// Tools, pins and stepper outputs.
#[derive(Clone, PartialEq, Serialize)]
pub(super) struct Io {
    suction: Switch,
    gripper: Switch,
    holding: bool,
    laser: bool,
    laser_power: f64,
    /// Pins with a function, level, frequency or duty cycle.
    pins: Vec<Pin>,
    /// Pulses per second.
    steppers: [f64; 2],
}

#[derive(Clone, PartialEq, Serialize)]
struct Pin {
    address: u8,
    function: u8,
    able: bool,
    level: bool,
    frequency: f32,
    duty_cycle: f32,
    high: Option<f64>,
    input: bool,
    analog: u16,
}

impl Pin {
    fn of(pin: &PinState) -> Option<Self> {
        let is_set = pin.function != IoFunction::None
            || pin.level
            || pin.frequency != 0.0
            || pin.duty_cycle != 0.0;
        is_set.then(|| Self {
            address: pin.address,
            function: pin.function.into(),
            able: pin.able,
            level: pin.level,
            frequency: finite(pin.frequency),
            duty_cycle: finite(pin.duty_cycle),
            high: pin.signal.share(),
            input: pin.input,
            analog: pin.analog,
        })
    }
}

/// Replaces NaN and infinity, which JSON cannot express, by 0, which is how the arm treats them.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

#[derive(Clone, Copy, PartialEq, Serialize)]
struct Switch {
    commanded: bool,
    reached: bool,
}

impl From<ToolOutput> for Switch {
    fn from(output: ToolOutput) -> Self {
        Self {
            commanded: output.commanded,
            reached: output.reached,
        }
    }
}

impl Io {
    pub(super) fn of(arm: &Controller, state: &ControllerState) -> Self {
        let rate = |stepper: StepperState| stepper.pulses_per_second;
        Self {
            suction: state.suction.into(),
            gripper: state.gripper.into(),
            holding: state.holding,
            laser: state.laser,
            laser_power: state.laser_power,
            pins: arm.pins().iter().filter_map(Pin::of).collect(),
            steppers: arm.steppers().map(rate),
        }
    }

    pub(super) fn at(&self, timestamp: Time) -> At<'_, Self> {
        At {
            timestamp,
            value: self,
        }
    }
}

/// State of the arm as a whole.
#[derive(Clone, PartialEq, Serialize)]
pub(super) struct Status {
    moving: bool,
    homed: bool,
    unlocked: bool,
    program: bool,
    awaits_input: Option<u8>,
    plugged: bool,
    tool: Vector3,
    not_simulated: u64,
    events_lost: u64,
}

impl Status {
    pub(super) fn of(state: &ControllerState) -> Self {
        Self {
            moving: state.moving,
            homed: state.homed,
            unlocked: state.unlocked,
            program: state.program,
            awaits_input: state.awaits_input,
            plugged: state.line.plugged,
            tool: state.tool.into(),
            not_simulated: state.not_simulated,
            events_lost: state.events_lost,
        }
    }

    pub(super) fn at(&self, timestamp: Time) -> At<'_, Self> {
        At {
            timestamp,
            value: self,
        }
    }
}

impl Log {
    const DEBUG: u8 = 1;

    pub(super) fn event(timestamp: Time, event: &Event, text: impl fmt::Display) -> Self {
        let level = match event {
            Event::Accepted { .. } | Event::Started { .. } | Event::Assumes { .. } => Self::DEBUG,
            Event::QueueFull { .. }
            | Event::Refused { .. }
            | Event::AlarmRaised { .. }
            | Event::ToolUnknown { .. }
            | Event::HomeOutOfReach
            | Event::Slipped { .. }
            | Event::Reset
            | Event::Cable { plugged: false }
            | Event::NotSimulated { .. }
            | Event::BadFrame { .. }
            | Event::UnknownId { .. }
            | Event::Overrun { .. } => Self::WARNING,
            // Everything else belongs to a normal run.
            _ => Self::INFO,
        };
        Self::new(timestamp, level, text.to_string())
    }

    pub(super) fn missed(timestamp: Time, count: u64) -> Self {
        let message = format!("{count} events are missing here");
        Self::new(timestamp, Self::WARNING, message)
    }
}
