//! The page in a window of its own, for people who do not use a terminal: which browser shows it, and when the last has closed it.

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

/// How often it is looked whether the page is still there.
const LOOK: Duration = Duration::from_secs(1);
/// Looks without a page after which it counts as closed: a page that is loaded again is away for less.
const CLOSED: u32 = 10;
/// Looks within which the first page has to come.
const FIRST: u32 = 60;

/// Browsers that show a page without the rest of a browser, by the names of their programs.
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
/// The same below the folders of programs.
#[cfg(windows)]
const PROGRAMS: [&str; 3] = [
    r"Microsoft\Edge\Application\msedge.exe",
    r"Google\Chrome\Application\chrome.exe",
    r"BraveSoftware\Brave-Browser\Application\brave.exe",
];
/// The same below the folders of applications.
#[cfg(target_os = "macos")]
const PROGRAMS: [&str; 4] = [
    "Google Chrome.app/Contents/MacOS/Google Chrome",
    "Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "Chromium.app/Contents/MacOS/Chromium",
    "Brave Browser.app/Contents/MacOS/Brave Browser",
];

/// Folders in which a browser may be.
fn folders() -> Vec<PathBuf> {
    let from = |name: &str| env::var_os(name).map(PathBuf::from);
    if cfg!(windows) {
        let names = ["ProgramFiles(x86)", "ProgramFiles", "LOCALAPPDATA"];
        names.into_iter().filter_map(from).collect()
    } else if cfg!(target_os = "macos") {
        let own = from("HOME").map(|home| home.join("Applications"));
        [Some(PathBuf::from("/Applications")), own]
            .into_iter()
            .flatten()
            .collect()
    } else {
        env::var_os("PATH").map_or_else(Vec::new, |path| env::split_paths(&path).collect())
    }
}

/// The first browser of the list that is there.
fn browser(folders: &[PathBuf]) -> Option<PathBuf> {
    let in_folders = |name| folders.iter().map(move |folder| folder.join(name));
    PROGRAMS
        .iter()
        .flat_map(in_folders)
        .find(|place| place.is_file())
}

/// Where the window keeps what a browser keeps: apart from the person's own browser, which would show the page as a tab of its own.
fn profile(browser: &Path) -> Option<PathBuf> {
    // A browser from a snap may write nowhere else.
    if fs::canonicalize(browser).is_ok_and(|real| real.starts_with("/snap"))
        || browser.starts_with("/snap")
    {
        let home = env::var_os("HOME")?;
        return Some(PathBuf::from(home).join("snap/chromium/common/magician-studio"));
    }
    Some(dirs::state()?.join("studio-window"))
}

/// Shows an address in a window of its own; where no browser can do that, in the browser of the system.
///
/// # Errors
/// [`io::Error`] when no browser starts.
pub(super) fn open(url: &str) -> io::Result<()> {
    let own = browser(&folders()).and_then(|browser| Some((profile(&browser)?, browser)));
    let Some((profile, browser)) = own else {
        return open_in_browser(url);
    };
    let mut profile_word = OsString::from("--user-data-dir=");
    profile_word.push(&profile);
    let mut window = Command::new(browser);
    window.arg(format!("--app={url}")).arg(profile_word).args([
        "--no-first-run",
        "--no-default-browser-check",
        "--window-size=1280,860",
        "--class=magician-studio",
    ]);
    start(&mut window).or_else(|_| open_in_browser(url))
}

/// Shows an address in the browser of the system.
///
/// # Errors
/// [`io::Error`] when none starts.
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

/// Whether the person has started the program without a terminal: by a double click, say. A script that runs it is not meant: it reads what is
/// written, or has no screen.
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
        .all(|(terminal, path)| !terminal && !is_read(path))
    }
}

/// Whether there is a screen to show a window on.
#[cfg(not(windows))]
fn has_screen(is_set: impl Fn(&str) -> bool) -> bool {
    cfg!(target_os = "macos") || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

/// Whether a stream of ours is a file or a pipe, which a script gives to programs that it runs.
#[cfg(not(windows))]
fn is_read(stream: &str) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(stream).is_ok_and(|stream| stream.is_file() || stream.file_type().is_fifo())
}

/// Says in a window why there is no studio: nobody reads a terminal.
pub(super) fn show_failure(failure: &Failure) {
    let Some(folder) = dirs::state() else { return };
    let path = folder.join("studio-window.html");
    let shown = fs::create_dir_all(&folder)
        .and_then(|()| fs::write(&path, failure_page(failure)))
        .and_then(|()| open_in_browser(&path.to_string_lossy()));
    // The terminal has it in any case.
    drop(shown);
}

fn failure_page(failure: &Failure) -> String {
    let mut text = Vec::new();
    // Memory takes all of it.
    let _ = failure.write_text(&mut text, Paint::plain());
    let text = String::from_utf8_lossy(&text);
    let harmless = markup(text);
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>The studio did not start</title>\
         <style>:root{{color-scheme:light dark}}body{{font:1.1rem/1.5 system-ui;max-width:40rem;margin:4rem auto;padding:0 1rem}}\
         pre{{white-space:pre-wrap}}</style><h1>The studio did not start</h1><pre>{harmless}</pre>\
         <p>Mend that and start it again. Nothing has moved.</p></html>\n"
    )
}

/// Who looks at the page, by how many sockets are open at each look, and how many have been so far: a page may come and go between two looks.
#[derive(Debug, Default)]
struct Audience {
    visits: u64,
    empty: u32,
}

impl Audience {
    /// Whether the page was closed; a failure if it never came.
    fn look(&mut self, sockets: usize, visits: u64) -> Result<bool, Failure> {
        if sockets > 0 || visits > self.visits {
            (self.visits, self.empty) = (visits, 0);
            return Ok(false);
        }
        self.empty += 1;
        if visits == 0 && self.empty >= FIRST {
            let message = "no browser has shown the studio within a minute";
            return Err(Failure::new(
                Kind::Driver(magician::ErrorKind::Timeout),
                message,
            ));
        }
        Ok(visits > 0 && self.empty >= CLOSED)
    }
}

/// Waits until the page was closed.
///
/// # Errors
/// [`Failure`] when it never came.
pub(super) async fn closed(station: &RunningStation) -> Result<(), Failure> {
    let (mut audience, mut looks) = (Audience::default(), interval(LOOK));
    loop {
        looks.tick().await;
        if audience.look(station.sockets(), station.visits())? {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_loaded_again_is_not_closed() {
        let mut audience = Audience::default();
        for _ in 0..FIRST - 1 {
            assert!(!audience.look(0, 0).unwrap(), "the browser is starting");
        }
        assert!(!audience.look(1, 1).unwrap());
        for _ in 0..CLOSED - 1 {
            assert!(!audience.look(0, 1).unwrap());
        }
        assert!(!audience.look(2, 3).unwrap());
        let closed: Vec<_> = (0..CLOSED).map(|_| audience.look(0, 3).unwrap()).collect();
        assert_eq!(closed.iter().filter(|closed| **closed).count(), 1);
        assert!(closed.ends_with(&[true]));
    }

    #[test]
    fn a_page_that_came_and_went_between_two_looks_was_there() {
        let mut audience = Audience::default();
        assert!(!audience.look(0, 0).unwrap());
        assert!(!audience.look(0, 1).unwrap());
        for _ in 0..CLOSED - 1 {
            assert!(!audience.look(0, 1).unwrap());
        }
        assert!(!audience.look(0, 2).unwrap(), "it was loaded again");
        let closed: Vec<_> = (0..CLOSED).map(|_| audience.look(0, 2).unwrap()).collect();
        assert!(closed.ends_with(&[false, true]));
    }

    #[test]
    fn a_page_that_never_comes_is_a_failure() {
        let mut audience = Audience::default();
        let failed = (0..FIRST).find_map(|_| audience.look(0, 0).err()).unwrap();
        assert_eq!(failed.kind.status(), 5);
    }

    #[test]
    #[cfg(not(windows))]
    fn the_first_browser_of_the_list_that_is_there_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("none"), folder.path().to_owned()];
        assert_eq!(browser(&folders), None);
        for name in [PROGRAMS[2], PROGRAMS[1]] {
            let place = folder.path().join(name);
            fs::create_dir_all(place.parent().unwrap()).unwrap();
            fs::write(&place, "").unwrap();
            assert_eq!(browser(&folders), Some(place));
        }
    }

    #[test]
    #[cfg(not(windows))]
    fn a_script_is_no_person() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("log");
        fs::write(&file, "").unwrap();
        assert!(is_read(&file.to_string_lossy()));
        assert!(!is_read("/dev/null"));
        if !cfg!(target_os = "macos") {
            assert!(!has_screen(|_| false));
        }
        assert!(has_screen(|name| name == "WAYLAND_DISPLAY"));
    }

    #[test]
    fn a_failure_cannot_bring_its_own_page() {
        let failure = Failure::invalid("no port <script>alert(1)</script> & more");
        let page = failure_page(&failure);
        assert!(page.contains("no port &lt;script&gt;alert(1)&lt;/script&gt; &amp; more"));
    }
}
