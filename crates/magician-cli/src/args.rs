//! The command line as a whole: its verbs, how they are parsed, and how each is dispatched.
//!
//! [`Cli`] is parsed by clap in two steps that clap alone does not offer: the virtual arm's
//! `--tool` is added to the verbs in [`ARM_VERBS`] after the derive, and `-h` renders the
//! brief help of `brief` instead of the full one. Lines of a shell are parsed by the same code,
//! without the environment.
//!
//! Only `main` and `lib` sit above this module. Options that verbs share are in `options`; verbs
//! that show the command line itself (`help`, `completions`, `man`, `shell`) get it through
//! [`Context`].

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};
use magician_motion::ToolBias;

use crate::brief::brief;
use crate::context::{CommandLine, Context};
use crate::failure::{Failure, Kind};
use crate::named_files::NamedFiles;
use crate::options::{Global, TOOL};
use crate::output::{Output, Text};
use crate::verbs::{
    alarms, bench, calibrate, commands, completions, config, conform, convert, conveyor, decode,
    demo, doctor, draw, engrave, enqueue, fleet, forward, frame, get, help, home, info, inverse,
    io, jog, laser, man, play, ports, pose, preset, proxy, queue, rail, record, replay, run,
    sensor, serve, set, shell, sim, site, station, stop, teach, testgrid, tools, travel, version,
    watch, write,
};
use crate::voice::set_running_verb;

/// Argument id of the option that chooses the tool of a virtual arm.
const VIRTUAL_TOOL: &str = "virtual_tool";

const VIRTUAL_TOOL_HELP: &str = "Tool of the virtual arm (`--port sim`): none, suction, gripper, \
        pen, laser, or its bias X,Y,Z in mm [default: suction]";

/// Verbs that get `--tool` for a virtual arm. Verbs that draw have a `--tool` of their own, which
/// applies to any arm.
const ARM_VERBS: &[&str] = &[
    "info", "pose", "home", "jog", "record", "watch", "stop", "suction", "gripper", "laser", "io",
    "sensor", "rail", "conveyor", "alarms", "queue", "get", "set", "enqueue", "shell", "demo",
];

/// Control a Dobot Magician arm or a virtual one
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
    after_help = "Lengths are in mm, angles in degrees, times in seconds. `magician help NAME` \
        explains a verb, a protocol command or a topic."
)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,

    /// Print the version
    #[arg(short = 'V', long)]
    pub(crate) version: bool,

    #[command(subcommand)]
    pub(crate) verb: Option<Verb>,

    #[arg(skip)]
    files: NamedFiles,
}

/// Access to the whole command line for verbs that show it or run lines of it.
pub(crate) const COMMAND_LINE: CommandLine = CommandLine {
    description: Cli::description,
    follow: run_shell_line,
};

impl Cli {
    /// Runs the command line, then ends the connection: motions it started continue after success
    /// and are stopped after a failure.
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let outcome = self.follow(context);
        context.finish(outcome)
    }

    /// True for a station or a hub, which runs unattended and reports its state on stderr.
    pub(crate) fn serves(&self) -> bool {
        match &self.verb {
            Some(Verb::Serve(_) | Verb::Studio(_)) => true,
            Some(Verb::Fleet(fleet)) => fleet.serves(),
            _ => false,
        }
    }

    /// Runs the command line and keeps the connection open.
    fn follow(self, context: &mut Context) -> Result<(), Failure> {
        self.check_files()?;
        context.begin(self.global);
        let outcome = match self.verb {
            _ if self.version => version::run(context),
            Some(verb) => verb.run(context),
            None => Err(Failure::usage("no verb given").hint("`magician --help` lists them")),
        };
        outcome.and(context.out.flush())
    }

    /// Refuses to overwrite a file that the same command line names as an input or another output.
    pub(crate) fn check_files(&self) -> Result<(), Failure> {
        self.files.check(self.global.trace.as_deref())
    }

    /// Parses a command line; the first argument is the program's name.
    pub(crate) fn parse(arguments: &[OsString]) -> Result<Self, clap::Error> {
        Self::parse_with(Self::with_virtual_tool(), arguments)
    }

    /// Parses one line of a shell. Environment variables are ignored here: the shell has read them
    /// already.
    pub(crate) fn parse_line(arguments: &[OsString]) -> Result<Self, clap::Error> {
        let without_env = |arg: Arg| arg.env(None::<&'static str>);
        Self::parse_with(Self::with_virtual_tool().mut_args(without_env), arguments)
    }

    fn parse_with(command: clap::Command, arguments: &[OsString]) -> Result<Self, clap::Error> {
        let mut command = help::grouped(command);
        let arguments: Vec<_> = arguments.iter().map(escape_negative).collect();
        let matches = match command.try_get_matches_from_mut(&arguments) {
            Err(error)
                if error.kind() == ErrorKind::DisplayHelp && has_short_help_flag(&arguments) =>
            {
                let brief = brief(command).try_get_matches_from(arguments);
                return Err(brief.err().unwrap_or(error));
            }
            Err(mut error) if error.kind() == ErrorKind::UnknownArgument => {
                suggest_verbs_with_flag(&command, &mut error);
                return Err(error);
            }
            matches => matches?,
        };
        let mut cli =
            Self::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
        let (mut verb, mut chosen) = (&command, &matches);
        while let Some((name, next)) = chosen.subcommand()
            && let Some(own) = verb.find_subcommand(name)
        {
            (verb, chosen) = (own, next);
        }
        set_running_verb(verb);
        let verb = matches.subcommand().map(|(_, verb)| verb);
        let tool = verb.and_then(|verb| verb.try_get_one::<ToolBias>(VIRTUAL_TOOL).ok().flatten());
        cli.global.virtual_tool = tool.copied();
        cli.files = NamedFiles::of(&matches);
        Ok(cli)
    }

    /// Returns the built clap command, for completions, manual pages and help.
    pub(crate) fn description() -> clap::Command {
        let mut command = Self::with_virtual_tool();
        command.build();
        command
    }

    /// Returns the clap command with `--tool` added to the verbs in [`ARM_VERBS`].
    fn with_virtual_tool() -> clap::Command {
        let tool = Arg::new(VIRTUAL_TOOL)
            .long("tool")
            .value_name(TOOL)
            .value_parser(clap::value_parser!(ToolBias))
            .allow_hyphen_values(true)
            .help(VIRTUAL_TOOL_HELP);
        Self::command().mut_subcommands(|verb| {
            if ARM_VERBS.contains(&verb.get_name()) {
                verb.arg(tool.clone())
            } else {
                verb
            }
        })
    }
}

/// Runs one line of a shell that was started with the options in `session`.
fn run_shell_line(
    arguments: &[OsString],
    session: &Global,
    context: &mut Context,
) -> Result<(), Failure> {
    let json = session.json || has_json_flag(arguments);
    let mut cli = match Cli::parse_line(arguments) {
        Ok(cli) => cli,
        Err(error) => return show_usage(&error, json, &mut context.out),
    };
    if matches!(
        cli.verb,
        Some(Verb::Shell(_) | Verb::Sim(_) | Verb::Demo(_))
    ) {
        return Err(Failure::usage("this verb is not available in the shell"));
    }
    cli.global = cli.global.for_line(session)?;
    cli.follow(context)
}

/// Rewrites a negative number so that clap accepts it: clap takes `-.5` and `-1e-3` for options.
fn escape_negative(word: &OsString) -> OsString {
    let text = word.to_str().unwrap_or_default();
    let is_odd = text.starts_with("-.") || text.contains(['e', 'E']);
    let begins =
        |text: &str| text.starts_with(|first: char| first.is_ascii_digit() || first == '.');
    let number = text.strip_prefix('-').filter(|text| is_odd && begins(text));
    let number = number.and_then(|text| text.parse::<f64>().ok());
    match number.filter(|number| number.is_finite()) {
        Some(number) => format!("-{number}").into(),
        None => word.clone(),
    }
}

/// Replaces clap's suggestion for an unknown flag by the verbs that do have it: clap only suggests
/// flags with a similar spelling.
fn suggest_verbs_with_flag(command: &clap::Command, error: &mut clap::Error) {
    let Some(ContextValue::String(flag)) = error.get(ContextKind::InvalidArg) else {
        return;
    };
    let long = flag.trim_start_matches('-').split('=').next();
    let verbs = command.get_subcommands().filter(|verb| {
        let mut arguments = verb.get_arguments();
        arguments.any(|argument| argument.get_long() == long)
    });
    let verbs: Vec<_> = verbs
        .map(|verb| format!("`magician {}`", verb.get_name()))
        .collect();
    if let Some((last, others)) = verbs.split_last() {
        let told = match others {
            [] => format!("{last} accepts it"),
            _ => format!("{} and {last} accept it", others.join(", ")),
        };
        error.remove(ContextKind::SuggestedArg);
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![told.into()]),
        );
    }
}

/// Prints what clap returned: help on stdout; a mistake becomes a [`Failure`].
pub(crate) fn show_usage(
    error: &clap::Error,
    json: bool,
    output: &mut Output,
) -> Result<(), Failure> {
    match error.kind() {
        ErrorKind::DisplayHelp if json => output.json(&Text::from(&error.render())),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => output.styled(&error.render()),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand if json => {
            Err(Failure::usage("a verb is missing").hint("`--help` lists them"))
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            Err(Failure::already_reported(Kind::Usage))
        }
        _ => Err(Failure::from(error)),
    }
}

/// True if the arguments ask for JSON. Works on arguments that clap could not parse, so that errors
/// are JSON too.
pub(crate) fn has_json_flag(arguments: &[OsString]) -> bool {
    let options = arguments.iter().take_while(|argument| *argument != "--");
    options.into_iter().any(|argument| argument == "--json")
}

/// True if the short help (`-h`) was asked for.
fn has_short_help_flag(arguments: &[OsString]) -> bool {
    arguments.iter().any(|argument| argument == "-h")
}

/// Verb of the command line.
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
    Write(Box<write::Write>),
    Engrave(Box<engrave::Verb>),
    Frame(Box<frame::Frame>),
    #[command(name = "testgrid")]
    TestGrid(Box<testgrid::TestGrid>),
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
    Studio(Box<serve::Studio>),
    Serve(Box<serve::Serve>),
    Station(station::Station),
    // Builds without sites refuse it, so their help does not list it.
    #[cfg_attr(not(feature = "site"), command(hide = true))]
    Fleet(Box<fleet::Fleet>),
    #[cfg_attr(not(feature = "site"), command(hide = true))]
    Site(site::Site),
    Conform(conform::Conform),
    Doctor(doctor::Doctor),
    Bench(bench::Bench),
    Commands(commands::Commands),
    Decode(decode::Decode),
    Replay(replay::Replay),
    Forward(forward::Forward),
    Inverse(inverse::Inverse),
    Config(config::Show),
    Preset(preset::Verb),
    Completions(completions::Completions),
    Man(man::Man),
    Help(help::Help),
}

impl Verb {
    /// True if the verb works on the raw bytes of a line, or creates arms itself, and thus has no
    /// use for a station.
    fn needs_raw_line(&self) -> bool {
        matches!(
            self,
            Self::Bench(_)
                | Self::Conform(_)
                | Self::Demo(_)
                | Self::Fleet(_)
                | Self::Proxy(_)
                | Self::Replay(_)
                | Self::Serve(_)
                | Self::Sim(_)
                | Self::Site(_)
                | Self::Studio(_)
        )
    }

    /// Runs the verb.
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if context.global.station.is_some() && self.needs_raw_line() {
            let message = "this verb works on the line to an arm: it cannot be used with --station";
            return Err(Failure::usage(message));
        }
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
            Self::Write(verb) => verb.run(context),
            Self::Engrave(verb) => verb.run(context),
            Self::Frame(verb) => verb.run(context),
            Self::TestGrid(verb) => verb.run(context),
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
            Self::Studio(verb) => verb.run(context),
            Self::Serve(verb) => verb.run(context),
            Self::Station(verb) => verb.run(context),
            Self::Fleet(verb) => verb.run(context),
            Self::Site(verb) => verb.run(context),
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
            Self::Preset(verb) => verb.run(context),
            Self::Completions(verb) => verb.run(context),
            Self::Man(verb) => verb.run(context),
            Self::Help(verb) => verb.run(context),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_command_line_contradicts_itself_nowhere() {
        Cli::with_virtual_tool().debug_assert();
    }

    /// Each verb is in exactly one group: it takes the virtual arm's `--tool`, has a `--tool` of
    /// its own, or does not work with an arm.
    #[test]
    fn arm_verbs_accept_the_tool_of_a_virtual_arm() {
        // The verbs below `calibrate` have a `--tool` of their own.
        const WITHOUT: &[&str] = &[
            "calibrate",
            "ports",
            "convert",
            "proxy",
            "serve",
            "studio",
            "station",
            "fleet",
            "site",
            "conform",
            "doctor",
            "bench",
            "commands",
            "decode",
            "replay",
            "config",
            "preset",
            "completions",
            "man",
            "help",
            "play",
            "run",
        ];
        for verb in Cli::description().get_subcommands() {
            let has = verb
                .get_arguments()
                .any(|arg| arg.get_long() == Some("tool"));
            let name = verb.get_name();
            assert!(has || WITHOUT.contains(&name), "{name}");
        }
        let read = |line: &str| {
            let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
            Cli::parse(&words).map(|cli| cli.global.virtual_tool)
        };
        assert_eq!(read("magician pose").unwrap(), None);
        assert_eq!(
            read("magician pose --tool pen").unwrap(),
            Some(ToolBias::PEN)
        );
        let bias = read("magician info --tool -1,2,3.5").unwrap();
        assert_eq!(bias, Some(ToolBias::new(-1.0, 2.0, 3.5)));
        let wrong = read("magician pose --tool hammer").unwrap_err().to_string();
        assert!(
            wrong.contains("none, suction, gripper, pen, laser"),
            "{wrong}"
        );
    }

    #[test]
    fn a_line_of_a_shell_has_the_options_of_the_shell() {
        let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
        let read = |line| Cli::parse(&words(line)).unwrap().global;
        let session =
            read("magician -vv --port sim --window 4 --timeout 7 --faults drop=0.1 shell");
        let line = |line: &str| {
            let line = Cli::parse_line(&words(line)).unwrap().global;
            line.for_line(&session)
        };
        let same = line("magician pose").unwrap();
        assert_eq!(format!("{same:?}"), format!("{session:?}"));
        let more = line("magician pose --json --yes --timeout 9").unwrap();
        assert!(more.json && more.yes);
        assert_eq!(more.timeout, Some(Duration::from_secs(9)));
        assert_eq!((more.window, more.verbose), (Some(4), 2));
        for other in [
            "--port sim",
            "--window 2",
            "--faults drop=0.2",
            "--tool pen",
        ] {
            let error = line(&format!("magician pose {other}")).unwrap_err();
            assert_eq!(error.kind, Kind::Usage, "{other}");
        }
    }

    #[test]
    fn json_flag_counts_only_before_the_double_dash() {
        let arguments = |words: &[&str]| words.iter().map(OsString::from).collect::<Vec<_>>();
        assert!(has_json_flag(&arguments(&[
            "magician", "nonsense", "--json"
        ])));
        assert!(!has_json_flag(&arguments(&[
            "magician", "decode", "--", "--json"
        ])));
    }
}
