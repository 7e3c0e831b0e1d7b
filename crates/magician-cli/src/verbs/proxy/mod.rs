//! `proxy`: shares one arm between several programs.

mod log;

use std::io::BufWriter;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use magician::faults::Faults;
use magician::proxy::Settings;
use magician::serve::{Endpoints, ProxyServer};
use magician::{LineOptions, RawLine, Target};
use magician_protocol::Row;

use crate::context::Context;
use crate::failure::Failure;
use crate::interrupt::Signal;
use crate::serving::{NO_ENDPOINT_HINT, open_growing, print_ready, pty};

use log::{Log, Style};

/// Share one arm between programs, and show the traffic
#[derive(Args, Debug)]
#[command(after_help = "\
Prints the single line `ready` when every endpoint accepts connections; the traffic is shown on \
stderr. Ends with Ctrl-C or SIGTERM.

  magician proxy --port /dev/ttyUSB0 --pty ./A --pty ./B
  magician proxy --port /dev/ttyUSB0 --pty ./A --trace session.pcapng --quiet
  magician proxy --port udp:192.168.1.5 --tcp 127.0.0.1:9000 --only PTPCmd,GetPose
  magician proxy --port sim --pty ./A --faults drop=1e-3,seed=7

Every program sees an arm of its own: each request gets one reply, in order, and never the reply to \
another program. The arm gets one request at a time and programs take turns. A stop (ForceStop, \
StopExec, Clear, the end of a jog) overtakes all waiting requests, and drops earlier requests of the \
same program. Equal reads share a reply: one younger than --fresh is also given to another program, \
unless something that may change the arm was sent in between.

Nothing is sent twice. If the arm does not reply, neither does the proxy; retries are up to the \
program. Bytes that are not a frame, such as a frame with a wrong checksum, are shown and dropped, \
because they would disturb the other programs; --transparent forwards them. Frames with unknown ids \
are always forwarded.

When a program disconnects, its waiting requests are dropped and its jog ends; its queued commands \
continue. If the line to the arm is lost, programs stay connected and get no replies until it \
is back; requests sent meanwhile are dropped.

--faults injects faults into the line to the arm: rates between 0 and 1 for bytes (flip, \
replace, drop, insert, duplicate, swap) and for chunks (drop-chunk, duplicate-chunk, swap-chunk, \
stall, rechunk, unplug), and seed=N.")]
pub(crate) struct Proxy {
    /// Serve a new pseudo-terminal with PATH as a symlink to it; repeat it for each program
    #[arg(long, value_name = "PATH", value_parser = pty())]
    pty: Vec<PathBuf>,
    /// Serve UDP; the default port is 8899
    #[arg(long, value_name = "HOST[:PORT]")]
    udp: Vec<String>,
    /// Serve TCP
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Vec<String>,
    /// Write the traffic to a pcapng file: one interface for each program, and one for the arm
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Inject reproducible faults into the line to the arm: flip=1e-4,drop=1e-5,seed=7
    #[arg(long, value_name = "SPEC")]
    faults: Option<Faults>,
    /// Maximum age of a reply shared with another program, 0 to 10000 ms; 0: every read goes to the
    /// arm
    #[arg(long, value_name = "MS", default_value = "20", value_parser = milliseconds)]
    fresh: Duration,
    /// Show only these commands
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = command)]
    only: Vec<u8>,
    /// Do not show the traffic
    #[arg(short, long)]
    quiet: bool,
    /// Forward bytes that are not frames to the arm
    #[arg(long)]
    transparent: bool,
    /// Let a jog continue when the program that started it disconnects
    #[arg(long)]
    keep_going: bool,
}

/// Parses milliseconds, with or without the unit.
fn milliseconds(text: &str) -> Result<Duration, String> {
    let value = text
        .strip_suffix("ms")
        .unwrap_or(text)
        .trim()
        .parse::<f64>();
    let value = value.ok().filter(|value| (0.0..=10_000.0).contains(value));
    let value = value.ok_or_else(|| "expected milliseconds from 0 to 10000".to_owned())?;
    Ok(Duration::from_secs_f64(value / 1000.0))
}

/// Returns the id of the command with this name.
fn command(name: &str) -> Result<u8, String> {
    let row =
        Row::find(name).map_err(|error| format!("{error}; `magician commands` lists them"))?;
    Ok(row.id)
}

impl Proxy {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let (endpoints, count) = self.endpoints();
        if count == 0 {
            return Err(Failure::usage("no endpoint to serve").hint(NO_ENDPOINT_HINT));
        }
        self.check_distinct_endpoints()?;
        let target = context.target(None)?;
        let style = Style {
            json: context.global.json,
            frames: !self.quiet,
            only: self.only.clone(),
            verbose: context.global.verbose,
        };
        let signal = context.run_without_arm(async |_, signals| {
            let options = LineOptions::default().faults(self.faults.unwrap_or_default());
            let line = RawLine::open_with(&target, options).await?;
            let settings = Settings {
                max_reply_age: u64::try_from(self.fresh.as_micros()).unwrap_or(u64::MAX),
                transparent: self.transparent,
                keep_going: self.keep_going,
                ..Settings::default()
            };
            let log = Log::new(style, line.name());
            let mut proxy = ProxyServer::open(line, &endpoints, settings)?;
            // After the endpoints: if one of them fails, an earlier trace is left unchanged.
            if let Some(path) = &self.trace {
                proxy = proxy.traced(BufWriter::new(open_growing(path)?))?;
            }
            log.serving(&proxy.endpoints());
            if !matches!(target, Target::Sim(_)) {
                log.exposed(&proxy.endpoints());
            }
            print_ready();
            Ok(proxy.observed(log).serve_until(signals.next()).await?)
        })?;
        match signal {
            Signal::Interrupt => Err(Failure::interrupted()),
            _ => Ok(()),
        }
    }

    /// Fails if an endpoint is given twice: the second link would hide the first.
    fn check_distinct_endpoints(&self) -> Result<(), Failure> {
        #[cfg(unix)]
        for (at, path) in self.pty.iter().enumerate() {
            if self.pty.iter().skip(at + 1).any(|other| other == path) {
                let message = format!("--pty {} is given twice", path.display());
                return Err(Failure::usage(message).hint("give each program a path of its own"));
            }
        }
        Ok(())
    }

    /// Returns the endpoints and their number.
    fn endpoints(&self) -> (Endpoints, usize) {
        let endpoints = Endpoints::new();
        #[cfg(unix)]
        let endpoints = self
            .pty
            .iter()
            .fold(endpoints, |endpoints, path| endpoints.pty(path));
        let endpoints =
            (self.udp.iter()).fold(endpoints, |endpoints, address| endpoints.udp(address));
        let endpoints =
            (self.tcp.iter()).fold(endpoints, |endpoints, address| endpoints.tcp(address));
        let count = self.pty.len() + self.udp.len() + self.tcp.len();
        (endpoints, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milliseconds_with_and_without_their_unit() {
        for text in ["20", "20ms", "20 ms"] {
            assert_eq!(milliseconds(text), Ok(Duration::from_millis(20)), "{text}");
        }
        for wrong in ["", "-1", "20s", "nan", "1e9"] {
            assert!(milliseconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn commands_are_named_as_elsewhere() {
        for name in ["PTPCmd", "ptp-cmd", "SetPTPCmd", "84"] {
            assert_eq!(command(name), Ok(84), "{name}");
        }
        assert!(
            command("Teleport")
                .unwrap_err()
                .contains("magician commands")
        );
    }
}
