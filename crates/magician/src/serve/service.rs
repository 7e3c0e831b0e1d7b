use magician_protocol::commands::DeviceId;
use magician_protocol::{FrameBuf, NoArgs, Readable};

use super::Notice;
use magician_sim::{Controller, LinkId};

/// What stands behind endpoints: it learns of clients that connect and disconnect, takes bytes and gives frames. A
/// [`Server`](super::Server) has one for a virtual arm; [`Endpoints`](super::Endpoints) lead to any other.
///
/// Every call comes from one task, and none may block.
pub trait Service {
    /// A client came, or on a pseudo-terminal may come; `name` is what people call it. The answer
    /// names it from now on, and no other client meanwhile.
    fn open(&mut self, name: &str) -> LinkId;

    /// It left, or never came.
    fn close(&mut self, link: LinkId);

    /// It left, and the next one will be known by the same name: what that one is called.
    fn renew(&mut self, link: LinkId, name: &str) -> LinkId {
        self.close(link);
        self.open(name)
    }

    /// Bytes that it may send before it should be made to wait. The endpoints are polled again when there is room.
    fn room(&self, link: LinkId) -> usize;

    /// It sent bytes, cut anywhere; datagrams may be longer than the room.
    fn receive(&mut self, link: LinkId, bytes: &[u8]);

    /// The next frame for it.
    fn reply(&mut self, link: LinkId) -> Option<FrameBuf>;

    /// Something worth a line in a log.
    fn notice(&mut self, notice: Notice);

    /// Whether anything can be reached at present: while not, connections are refused and what
    /// comes goes nowhere.
    fn plugged(&self) -> bool {
        true
    }

    /// The arm's id (errata E14), by which hosts that look for one tell it from others.
    fn device_id(&mut self) -> [u32; 3] {
        [0; 3]
    }
}

/// What a virtual arm says of its id, asked over a link that nobody else has.
pub(super) fn device_id(arm: &mut Controller, link: LinkId) -> [u32; 3] {
    if let Ok(request) = FrameBuf::get(&NoArgs, DeviceId::ROW) {
        arm.receive(link, request.bytes());
    }
    let reply = arm.poll_transmit(link);
    arm.close(link);
    let value = reply.and_then(|reply| reply.frame().read::<DeviceId>().ok());
    value.map_or([0; 3], |id| id.device_id)
}

/// A client as its endpoint knows it.
pub(super) struct Peer {
    link: LinkId,
    name: String,
}

impl Peer {
    /// A client came, or may come.
    pub(super) fn open(name: String, service: &mut dyn Service) -> Self {
        let link = service.open(&name);
        Self { link, name }
    }

    pub(super) fn link(&self) -> LinkId {
        self.link
    }

    /// A client left, and the next will be known by the same name.
    #[cfg(unix)]
    pub(super) fn renew(&mut self, service: &mut dyn Service) {
        self.link = service.renew(self.link, &self.name);
    }

    /// A client that may have come did not, and will not.
    #[cfg(unix)]
    pub(super) fn forget(self, service: &mut dyn Service) {
        service.close(self.link);
    }

    /// A client has to go, for a new one.
    pub(super) fn make_room(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::MadeRoom(self.name));
    }

    /// A client that came, and cannot stay.
    pub(super) fn refuse(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::Refused(self.name));
    }

    /// A client left.
    pub(super) fn leave(self, service: &mut dyn Service) {
        service.close(self.link);
        service.notice(Notice::Left(self.name));
    }
}
