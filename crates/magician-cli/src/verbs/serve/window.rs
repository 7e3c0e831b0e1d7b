//! Studio in a separate browser window, for users without a terminal: finds a browser, opens the
//! window, and notices that it was closed.
//!
//! The browser's process does not show that a window was closed, because it may hand the page to a
//! running process. So the station's sockets are watched instead: no open socket for ten seconds
//! means closed.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use magician_job::dirs;
use magician_protocol::markup;
use magician_station::RunningStation;
use tokio::time::interval;

use crate::failure::{Failure, Kind};
use crate::paint::Paint;

/// Interval of checking whether the page is still open.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Checks without an open socket after which the page counts as closed. A reload takes less.
const CLOSED_CHECKS: u32 = 10;
/// Number of checks within which the page must have appeared once.
const MAX_FIRST_CHECKS: u32 = 60;

/// Chromium-based browsers, which can show a page as an application window, by program name.
#[cfg(not(any(windows, target_os = "macos")))]
const PROGRAMS: [&str; 7] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "microsoft-edge",
    "microsoft-edge-stable",
    "brave-browser",
];
/// The same as paths below the folders of programs.
#[cfg(windows)]
const PROGRAMS: [&str; 3] = [
    r"Microsoft\Edge\Application\msedge.exe",
    r"Google\Chrome\Application\chrome.exe",
    r"BraveSoftware\Brave-Browser\Application\brave.exe",
];
/// The same as paths below the folders of applications.
#[cfg(target_os = "macos")]
const PROGRAMS: [&str; 4] = [
    "Google Chrome.app/Contents/MacOS/Google Chrome",
    "Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "Chromium.app/Contents/MacOS/Chromium",
    "Brave Browser.app/Contents/MacOS/Brave Browser",
];

/// Returns the folders that may contain a browser.
fn folders() -> Vec<PathBuf> {
    let from = |name: &str| env::var_os(name).map(PathBuf::from);
    if cfg!(windows) {
        let names = ["ProgramFiles(x86)", "ProgramFiles", "LOCALAPPDATA"];
        names.into_iter().filter_map(from).collect()
    } else if cfg!(target_os = "macos") {
        let user_folder = from("HOME").map(|home| home.join("Applications"));
        [Some(PathBuf::from("/Applications")), user_folder]
            .into_iter()
            .flatten()
            .collect()
    } else {
        env::var_os("PATH").map_or_else(Vec::new, |path| env::split_paths(&path).collect())
    }
}

/// Returns the first browser of the list that exists.
fn browser(folders: &[PathBuf]) -> Option<PathBuf> {
    let in_folders = |name| folders.iter().map(move |folder| folder.join(name));
    PROGRAMS
        .iter()
        .flat_map(in_folders)
        .find(|path| path.is_file())
}

/// Returns the profile folder for the window. Separate from the user's own profile, which would
/// show the page as a tab.
fn profile(browser: &Path) -> Option<PathBuf> {
    // A browser installed as a snap may write only below its own folder.
    if fs::canonicalize(browser).is_ok_and(|real| real.starts_with("/snap"))
        || browser.starts_with("/snap")
    {
        let home = env::var_os("HOME")?;
        return Some(PathBuf::from(home).join("snap/chromium/common/magician-studio"));
    }
    Some(dirs::state()?.join("studio-window"))
}

/// Opens an address in a separate browser window, or in the system's default browser if no
/// supported browser is found.
///
/// # Errors
/// [`io::Error`] if no browser starts.
pub(super) fn open(url: &str) -> io::Result<()> {
    let found = browser(&folders()).and_then(|browser| Some((profile(&browser)?, browser)));
    let Some((profile, browser)) = found else {
        return open_in_browser(url);
    };
    let mut profile_argument = OsString::from("--user-data-dir=");
    profile_argument.push(&profile);
    let mut window = Command::new(browser);
    // `--app` shows no tabs or address bar. The other options suppress questions of a fresh
    // profile, and give the window a size and a name.
    window
        .arg(format!("--app={url}"))
        .arg(profile_argument)
        .args([
            "--no-first-run",
            "--no-default-browser-check",
            "--window-size=1280,860",
            "--class=magician-studio",
        ]);
    start(&mut window).or_else(|_| open_in_browser(url))
}

/// Opens an address in the system's browser.
///
/// # Errors
/// [`io::Error`] if none starts.
pub(super) fn open_in_browser(url: &str) -> io::Result<()> {
    let (program, words): (_, &[&str]) = if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    start(Command::new(program).args(words).arg(url))
}

fn start(browser: &mut Command) -> io::Result<()> {
    browser.stdin(Stdio::null());
    browser.stdout(Stdio::null());
    browser.stderr(Stdio::null());
    browser.spawn().map(drop)
}

/// True if the user started the program without a terminal, for example by a double click. False
/// for scripts, which read the output or have no screen.
pub(crate) fn is_started_by_hand() -> bool {
    #[cfg(windows)]
    {
        mousetrap::started_by_explorer()
    }
    #[cfg(not(windows))]
    {
        let streams = [
            (io::stdin().is_terminal(), "/dev/stdin"),
            (io::stdout().is_terminal(), "/dev/stdout"),
            (io::stderr().is_terminal(), "/dev/stderr"),
        ];
        has_screen(|name| env::var_os(name).is_some_and(|value| !value.is_empty())) && {
            streams.into_iter()
        }
        .all(|(terminal, path)| !terminal && !is_file_or_pipe(path))
    }
}

/// True if there is a screen for a window.
#[cfg(not(windows))]
fn has_screen(is_set: impl Fn(&str) -> bool) -> bool {
    cfg!(target_os = "macos") || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// True if a standard stream is a file or a pipe, as in a program started by a script.
#[cfg(not(windows))]
fn is_file_or_pipe(stream: &str) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(stream).is_ok_and(|stream| stream.is_file() || stream.file_type().is_fifo())
}

/// Shows in the browser why the studio did not start, for users without a terminal.
pub(super) fn show_failure(failure: &Failure) {
    let Some(folder) = dirs::state() else { return };
    let path = folder.join("studio-window.html");
    let shown = fs::create_dir_all(&folder)
        .and_then(|()| fs::write(&path, failure_page(failure)))
        .and_then(|()| open_in_browser(&path.to_string_lossy()));
    // Errors are dropped: the failure is printed to stderr in any case.
    drop(shown);
}

fn failure_page(failure: &Failure) -> String {
    let mut text = Vec::new();
    // Writing to memory cannot fail.
    let _ = failure.write_text(&mut text, Paint::plain());
    let text = String::from_utf8_lossy(&text);
    let escaped = markup(text);
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>The studio did not start</title>\
         <style>:root{{color-scheme:light dark}}body{{font:1.1rem/1.5 system-ui;max-width:40rem;margin:4rem auto;padding:0 1rem}}\
         pre{{white-space:pre-wrap}}</style><h1>The studio did not start</h1><pre>{escaped}</pre>\
         <p>Fix the problem and start it again. Nothing has moved.</p></html>\n"
    )
}

/// Counts the consecutive checks without an open socket. `visits` is the number of sockets opened
/// so far; it reveals a page that was opened and closed between two checks.
#[derive(Debug, Default)]
struct PageVisits {
    visits: u64,
    empty_checks: u32,
}

impl PageVisits {
    /// Returns true if the page was closed. Fails if it never appeared.
    fn note_check(&mut self, sockets: usize, visits: u64) -> Result<bool, Failure> {
        if sockets > 0 || visits > self.visits {
            (self.visits, self.empty_checks) = (visits, 0);
            return Ok(false);
        }
        self.empty_checks += 1;
        if visits == 0 && self.empty_checks >= MAX_FIRST_CHECKS {
            let message = "no browser showed the studio within a minute";
            return Err(Failure::new(
                Kind::Driver(magician::ErrorKind::Timeout),
                message,
            ));
        }
        Ok(visits > 0 && self.empty_checks >= CLOSED_CHECKS)
    }
}

/// Waits until the page is closed.
///
/// # Errors
/// [`Failure`] if the page never appeared.
pub(super) async fn wait_until_closed(station: &RunningStation) -> Result<(), Failure> {
    let (mut visits, mut checks) = (PageVisits::default(), interval(CHECK_INTERVAL));
    loop {
        checks.tick().await;
        if visits.note_check(station.sockets(), station.visits())? {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reloaded_page_is_not_closed() {
        let mut visits = PageVisits::default();
        for _ in 0..MAX_FIRST_CHECKS - 1 {
            assert!(!visits.note_check(0, 0).unwrap(), "the browser is starting");
        }
        assert!(!visits.note_check(1, 1).unwrap());
        for _ in 0..CLOSED_CHECKS - 1 {
            assert!(!visits.note_check(0, 1).unwrap());
        }
        assert!(!visits.note_check(2, 3).unwrap());
        let closed: Vec<_> = (0..CLOSED_CHECKS)
            .map(|_| visits.note_check(0, 3).unwrap())
            .collect();
        assert_eq!(closed.iter().filter(|closed| **closed).count(), 1);
        assert!(closed.ends_with(&[true]));
    }

    #[test]
    fn page_visited_between_two_checks_counts_as_opened() {
        let mut visits = PageVisits::default();
        assert!(!visits.note_check(0, 0).unwrap());
        assert!(!visits.note_check(0, 1).unwrap());
        for _ in 0..CLOSED_CHECKS - 1 {
            assert!(!visits.note_check(0, 1).unwrap());
        }
        assert!(!visits.note_check(0, 2).unwrap(), "it was loaded again");
        let closed: Vec<_> = (0..CLOSED_CHECKS)
            .map(|_| visits.note_check(0, 2).unwrap())
            .collect();
        assert!(closed.ends_with(&[false, true]));
    }

    #[test]
    fn page_that_never_opens_is_a_failure() {
        let mut visits = PageVisits::default();
        let failed = (0..MAX_FIRST_CHECKS)
            .find_map(|_| visits.note_check(0, 0).err())
            .unwrap();
        assert_eq!(failed.kind.status(), 5);
    }

    #[test]
    #[cfg(not(windows))]
    fn first_installed_browser_of_the_list_is_used() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("none"), folder.path().to_owned()];
        assert_eq!(browser(&folders), None);
        for name in [PROGRAMS[2], PROGRAMS[1]] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, "").unwrap();
            assert_eq!(browser(&folders), Some(path));
        }
    }

    #[test]
    #[cfg(not(windows))]
    fn script_is_not_an_interactive_user() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("log");
        fs::write(&file, "").unwrap();
        assert!(is_file_or_pipe(&file.to_string_lossy()));
        assert!(!is_file_or_pipe("/dev/null"));
        if !cfg!(target_os = "macos") {
            assert!(!has_screen(|_| false));
        }
        assert!(has_screen(|name| name == "WAYLAND_DISPLAY"));
    }

    #[test]
    fn failure_text_is_escaped_in_the_page() {
        let failure = Failure::invalid("no port <script>alert(1)</script> & more");
        let page = failure_page(&failure);
        assert!(page.contains("no port &lt;script&gt;alert(1)&lt;/script&gt; &amp; more"));
    }
}
