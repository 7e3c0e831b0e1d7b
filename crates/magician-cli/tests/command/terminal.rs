//! `magician shell` at a terminal.
#![cfg(target_os = "linux")]

use std::path::Path;

use crate::magician::command;
use crate::magician::terminal::Terminal;

fn shell(state: &Path) -> Terminal {
    let mut command = command();
    command
        .args(["--port", "sim", "shell"])
        .env("XDG_STATE_HOME", state);
    Terminal::running(command)
}

#[test]
fn tab_completes_ctrl_c_gives_a_line_up_and_ctrl_d_ends() {
    let state = tempfile::tempdir().expect("directory");
    let mut terminal = shell(state.path());
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
    let mut terminal = shell(Path::new("/dev/null"));
    terminal.until("magician> ");
    terminal.types("pose\r");
    terminal.until("259.104");
    terminal.until("magician> ");
    terminal.types("exit\r");
    assert_eq!(terminal.child.wait().expect("it ends").code(), Some(0));
}
