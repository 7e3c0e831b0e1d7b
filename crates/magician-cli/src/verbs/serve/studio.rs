//! `studio`: serves the page and shows it in a browser, or writes its files.

use std::fs;
use std::io;
use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use magician_job::files::write_whole;
use magician_station::http::{PageFile, Pages};
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;
use serde::Serialize;

use super::{PageDisplay, Serve, window};
use crate::context::Context;
use crate::failure::Failure;
use crate::paint::print_stderr;
use magician::stations::{LocalStation, stations};

/// Limits of a page that was built without its WebAssembly modules.
const NO_MODULES: &str = "this build has no WebAssembly modules: its page works with a station, \
    but without a virtual arm in the page and without Web Serial";
/// File that a web server shows for a folder.
const START_PAGE: &str = "index.html";
const BUILD_MODULES: &str =
    "run `cargo xtask generate modules` in a checkout and build again, or use a release";

/// View and move an arm in the browser
#[derive(Args, Debug)]
#[command(after_help = "\
Serves like `magician serve`, prints the address, and opens it in the browser. Ends with Ctrl-C: \
motion stops, the laser is switched off. A double click on `magician` runs `magician studio --app`.

  magician studio                      the only arm found
  magician studio --port sim           a virtual arm
  magician studio --app                in a separate window; closing it ends the program
  magician studio --listen 0.0.0.0:8910 --pair
                                       also for tablets: with a code for their cameras
  magician studio --no-open            for a browser of your choice
  magician studio --export site        write its files for any web server: with a virtual arm
                                       in the page, or a real one over Web Serial")]
pub(crate) struct Studio {
    #[command(flatten)]
    serve: Serve,
    /// Do not open a browser
    #[arg(long)]
    no_open: bool,
    /// Open a separate window and end when it is closed; uses a virtual arm if none is found
    #[arg(long, conflicts_with = "no_open")]
    app: bool,
    /// Only write the page's files to a new folder, for your own web server
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath,
        conflicts_with_all = ["no_open", "app", "arm", "listen", "pair"])]
    export: Option<PathBuf>,
}

impl Studio {
    pub(crate) fn run(mut self, context: &mut Context) -> Result<(), Failure> {
        if let Some(folder) = &self.export {
            return export(folder, context);
        }
        if self.serve.no_studio {
            return Err(Failure::usage("--no-studio leaves nothing to open")
                .hint("use `magician serve --no-studio`"));
        }
        self.serve.shown = match (self.app, self.no_open) {
            (true, _) => PageDisplay::InWindow,
            (_, true) => PageDisplay::AsAddress,
            _ => PageDisplay::InBrowser,
        };
        if !self.app {
            return self.serve.run(context);
        }
        // Second double click: show the page of the running station.
        if self.serve.is_default(context)
            && let Some(LocalStation { url, .. }) = stations().into_iter().next()
        {
            print_stderr(format_args!("a station is already running: {url}"));
            show(PageDisplay::InWindow, &url);
            return Ok(());
        }
        self.serve.run(context).inspect_err(window::show_failure)
    }
}

/// Returns the page for browsers.
pub(crate) fn pages() -> Pages {
    Pages::new(files())
}

fn files() -> impl Iterator<Item = PageFile> {
    magician_studio::FILES.iter().map(|file| PageFile {
        path: file.path,
        kind: file.kind,
        gzip: file.gzip,
    })
}

/// Result of an export.
#[derive(Serialize)]
struct Exported<'a> {
    folder: &'a Path,
    files: usize,
    bytes: usize,
}

/// Writes the page into a folder that is empty or new, so that no file is overwritten.
fn export(folder: &Path, context: &mut Context) -> Result<(), Failure> {
    if !magician_studio::works_without_server() {
        return Err(Failure::usage(NO_MODULES).hint(BUILD_MODULES));
    }
    let exported = write_pages(folder, files())?;
    context.show(&exported, |out| {
        let megabytes = exported.bytes as f64 / 1e6;
        out.line(format_args!(
            "{}: {} files, {megabytes:.1} MB",
            folder.display(),
            exported.files
        ))
    })
}

/// Writes the files of a page, the start page last, so that an unfinished folder shows no page.
/// After an error the files are removed.
fn write_pages(
    folder: &Path,
    files: impl Iterator<Item = PageFile>,
) -> Result<Exported<'_>, Failure> {
    let unwritable = |error: io::Error| Failure::unwritable(folder, &error);
    let is_new = !folder.exists();
    fs::create_dir_all(folder).map_err(unwritable)?;
    if fs::read_dir(folder).map_err(unwritable)?.next().is_some() {
        let message = format!("{} is not empty", folder.display());
        return Err(Failure::usage(message).hint("name a new folder, or empty this one"));
    }
    let mut exported = Exported {
        folder,
        files: 0,
        bytes: 0,
    };
    let (start, others): (Vec<_>, Vec<_>) = files.partition(|file| file.path == "/");
    let written = others.iter().chain(&start).try_for_each(|file| {
        let path = place(folder, file);
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        let bytes = file.unpacked()?;
        write_whole(&path, &bytes)?;
        exported.files += 1;
        exported.bytes += bytes.len();
        Ok(())
    });
    if let Err(error) = written {
        // Only empty folders are removed, in case other files were added meanwhile.
        for path in others.iter().map(|file| place(folder, file)) {
            let _ = fs::remove_file(&path);
            let _ = path
                .parent()
                .filter(|room| *room != folder)
                .map(fs::remove_dir);
        }
        if is_new {
            let _ = fs::remove_dir(folder);
        }
        return Err(unwritable(error));
    }
    Ok(exported)
}

/// Returns the path for a file of the page.
fn place(folder: &Path, file: &PageFile) -> PathBuf {
    folder.join(match file.path {
        "/" => START_PAGE,
        path => path.trim_start_matches('/'),
    })
}

/// Shows the page as chosen. If that fails the printed address has to suffice. Notes once that a
/// build's page needs a server.
pub(super) fn show(how: PageDisplay, url: &str) {
    if how != PageDisplay::No && !magician_studio::works_without_server() {
        print_stderr(format_args!("note: {NO_MODULES}; {BUILD_MODULES}"));
    }
    let shown = match how {
        PageDisplay::No | PageDisplay::AsAddress => Ok(()),
        PageDisplay::InBrowser => window::open_in_browser(url),
        PageDisplay::InWindow => window::open(url),
    };
    if shown.is_err() {
        print_stderr(format_args!("no browser was found: open {url} yourself"));
    }
}

/// Opens a page in the system's browser, without reporting errors: the address is printed anyway.
#[cfg(feature = "site")]
pub(crate) fn open_in_browser(url: &str) {
    show(PageDisplay::InBrowser, url);
}

/// Returns a station's address for other computers: a wildcard address is replaced by this
/// computer's outgoing one.
pub(super) fn external_address(url: &str) -> String {
    let outward = || -> io::Result<IpAddr> {
        // Connecting a UDP socket sends nothing; it only makes the system choose a source address.
        // 192.0.2.1 is reserved for documentation (RFC 5737).
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9))?;
        Ok(socket.local_addr()?.ip())
    };
    match outward() {
        Ok(own) => ["127.0.0.1", "[::1]"]
            .iter()
            .fold(url.to_owned(), |url, home| {
                url.replacen(home, &own.to_string(), 1)
            }),
        Err(_) => url.to_owned(),
    }
}

/// Prints an address as a QR code for a tablet's camera. It holds no token.
pub(super) fn show_address(url: &str) {
    let Ok(code) = QrCode::new(url) else { return };
    // Colours are swapped: QR codes are dark on light, and most terminals are dark.
    let drawn = { code.render::<Dense1x2>() }
        .dark_color(Dense1x2::Light)
        .light_color(Dense1x2::Dark)
        .build();
    let drawn = drawn
        .lines()
        .fold(String::new(), |drawn, line| drawn + "  " + line + "\n");
    print_stderr(format_args!("\n{drawn}\n  {url}\n"));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `page`, compressed with gzip.
    const PAGE: &[u8] = &[
        31, 139, 8, 0, 0, 0, 0, 0, 2, 3, 43, 72, 76, 79, 5, 0, 32, 182, 10, 20, 4, 0, 0, 0,
    ];

    const fn file(path: &'static str, gzip: &'static [u8]) -> PageFile {
        let kind = "text/html";
        PageFile { path, kind, gzip }
    }

    #[test]
    fn failed_export_leaves_no_files_and_writes_the_start_page_last() {
        let place = tempfile::tempdir().unwrap();
        let files = || {
            [
                file("/", PAGE),
                file("/assets/a.js", PAGE),
                file("/sw.js", PAGE),
            ]
        };
        let broken = |path| files().into_iter().chain([file(path, b"no gzip")]);
        for (name, is_there) in [("new", false), ("empty", true)] {
            let folder = place.path().join(name);
            if is_there {
                fs::create_dir(&folder).unwrap();
            }
            // The start page is written last, so it is not among the files removed.
            assert!(write_pages(&folder, broken("/assets/b.js")).is_err());
            assert_eq!(folder.exists(), is_there);
            assert_eq!(fs::read_dir(&folder).map_or(0, Iterator::count), 0);
            let exported = write_pages(&folder, files().into_iter()).unwrap();
            assert_eq!((exported.files, exported.bytes), (3, 12));
            assert_eq!(fs::read(folder.join(START_PAGE)).unwrap(), b"page");
            assert!(write_pages(&folder, broken("/x")).is_err());
            assert_eq!(fs::read_dir(&folder).unwrap().count(), 3, "theirs stays");
        }
    }

    #[test]
    fn only_wildcard_addresses_are_replaced() {
        let told = external_address("http://192.168.1.5:8910/");
        assert_eq!(told, "http://192.168.1.5:8910/");
        let told = external_address("http://127.0.0.1:8910/");
        assert!(
            told.starts_with("http://") && told.ends_with(":8910/"),
            "{told}"
        );
    }
}
