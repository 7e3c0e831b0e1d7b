//! Links of a virtual arm, and their frames.

use std::collections::BTreeMap;
use std::io::{self, Write};

use magician_protocol::{Direction, FrameBuf};
use magician_sim::LinkId;

use crate::mcap::Micros;
use crate::mcap::file::File;
use crate::mcap::frames::{FrameLine, write_frame};

/// Name and incomplete request of each link. Replies need no buffer: they are always complete
/// frames.
#[derive(Default)]
pub(super) struct Lines(BTreeMap<LinkId, FrameLine>);

impl Lines {
    pub(super) fn name(&mut self, link: LinkId, name: &str) {
        name.clone_into(&mut self.line(link).name);
    }

    pub(super) fn forget(&mut self, link: LinkId) {
        self.0.remove(&link);
    }

    fn line(&mut self, link: LinkId) -> &mut FrameLine {
        let unnamed = || FrameLine::of(format!("link {}", link.0));
        self.0.entry(link).or_insert_with(unnamed)
    }

    /// Writes the frames that the bytes of a peer complete.
    pub(super) fn push_bytes<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
        bytes: &[u8],
    ) -> io::Result<()> {
        self.line(link)
            .push_bytes(file, now, Direction::Request, bytes)
    }

    /// Gives up a partial frame of a peer.
    pub(super) fn silence<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
    ) -> io::Result<()> {
        self.line(link).silence(file, now, Direction::Request)
    }

    pub(super) fn push_reply<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
        frame: &FrameBuf,
    ) -> io::Result<()> {
        let name = &self.line(link).name;
        write_frame(file, now, name, &frame.frame(), Direction::Reply)
    }
}
