//! `suction`, `gripper`, `laser`: the tools, at once.

use clap::{Args, ValueEnum};
use magician::{Ctrl, Set, words};
use magician_protocol::{MAX_PARAMS, Writer};
use serde::Serialize;

use crate::context::Context;
use crate::failure::Failure;

/// Switch the suction cup
#[derive(Args, Debug)]
pub(crate) struct Suction {
    state: Switch,
}

/// Open or close the gripper, or switch its pump off
#[derive(Args, Debug)]
pub(crate) struct Gripper {
    state: Grip,
}

/// Switch the laser
#[derive(Args, Debug)]
#[command(after_help = "Wear goggles for the laser's wavelength. To switch it on needs --yes.")]
pub(crate) struct Laser {
    state: Switch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
enum Switch {
    /// Switch it on
    On,
    /// Switch it off
    Off,
}

#[derive(Clone, Copy, Debug, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
enum Grip {
    /// Let go
    Open,
    /// Hold
    Close,
    /// Switch the pump off: the gripper goes limp
    Off,
}

#[derive(Serialize)]
struct Answer<T> {
    state: T,
}

impl Suction {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let command = words::suction(self.state == Switch::On);
        switch(context, "suction", self.state, command)
    }
}

impl Gripper {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let command = match self.state {
            Grip::Open => words::release(),
            Grip::Close => words::grip(),
            Grip::Off => words::pump_off(),
        };
        switch(context, "gripper", self.state, command)
    }
}

impl Laser {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.state == Switch::On && !context.global.yes {
            let message = "a laser can blind and set fire; nothing was sent";
            return Err(Failure::usage(message).hint("give --yes if everybody wears goggles"));
        }
        switch(
            context,
            "laser",
            self.state,
            words::laser(self.state == Switch::On),
        )
    }
}

fn switch<T>(context: &mut Context, name: &str, state: T, command: Set) -> Result<(), Failure>
where
    T: Copy + Serialize + ValueEnum,
{
    context.with_arm(async |arm, _| at_once(arm, &command).await)?;
    let word = state.to_possible_value();
    let word = word.as_ref().map_or("", |value| value.get_name());
    context.show(&Answer { state }, |out| {
        out.line(format_args!("{name}: {word}"))
    })
}

/// Sends a command past the queue.
pub(crate) async fn at_once(arm: &magician::Arm, command: &Set) -> Result<(), Failure> {
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    command.encode(&mut writer);
    let count = writer.finish().map_err(magician::Error::from)?;
    let params = params.get(..count).unwrap_or_default();
    arm.raw(command.row().id, Ctrl::SET, params).await?;
    Ok(())
}
