//! `magician shell` as a person at a terminal meets it.
#![cfg(target_os = "linux")]

mod magician;

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Stdio};

use magician::command;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// A shell on a terminal of its own.
struct Terminal {
    child: Child,
    screen: File,
    seen: String,
}

impl Terminal {
    fn shell(state: &Path) -> Self {
        let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&screen)
            .and_then(|()| unlockpt(&screen))
            .expect("ours");
        let name = ptsname(&screen, Vec::new()).expect("a name");
        let open = || {
            let path = name.to_str().expect("UTF-8");
            let file = File::options().read(true).write(true).open(path);
            Stdio::from(file.expect("it opens"))
        };
        let child = command()
            .args(["--port", "sim", "shell"])
            .env("XDG_STATE_HOME", state)
            .env("TERM", "xterm")
            .stdin(open())
            .stdout(open())
            .stderr(open())
            .spawn()
            .expect("the command starts");
        let screen = File::from(screen);
        Self {
            child,
            screen,
            seen: String::new(),
        }
    }

    /// Reads up to where this shows.
    fn until(&mut self, text: &str) {
        loop {
            if let Some(at) = self.seen.find(text) {
                self.seen.drain(..at + text.len());
                return;
            }
            // A test that waits for what never comes should fail, not hang.
            let patience = Timespec {
                tv_sec: 20,
                tv_nsec: 0,
            };
            let mut wait = [PollFd::new(&self.screen, PollFlags::IN)];
            let ready = poll(&mut wait, Some(&patience)).expect("it polls");
            assert!(ready > 0, "no {text:?} in {:?}", self.seen);
            let mut bytes = [0; 512];
            let count = self.screen.read(&mut bytes).expect("it goes on");
            self.seen
                .push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
    }

    fn types(&mut self, keys: &str) {
        self.screen.write_all(keys.as_bytes()).expect("typed");
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn tab_completes_ctrl_c_gives_a_line_up_and_ctrl_d_ends() {
    let state = tempfile::tempdir().expect("directory");
    let mut terminal = Terminal::shell(state.path());
    terminal.until("magician> ");
    terminal.types("get ptp-joint\t\r");
    terminal.until("acceleration");
    terminal.until("magician> ");
    terminal.types("nonsense");
    terminal.until("nonsense");
    terminal.types("\x03");
    terminal.until("magician> ");
    terminal.types("set WIFIPassword password=secret --yes\r");
    terminal.until("\n");
    terminal.until("magician> ");
    terminal.types("\x1b[A\x1b[A");
    terminal.until("get PTPJointParams");
    terminal.types("\x03");
    terminal.until("magician> ");
    terminal.types("\x04");
    let status = terminal.child.wait().expect("it ends");
    assert_eq!(status.code(), Some(0));
    let history = std::fs::read_to_string(state.path().join("magician/history"));
    let history = history.expect("a history");
    assert!(history.contains("get PTPJointParams"), "{history}");
    assert!(
        !history.contains("secret") && !history.contains("nonsense"),
        "{history}"
    );
}

#[test]
fn a_shell_without_a_place_for_its_history_works() {
    let mut terminal = Terminal::shell(Path::new("/dev/null"));
    terminal.until("magician> ");
    terminal.types("pose\r");
    terminal.until("199.404");
    terminal.until("magician> ");
    terminal.types("exit\r");
    assert_eq!(terminal.child.wait().expect("it ends").code(), Some(0));
}
