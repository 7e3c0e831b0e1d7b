//! Service behind endpoints, and its clients.

use magician_protocol::commands::DeviceId;
use magician_protocol::{FrameBuf, NoArgs, Readable};

use super::Notice;
use magician_sim::{Controller, LinkId};

/// Service behind endpoints: it is notified of clients that connect and disconnect, takes their
/// bytes and supplies frames. A [`Server`](super::Server) has one for a virtual arm;
/// [`Endpoints`](super::Endpoints) accept any.
///
/// All calls come from one task, and none may block.
pub trait Service {
    /// Opens a link for a client that has come, or on a pseudo-terminal may come. `name` is its
    /// name for people. The returned id identifies it until it is closed.
    fn open(&mut self, name: &str) -> LinkId;

    /// Closes the link of a client that left or never came.
    fn close(&mut self, link: LinkId);

    /// Replaces a client by its successor of the same name, and returns the id of the successor.
    fn renew(&mut self, link: LinkId, name: &str) -> LinkId {
        self.close(link);
        self.open(name)
    }

    /// Returns the number of bytes the client may send now. Endpoints stop reading at 0, and are
    /// polled again when there is room.
    fn room(&self, link: LinkId) -> usize;

    /// Takes bytes of a client, cut anywhere. A datagram may be longer than the room.
    fn receive(&mut self, link: LinkId, bytes: &[u8]);

    /// Returns the next frame for a client.
    fn reply(&mut self, link: LinkId) -> Option<FrameBuf>;

    /// Called with an event worth logging.
    fn notice(&mut self, notice: Notice);

    /// True if the arm can be reached. Otherwise connections are refused and received bytes
    /// discarded.
    fn plugged(&self) -> bool {
        true
    }

    /// Returns the arm's id (errata E14), by which searching hosts distinguish arms.
    fn device_id(&mut self) -> [u32; 3] {
        [0; 3]
    }
}

/// Reads the id of a virtual arm over an unused link.
pub(super) fn device_id(arm: &mut Controller, link: LinkId) -> [u32; 3] {
    if let Ok(request) = FrameBuf::get(&NoArgs, DeviceId::ROW) {
        arm.receive(link, request.bytes());
    }
    let reply = arm.poll_transmit(link);
    // The link is ours alone, so its state can be dropped without harm.
    arm.close(link);
    let value = reply.and_then(|reply| reply.frame().read::<DeviceId>().ok());
    value.map_or([0; 3], |id| id.device_id)
}

/// Client of an endpoint.
pub(super) struct Peer {
    link: LinkId,
    name: String,
}

impl Peer {
    /// Opens the link of a client that has come, or may come.
    pub(super) fn open(name: String, service: &mut dyn Service) -> Self {
        let link = service.open(&name);
        Self { link, name }
    }

    pub(super) fn link(&self) -> LinkId {
        self.link
    }

    /// Replaces a client that left by its successor of the same name.
    #[cfg(unix)]
    pub(super) fn renew(&mut self, service: &mut dyn Service) {
        self.link = service.renew(self.link, &self.name);
    }

    /// Closes the link of an expected client that will not come.
    #[cfg(unix)]
    pub(super) fn forget(self, service: &mut dyn Service) {
        service.close(self.link);
    }

    /// Closes a client for a new one.
    pub(super) fn make_room(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::MadeRoom(self.name));
    }

    /// Closes the connection of a client without a place.
    pub(super) fn refuse(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::Refused(self.name));
    }

    /// Closes a client that left.
    pub(super) fn leave(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::Left(self.name));
    }
}
