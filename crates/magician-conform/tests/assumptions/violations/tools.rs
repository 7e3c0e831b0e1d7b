//! Waiting, pins, tools and sensors.

use magician_protocol::commands::*;
use magician_protocol::{IoFunction, Request};
use magician_sim::fidelity::Assumption as A;

use super::{empty, ignores, ignores_ids, profile, reports, requests, sets};
use crate::arm::{Fate, Violation, tell};

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        // A wait counts from its queueing, and is over by its turn.
        A::Wait => sets(|arm, set, queued| {
            if let Set::WaitCmd(wait) = set
                && queued
                && arm.state().queue.running.is_some()
            {
                wait.timeout = 0;
            }
        }),
        A::Trigger => ignores_ids(&[120]),
        A::MeaninglessTrigger => sets(|_, set, _| match set {
            Set::TrigCmd(trigger) if trigger.address > 20 => {
                *set = Set::WaitCmd(WaitCmd { timeout: 1_000_000 });
            }
            _ => {}
        }),
        A::ImmediateWait => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Set(Set::WaitCmd(_) | Set::TrigCmd(_))) => Fate::Unanswered,
            _ => Fate::Taken,
        }),
        // Codes as in the vendor's document.
        A::IoFunctions => sets(|_, set, _| {
            if let Set::IoMultiplexing(pin) = set {
                pin.multiplex = match pin.multiplex {
                    IoFunction::DigitalOutput => IoFunction::Pwm,
                    IoFunction::Pwm => IoFunction::DigitalOutput,
                    other => other,
                };
            }
        }),
        A::PinTable => profile(|profile| {
            for pin in &mut profile.io.pins {
                pin.digital_input = false;
                pin.analog_input = false;
            }
        }),
        A::LackingFunction => profile(|profile| profile.io.strict = true),
        A::IoOutputs => ignores_ids(&[131, 132]),
        A::IoInputs => reports::<IoDi>(|_, input| input.level = (!input.level.is_on()).into()),
        A::OpenInput => reports::<IoDi>(|_, input| input.level = true.into()),
        A::LastPin => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Get(
                Get::IoDo(GetIoDo { address: None }) | Get::IoDi(GetIoDi { address: None }),
            )) => empty(frame),
            _ => Fate::Taken,
        }),
        A::Steppers => sets(|_, set, _| match set {
            Set::EMotor(motor) => motor.speed /= 2,
            Set::EMotorS(motor) => motor.speed /= 2,
            _ => {}
        }),
        // The motor turns without waiting for its turn in the queue.
        A::StepperDistance => sets(|arm, set, queued| {
            if queued && matches!(set, Set::EMotorS(_)) {
                tell(arm, set);
                *set = Set::WaitCmd(WaitCmd { timeout: 0 });
            }
        }),
        // Other pins: nothing is connected to them.
        A::ToolPins => ignores(|_, set, _| match set {
            Set::IoDo(IoDo { address, .. }) => [2, 4, 16, 17].contains(address),
            _ => false,
        }),
        A::Sensors => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Set(Set::SetColorSensor(_) | Set::SetIrSwitch(_))) => Fate::Ignored,
            _ => Fate::Taken,
        }),
        A::InfraredPort => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Get(Get::IrSwitch(GetIrSwitch { port: None }))) => empty(frame),
            _ => Fate::Taken,
        }),
        A::Tools => ignores_ids(&[61, 62, 63]),
        A::VacuumDelay => profile(|profile| profile.tools.vacuum_delay = 0.6),
        A::GripperDelay => profile(|profile| profile.tools.gripper_delay = 1.0),
        _ => return None,
    })
}
