//! Signals on Unix: SIGINT, SIGTERM, SIGHUP, SIGQUIT and SIGXCPU as tokio streams.

use std::fs;
use std::future::pending;
use std::io::{self, IsTerminal};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGXCPU, SIGXFSZ};
use tokio::signal::unix::{self, SignalKind, signal};

use super::Signal;

/// Number of SIGHUP.
const SIGHUP: i32 = 1;

/// True if SIGHUP was ignored when this program began. Read once: after the program catches SIGHUP,
/// the system no longer reports that it was ignored.
static HANGUP_IGNORED: OnceLock<bool> = OnceLock::new();

/// Makes a write beyond the file size limit (`ulimit -f`) fail as on a full disk. SIGXFSZ would
/// otherwise kill the process while the arm moves.
pub(super) fn survive_file_limit() -> io::Result<()> {
    // Any handler makes the write fail instead. Handlers are not inherited, so a child process is
    // not affected.
    let noticed = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGXFSZ, noticed).map(drop)
}

/// True if SIGHUP is ignored, as in a program started by `nohup`.
fn hangup_is_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status");
    let ignored = status.ok().and_then(|status| ignores(&status, SIGHUP));
    // Without `/proc`, assume that a process with no terminal on its three standard streams was
    // started to outlive its terminal.
    let terminals = [
        io::stdin().is_terminal(),
        io::stdout().is_terminal(),
        io::stderr().is_terminal(),
    ];
    ignored.unwrap_or(!terminals.contains(&true))
}

/// True if the parent process set this signal to be ignored; false if unknown.
pub(super) fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status");
    let ignored = status.ok().and_then(|status| ignores(&status, signal));
    ignored.unwrap_or(false)
}

/// True if the signal is in the mask of ignored signals; `None` if the text has no such mask.
fn ignores(status: &str, signal: i32) -> Option<bool> {
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))?;
    let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
    Some(mask >> (signal - 1) & 1 == 1)
}

/// Signal streams. They catch signals once [`listen`](Self::listen) has been called.
pub(super) struct Signals {
    interrupt: unix::Signal,
    terminate: unix::Signal,
    /// Ctrl-\ and the limit of processor time (`ulimit -t`): by default both would end the program
    /// while the arm moves.
    quit: [unix::Signal; 2],
    /// `None` in a program that shall outlive its terminal, as under `nohup`.
    hangup: Option<unix::Signal>,
}

impl Signals {
    /// Begins to catch signals. Must be called within a runtime.
    pub(super) fn listen() -> io::Result<Self> {
        let ignored = *HANGUP_IGNORED.get_or_init(hangup_is_ignored);
        let hangup = (!ignored).then(|| signal(SignalKind::hangup()));
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            quit: [
                signal(SignalKind::quit())?,
                signal(SignalKind::from_raw(SIGXCPU))?,
            ],
            hangup: hangup.transpose()?,
        })
    }

    /// Waits for the next signal.
    pub(super) async fn next(&mut self) -> Signal {
        let wait_for_hangup = async {
            match &mut self.hangup {
                Some(hangup) => hangup.recv().await,
                None => pending().await,
            }
        };
        let [quit, cpu_limit] = &mut self.quit;
        tokio::select! {
            _ = quit.recv() => Signal::Terminate,
            _ = cpu_limit.recv() => Signal::Terminate,
            _ = self.interrupt.recv() => Signal::Interrupt,
            _ = self.terminate.recv() => Signal::Terminate,
            _ = wait_for_hangup => Signal::HangUp,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signal_mask_reports_nohup() {
        let status =
            |mask: &str| format!("Name:\tmagician\nSigBlk:\t0\nSigIgn:\t{mask}\nSigCgt:\t1\n");
        assert_eq!(ignores(&status("0000000000001001"), SIGHUP), Some(true));
        assert_eq!(ignores(&status("0000000000001000"), SIGHUP), Some(false));
        assert_eq!(ignores(&status("0000000000001000"), 13), Some(true));
        assert_eq!(ignores("Name:\tmagician\n", SIGHUP), None);
    }
}
