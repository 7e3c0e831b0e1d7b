//! `suction`, `gripper`: switch the tools immediately.

use clap::{Args, ValueEnum};
use magician::{Set, build};
use serde::Serialize;

use crate::context::{Context, StopPolicy};
use crate::failure::Failure;

/// Switch the suction cup
#[derive(Args, Debug)]
pub(crate) struct Suction {
    /// State to set
    state: Switch,
}

/// Open or close the gripper, or switch its pump off
#[derive(Args, Debug)]
pub(crate) struct Gripper {
    /// State to set
    state: Grip,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(super) enum Switch {
    /// Switch it on
    On,
    /// Switch it off
    Off,
}

#[derive(Clone, Copy, Debug, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
enum Grip {
    /// Open the gripper
    Open,
    /// Close the gripper
    Close,
    /// Switch the pump off; the gripper goes limp
    Off,
}

#[derive(Serialize)]
struct SwitchReport<T> {
    state: T,
}

impl Suction {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let command = build::suction(self.state == Switch::On);
        switch(context, "suction", self.state, command)
    }
}

impl Gripper {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let command = match self.state {
            Grip::Open => build::release(),
            Grip::Close => build::grip(),
            Grip::Off => build::pump_off(),
        };
        switch(context, "gripper", self.state, command)
    }
}

fn switch<T>(context: &mut Context, name: &str, state: T, command: Set) -> Result<(), Failure>
where
    T: Copy + Serialize + ValueEnum,
{
    context.arm(StopPolicy::Order, async |arm, _| {
        Ok(arm.set_any(&command).await?)
    })?;
    show(context, name, state)
}

/// Reports the new state.
pub(super) fn show<T>(context: &mut Context, name: &str, state: T) -> Result<(), Failure>
where
    T: Copy + Serialize + ValueEnum,
{
    let word = state.to_possible_value();
    let word = word.as_ref().map_or("", |value| value.get_name());
    context.show(&SwitchReport { state }, |out| {
        out.line(format_args!("{name}: {word}"))
    })
}
