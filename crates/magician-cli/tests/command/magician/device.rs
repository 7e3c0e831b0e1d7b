//! Foreign device on a serial line.

use std::fs::File;
use std::io::{Read, Write};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Pseudo-terminal whose other end answers anything, on a thread that ends with the tests.
pub(crate) struct Device {
    pub(crate) path: String,
    /// Keeps the line open between programs.
    pub(crate) line: File,
}

impl Device {
    pub(crate) fn answering(answer: impl Fn(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let server = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&server)
            .and_then(|()| unlockpt(&server))
            .expect("ours");
        let path = ptsname(&server, Vec::new()).expect("a name");
        let path = path.into_string().expect("UTF-8");
        let line = File::options()
            .read(true)
            .write(true)
            .open(&path)
            .expect("it opens");
        let mut modes = tcgetattr(&line).expect("modes");
        modes.make_raw();
        tcsetattr(&line, OptionalActions::Now, &modes).expect("raw");
        let mut server = File::from(server);
        std::thread::spawn(move || {
            let mut bytes = [0; 256];
            while let Ok(count) = server.read(&mut bytes) {
                let said = answer(&bytes[..count]);
                server.write_all(&said).expect("it takes the answer");
            }
        });
        Self { path, line }
    }
}
