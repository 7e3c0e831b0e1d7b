//! `laser`: on while this command runs, and off.

use std::future::{Future, pending};
use std::io::{self, IsTerminal, Read, Write};
use std::pin::Pin;
use std::time::Duration;

use clap::Args;
use magician::{Arm, Link, build};
use tokio::sync::oneshot;
use tokio::time::{sleep, timeout};

use super::jog::REAL_TIME_ARM;
use super::tools::{Switch, show};
use crate::context::{BurnEnd, Context, SignalPolicy, StopPolicy};
use crate::failure::{Failure, Kind};
use crate::options::seconds;
use crate::output::Output;
use crate::permission::ConfirmationSource;
use crate::progress::announce_wait;

/// Longest wait for a broken line to return, so that the laser can be switched off. A choice.
const RECONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// Interval of checking the line.
const LINE_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Switch the laser on until Ctrl-C, or off
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician laser on              until Ctrl-C, or Ctrl-D
  magician laser on --for 0.5    for half a second
  magician laser off

Wear goggles for the laser's wavelength before switching it on. The laser burns only while this \
command runs; --keep-on leaves it on. In `magician shell` it burns until `laser off`, or until the \
shell ends. On a real arm the command asks first, or needs --yes.")]
pub(crate) struct Laser {
    /// State to set
    state: Switch,
    /// Switch the laser off after SECONDS
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    /// Leave the laser on when this command ends
    #[arg(long, conflicts_with = "time")]
    keep_on: bool,
}

impl Laser {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.state == Switch::Off {
            return self.off(context);
        }
        let lasts = self.time.is_some() || !(self.keep_on || context.in_shell());
        if lasts && self.time.is_none() && !io::stdin().is_terminal() {
            let message = "`laser on` burns until Ctrl-C or the end of its input, and stdin is not a \
                    terminal";
            return Err(Failure::usage(message).hint("give --for SECONDS, or --keep-on"));
        }
        if self.keep_on && context.lease_ends_at_once() {
            let message = "at a station the laser goes off when the lease ends, and the lease of \
                this command ends at once; nothing was sent";
            return Err(Failure::usage(message)
                .hint("give --for SECONDS, or use `magician shell`, which keeps the lease"));
        }
        context.permit_laser(ConfirmationSource::AtTheTerminal)?;
        if lasts {
            return self.burn(context);
        }
        let burns = if self.keep_on {
            BurnEnd::UntilSwitchedOff
        } else {
            BurnEnd::WhileConnected
        };
        context.arm(StopPolicy::Light(burns), async |arm, _| {
            Ok(arm.set_any(&build::laser(true)).await?)
        })?;
        show(context, "laser", Switch::On)
    }

    fn off(self, context: &mut Context) -> Result<(), Failure> {
        if self.time.is_some() || self.keep_on {
            return Err(Failure::usage("--for and --keep-on are for `laser on`"));
        }
        context.arm(StopPolicy::Darken, async |arm, _| {
            Ok(arm.laser().switch_off().await?)
        })?;
        show(context, "laser", Switch::Off)
    }

    /// Burns until the user, the time limit or the system ends it.
    fn burn(self, context: &mut Context) -> Result<(), Failure> {
        let quiet = context.global.json;
        context.until_signal(
            REAL_TIME_ARM,
            SignalPolicy::Burn,
            async |arm, out, signal| {
                arm.set_any(&build::laser(true)).await?;
                print_state(quiet, out, "on")?;
                let end = self.end(arm, quiet, signal).await;
                // Switch the laser off before reporting the result, however the wait ended.
                let dark = arm.laser().switch_off().await;
                end?;
                dark?;
                print_state(quiet, out, "off")
            },
        )
    }

    /// Waits for the end.
    async fn end(
        &self,
        arm: &Arm,
        quiet: bool,
        signal: Pin<&mut dyn Future<Output = ()>>,
    ) -> Result<(), Failure> {
        let over = async {
            match self.time {
                Some(time) => sleep(time).await,
                None => end_of_input(quiet).await,
            }
        };
        tokio::select! {
            biased;
            // A requested end takes precedence over a line that breaks at the same time.
            () = signal => Ok(()),
            () = over => Ok(()),
            failure = line_restored(arm, quiet) => Err(failure),
        }
    }
}

fn print_state(json: bool, out: &mut Output, state: &str) -> Result<(), Failure> {
    if json {
        out.json(&serde_json::json!({ "state": state }))?;
    } else {
        out.line(format_args!("laser: {state}"))?;
    }
    out.flush()
}

/// Waits for the end of standard input. Never completes if that cannot be read.
async fn end_of_input(quiet: bool) {
    if !quiet {
        let _ = writeln!(io::stderr(), "Ctrl-C switches it off");
    }
    let (sender, signal) = oneshot::channel();
    // A read from stdin cannot be cancelled, so it has its own thread, which ends with the process.
    std::thread::spawn(move || {
        let mut bytes = [0; 256];
        let mut stdin = io::stdin().lock();
        while matches!(stdin.read(&mut bytes), Ok(1..)) {}
        let _ = sender.send(());
    });
    if signal.await.is_err() {
        pending::<()>().await;
    }
}

/// Waits until the line breaks, and then until it is back: the driver's first frames then switch
/// the laser off.
async fn line_restored(arm: &Arm, quiet: bool) -> Failure {
    while arm.link() == Link::Up {
        sleep(LINE_CHECK_INTERVAL).await;
    }
    let back = announce_wait(
        quiet,
        "line lost: waiting to switch the laser off when it is back",
        timeout(RECONNECT_TIMEOUT, arm.reconnected()),
    );
    let message = match back.await {
        Ok(Ok(())) => "the line to the arm broke; it is back, and the laser is off",
        _ => "the line to the arm broke, and the laser may be on: switch the arm off",
    };
    Failure::new(Kind::Driver(magician::ErrorKind::Port), message)
}
