//! The command line: global options and the verbs.

use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::{Args, CommandFactory, Parser, Subcommand};
use magician::faults::Faults;
use magician_motion::ToolBias;

use crate::context::Context;
use crate::failure::Failure;
use crate::verbs::{
    alarms, bench, calibrate, commands, completions, config, conform, convert, conveyor, decode,
    demo, doctor, draw, engrave, enqueue, forward, get, help, home, info, inverse, io, jog, laser,
    man, play, ports, pose, proxy, queue, rail, record, replay, run, sensor, set, shell, sim, stop,
    teach, tools, travel, watch,
};

/// Work with a Dobot Magician arm: find it, look, move it, or do without one.
#[derive(Debug, Parser)]
#[command(
    name = "magician",
    bin_name = "magician",
    disable_version_flag = true,
    disable_help_subcommand = true,
    args_override_self = true,
    arg_required_else_help = true,
    subcommand_value_name = "VERB",
    subcommand_help_heading = "Verbs",
    after_help = "Lengths are mm, angles degrees, times seconds. `magician help NAME` explains a verb or a \
                  command of the protocol."
)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,

    /// Print the version
    #[arg(short = 'V', long)]
    pub(crate) version: bool,

    #[command(subcommand)]
    pub(crate) verb: Option<Verb>,
}

impl Cli {
    /// Reads a command line; the first argument is the program's name.
    pub(crate) fn read(arguments: &[OsString]) -> Result<Self, clap::Error> {
        Self::try_parse_from(arguments)
    }

    /// The command line's description, for completions, manual pages and help.
    pub(crate) fn description() -> clap::Command {
        let mut command = Self::command();
        command.build();
        command
    }
}

/// Options of every verb.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options of every verb")]
pub(crate) struct Global {
    /// Where the arm is: `/dev/ttyUSB0`, `COM3`, `usb:VENDOR:PRODUCT[:SERIAL]`, `arm:SERIAL`,
    /// `udp:HOST[:PORT]`, `tcp:HOST:PORT`, or `sim[:SPEED]` for a virtual arm; if not given, the one of
    /// `magician config`, else the one arm found
    #[arg(
        short,
        long,
        global = true,
        env = "MAGICIAN_PORT",
        hide_env_values = true,
        value_name = "PORT"
    )]
    pub(crate) port: Option<String>,

    /// Print JSON: one object, or one a line
    #[arg(long, global = true)]
    pub(crate) json: bool,

    /// Do what is dangerous without asking
    #[arg(long, global = true)]
    pub(crate) yes: bool,

    /// Seconds to wait for each answer of the arm
    #[arg(long, global = true, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) timeout: Option<Duration>,

    /// Requests in flight at once, 1 to 8; more than 1 for an arm of which `magician doctor` has found that it takes
    /// them
    #[arg(
        long,
        global = true,
        env = "MAGICIAN_WINDOW",
        hide_env_values = true,
        value_name = "N",
        value_parser = window
    )]
    pub(crate) window: Option<u8>,

    /// Write what passes between this program and the arm to a pcapng file, to look at or to send with a bug report;
    /// if it cannot be written any more the work goes on, and the exit status is 4
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) trace: Option<PathBuf>,

    /// Spoil the line to the arm, for tests; `magician proxy --help` has the rates
    #[arg(long, global = true, value_name = "SPEC", hide = true)]
    pub(crate) faults: Option<Faults>,

    /// Say more on stderr; more often, more still
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Ports(ports::Ports),
    Info(info::Info),
    Pose(pose::Pose),
    Home(home::Home),
    Move(travel::Move),
    Jog(jog::Jog),
    Record(record::Record),
    Calibrate(calibrate::Calibrate),
    Teach(teach::Teach),
    Run(Box<run::Run>),
    Draw(Box<draw::Draw>),
    Engrave(Box<engrave::Verb>),
    Play(Box<play::Play>),
    Convert(Box<convert::Convert>),
    Watch(watch::Watch),
    Stop(stop::Stop),
    Suction(tools::Suction),
    Gripper(tools::Gripper),
    Laser(laser::Laser),
    Io(io::Io),
    Sensor(sensor::Sensor),
    Rail(rail::Rail),
    Conveyor(conveyor::Conveyor),
    Alarms(alarms::Alarms),
    Queue(queue::Queue),
    Get(get::Get),
    Set(set::Set),
    Enqueue(enqueue::Enqueue),
    Shell(shell::Shell),
    Demo(demo::Demo),
    Sim(Box<sim::Sim>),
    Proxy(Box<proxy::Proxy>),
    Conform(conform::Conform),
    Doctor(doctor::Doctor),
    Bench(bench::Bench),
    Commands(commands::Commands),
    Decode(decode::Decode),
    Replay(replay::Replay),
    Forward(forward::Forward),
    Inverse(inverse::Inverse),
    Config(config::Show),
    Completions(completions::Completions),
    Man(man::Man),
    Help(help::Help),
}

impl Verb {
    /// Does it.
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        match self {
            Self::Ports(verb) => verb.run(context),
            Self::Info(verb) => verb.run(context),
            Self::Pose(verb) => verb.run(context),
            Self::Home(verb) => verb.run(context),
            Self::Move(verb) => verb.run(context),
            Self::Jog(verb) => verb.run(context),
            Self::Teach(verb) => verb.run(context),
            Self::Run(verb) => verb.run(context),
            Self::Draw(verb) => verb.run(context),
            Self::Engrave(verb) => verb.run(context),
            Self::Play(verb) => verb.run(context),
            Self::Convert(verb) => verb.run(context),
            Self::Watch(verb) => verb.run(context),
            Self::Stop(verb) => verb.run(context),
            Self::Suction(verb) => verb.run(context),
            Self::Gripper(verb) => verb.run(context),
            Self::Laser(verb) => verb.run(context),
            Self::Io(verb) => verb.run(context),
            Self::Sensor(verb) => verb.run(context),
            Self::Rail(verb) => verb.run(context),
            Self::Conveyor(verb) => verb.run(context),
            Self::Alarms(verb) => verb.run(context),
            Self::Queue(verb) => verb.run(context),
            Self::Get(verb) => verb.run(context),
            Self::Set(verb) => verb.run(context),
            Self::Enqueue(verb) => verb.run(context),
            Self::Shell(verb) => verb.run(context),
            Self::Demo(verb) => verb.run(context),
            Self::Sim(verb) => verb.run(context),
            Self::Proxy(verb) => verb.run(context),
            Self::Conform(verb) => verb.run(context),
            Self::Doctor(verb) => verb.run(context),
            Self::Bench(verb) => verb.run(context),
            Self::Commands(verb) => verb.run(context),
            Self::Decode(verb) => verb.run(context),
            Self::Record(verb) => verb.run(context),
            Self::Replay(verb) => verb.run(context),
            Self::Calibrate(verb) => verb.run(context),
            Self::Forward(verb) => verb.run(context),
            Self::Inverse(verb) => verb.run(context),
            Self::Config(verb) => verb.run(context),
            Self::Completions(verb) => verb.run(context),
            Self::Man(verb) => verb.run(context),
            Self::Help(verb) => verb.run(context),
        }
    }
}

/// Seconds above 0, with a fraction if need be.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.strip_suffix('s').unwrap_or(text).parse::<f64>();
    value
        .ok()
        .filter(|value| *value > 0.0)
        .and_then(|value| Duration::try_from_secs_f64(value).ok())
        .ok_or_else(|| "expected seconds above 0, such as 0.5".to_owned())
}

/// A request window. An empty variable says nothing, as an empty port does.
fn window(text: &str) -> Result<u8, String> {
    let value = if text.is_empty() { Ok(1) } else { text.parse() };
    let value = value.ok().filter(|value| (1..=8).contains(value));
    value.ok_or_else(|| "expected 1 to 8, here or in MAGICIAN_WINDOW".to_owned())
}

/// A number with a fraction if need be.
pub(crate) fn number<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

/// A tool by name, or its bias as X,Y,Z in mm.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tool(pub(crate) ToolBias);

/// The tool that a calculation is for.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ToolOption {
    /// Tool: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm
    #[arg(
        long,
        value_name = "NAME|X,Y,Z",
        default_value = "none",
        allow_hyphen_values = true
    )]
    pub(crate) tool: Tool,
}

impl FromStr for Tool {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(bias) = ToolBias::named(text) {
            return Ok(Self(bias));
        }
        let numbers: Result<Vec<f64>, _> =
            text.split(',').map(|part| part.trim().parse()).collect();
        match numbers.as_deref() {
            Ok([x, y, z]) if [x, y, z].iter().all(|number| number.is_finite()) => {
                Ok(Self(ToolBias::new(*x, *y, *z)))
            }
            _ => {
                let names: Vec<_> = ToolBias::NAMED.iter().map(|(name, _)| *name).collect();
                Err(format!(
                    "expected X,Y,Z in mm, or one of {}",
                    names.join(", ")
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_contradicts_itself_nowhere() {
        Cli::command().debug_assert();
    }

    #[test]
    fn tools_by_name_and_by_bias() {
        assert_eq!(
            "Suction".parse::<Tool>().map(|tool| tool.0),
            Ok(ToolBias::SUCTION)
        );
        let bias = "-1, 2,3.5".parse::<Tool>().map(|tool| tool.0);
        assert_eq!(bias, Ok(ToolBias::new(-1.0, 2.0, 3.5)));
        for wrong in ["hammer", "1,2", "1,2,x", "1,2,nan", ""] {
            assert!(wrong.parse::<Tool>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn windows_are_1_to_8() {
        assert_eq!(
            (window("1"), window("8"), window("")),
            (Ok(1), Ok(8), Ok(1))
        );
        for wrong in ["0", "9", "-1", "300", "x", "1.5"] {
            assert!(
                window(wrong).unwrap_err().contains("MAGICIAN_WINDOW"),
                "{wrong}"
            );
        }
    }

    #[test]
    fn seconds_are_above_zero() {
        assert_eq!(seconds("0.5s"), Ok(Duration::from_millis(500)));
        for wrong in ["0", "-1", "nan", "inf", "1e30", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
