//! `studio`: serves, and shows the page in a browser.

use std::process::{Command, Stdio};

use clap::Args;
use magician_station::http::{PageFile, Pages};

use super::Serve;
use crate::context::Context;
use crate::failure::Failure;
use crate::paint::tell;

/// See and move an arm in the browser
#[derive(Args, Debug)]
#[command(after_help = "\
Serves like `magician serve`, prints the address, and opens it in the browser. Ends with Ctrl-C: what moves is stopped where it is, the laser is off.

  magician studio                      the arm that is found
  magician studio --port sim           a virtual arm
  magician studio --no-open            for a browser of your choice")]
pub(crate) struct Studio {
    #[command(flatten)]
    serve: Serve,
    /// Open no browser
    #[arg(long)]
    no_open: bool,
}

impl Studio {
    pub(crate) fn run(mut self, context: &mut Context) -> Result<(), Failure> {
        if self.serve.no_studio {
            return Err(Failure::usage("--no-studio leaves nothing to open")
                .hint("use `magician serve --no-studio`"));
        }
        self.serve.opens = !self.no_open;
        self.serve.run(context)
    }
}

/// The page for browsers.
pub(super) fn pages() -> Pages {
    let files = magician_studio::FILES.iter();
    Pages::new(files.map(|file| PageFile {
        path: file.path,
        kind: file.kind,
        bytes: file.bytes,
        gzip: file.gzip,
    }))
}

/// Shows an address in the person's browser; where that fails the address is enough.
pub(super) fn open(url: &str) {
    let (program, words): (_, &[&str]) = if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    let mut browser = Command::new(program);
    browser.args(words).arg(url);
    browser.stdin(Stdio::null());
    browser.stdout(Stdio::null());
    browser.stderr(Stdio::null());
    if browser.spawn().is_err() {
        tell(format_args!("no browser was found: open {url} yourself"));
    }
}
