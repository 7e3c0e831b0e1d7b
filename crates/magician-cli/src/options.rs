//! Global options, and parsers that verbs share.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use magician::faults::Faults;
use magician_motion::ToolBias;
use magician_station::client::Trust;

use crate::failure::Failure;
use crate::tokens::token_of;

/// Placeholder for the value of a tool option.
pub(crate) const TOOL: &str = "NAME|X,Y,Z";

/// Options of every verb.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Global options")]
pub(crate) struct Global {
    /// Port of the arm: `/dev/ttyUSB0`, `COM3`, `usb:VENDOR:PRODUCT[:SERIAL]`, `arm:SERIAL`,
    /// `udp:HOST[:PORT]`, `tcp:HOST:PORT`, or `sim[:SPEED]` for a virtual arm [default: the port in
    /// `magician config`, else the only arm found]
    #[arg(
        short,
        long,
        global = true,
        env = "MAGICIAN_PORT",
        hide_env_values = true,
        value_name = "PORT"
    )]
    pub(crate) port: Option<String>,

    /// Connect through a station instead of a port: `http://HOST:PORT` or `http://HOST:PORT/ARM`,
    /// with https if it is encrypted; the token is read from MAGICIAN_TOKEN
    #[arg(long, global = true, value_name = "URL")]
    pub(crate) station: Option<String>,

    /// Trust the certificates in this PEM file for https stations, instead of the system's
    #[arg(
        long,
        global = true,
        env = "MAGICIAN_STATION_CA",
        hide_env_values = true,
        value_name = "FILE"
    )]
    pub(crate) station_ca: Option<PathBuf>,

    /// Print JSON: one object, or one object per line
    #[arg(long, global = true)]
    pub(crate) json: bool,

    /// Allow dangerous actions without asking
    #[arg(long, global = true)]
    pub(crate) yes: bool,

    /// Timeout for each reply of the arm, in seconds [default: 3, or 5 through a station]
    #[arg(long, global = true, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) timeout: Option<Duration>,

    /// Number of requests in flight at once, 1 to 8; use more than 1 only if `magician doctor` has
    /// confirmed it [default: 1]
    #[arg(
        long,
        global = true,
        env = "MAGICIAN_WINDOW",
        hide_env_values = true,
        value_name = "N",
        value_parser = window
    )]
    pub(crate) window: Option<u8>,

    /// Write the traffic with the arm to a pcapng file, for inspection or a bug report; if writing
    /// fails, the work continues and the exit status is 4
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) trace: Option<PathBuf>,

    /// Inject faults into the line to the arm, for tests; `magician proxy --help` lists the
    /// rates
    #[arg(long, global = true, value_name = "SPEC", hide = true)]
    pub(crate) faults: Option<Faults>,

    /// More output on stderr (repeat for more)
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,

    /// The tool of a virtual arm, where the verb takes one; see `Cli::with_virtual_tool`.
    #[arg(skip)]
    pub(crate) virtual_tool: Option<ToolBias>,
}

impl Global {
    /// Returns the token for stations from the environment.
    pub(crate) fn token(&self) -> Option<String> {
        let token = std::env::var("MAGICIAN_TOKEN").ok();
        token.filter(|token| !token.is_empty())
    }

    /// Returns the token for this station: the user's, otherwise the token that a station of this
    /// machine stores for commands of the same user.
    pub(crate) fn token_for(&self, url: &str) -> Option<String> {
        self.token().or_else(|| token_of(url))
    }

    /// Returns which certificates of stations are trusted.
    pub(crate) fn trust(&self) -> Trust {
        // An empty variable counts as not set, as for the port.
        let file = self
            .station_ca
            .clone()
            .filter(|file| !file.as_os_str().is_empty());
        file.map_or(Trust::System, Trust::File)
    }

    /// Returns the station or the port.
    pub(crate) fn place(&self) -> Option<&str> {
        self.station.as_deref().or(self.port.as_deref())
    }

    /// Returns the options of a line in a shell: `session` decides the connection, the line's own
    /// options are added.
    pub(crate) fn for_line(self, session: &Self) -> Result<Self, Failure> {
        // Destructured completely, so that a new field causes a compiler error here.
        let Self {
            port,
            station,
            station_ca,
            json,
            yes,
            timeout,
            window,
            trace,
            faults,
            verbose,
            virtual_tool,
        } = self;
        for (name, is_given) in [
            ("--port", port.is_some()),
            ("--station", station.is_some()),
            (
                "--station-ca",
                station_ca.is_some() && station_ca != session.station_ca,
            ),
            ("--window", window.is_some()),
            ("--trace", trace.is_some()),
            ("--faults", faults.is_some()),
            ("--tool", virtual_tool.is_some()),
        ] {
            if is_given {
                let hint = format!("pass {name} to `magician shell`");
                return Err(Failure::usage("all verbs of a shell share one connection").hint(hint));
            }
        }
        Ok(Self {
            json: json || session.json,
            yes: yes || session.yes,
            timeout: timeout.or(session.timeout),
            verbose: verbose.max(session.verbose),
            ..session.clone()
        })
    }
}

/// Parses seconds above 0, fractions allowed.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.strip_suffix('s').unwrap_or(text).parse::<f64>();
    value
        .ok()
        .filter(|value| *value > 0.0)
        .and_then(|value| Duration::try_from_secs_f64(value).ok())
        .ok_or_else(|| "expected seconds above 0, such as 0.5".to_owned())
}

/// Parses seconds, 0 allowed.
pub(crate) fn seconds_from_zero(text: &str) -> Result<Duration, String> {
    match text.strip_suffix('s').unwrap_or(text).parse::<f64>() {
        Ok(0.0) => Ok(Duration::ZERO),
        _ => seconds(text).map_err(|_| "expected 0 or more seconds, such as 0.5".to_owned()),
    }
}

/// Parses a request window. An empty variable counts as not set, as for the port.
fn window(text: &str) -> Result<u8, String> {
    let value = if text.is_empty() { Ok(1) } else { text.parse() };
    let value = value.ok().filter(|value| (1..=8).contains(value));
    value.ok_or_else(|| "expected 1 to 8, here or in MAGICIAN_WINDOW".to_owned())
}

/// Parses a number, fractions allowed.
pub(crate) fn number<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

/// The tool that a calculation is for.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ToolOption {
    /// Tool: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm
    #[arg(
        long,
        value_name = TOOL,
        default_value = "none",
        allow_hyphen_values = true
    )]
    pub(crate) tool: ToolBias,
}

#[cfg(test)]
mod tests {
    use super::*;

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
