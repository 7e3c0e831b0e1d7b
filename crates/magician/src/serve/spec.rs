//! Requested endpoints, and opening them.

use std::net::SocketAddr;
#[cfg(unix)]
use std::path::PathBuf;
use std::task::Context;

use magician_protocol::UDP_PORT;

use super::address::resolve;
use super::discovery::{self, Answerer, Discovery};
#[cfg(unix)]
use super::pty::{self, Pty};
#[cfg(unix)]
use super::several::numbered;
use super::tcp::Tcp;
use super::udp::Udp;
use super::{Endpoint, Listener, Notice, ServeError, Service};

/// Requested endpoint.
pub(super) enum EndpointSpec {
    #[cfg(unix)]
    Pty(PathBuf),
    Udp(String),
    Tcp(String),
}

pub(super) type Listeners = Vec<Box<dyn Listener + Send>>;

/// Number of this arm among several, counted from 1; `None` for a single arm.
pub(super) type Number = Option<u32>;

impl EndpointSpec {
    /// Checks for predictable errors of opening it.
    pub(super) fn check(&self, number: Number) -> Result<(), ServeError> {
        match self {
            #[cfg(unix)]
            Self::Pty(path) => pty::check(&of_arm(path, number)),
            Self::Udp(address) => Place::find(address, Some(UDP_PORT), number).map(drop),
            Self::Tcp(address) => Place::find(address, None, number).map(drop),
        }
    }
}

/// Checks for predictable errors of explicitly requested discovery.
pub(super) fn check(discovery: &Discovery, number: Number) -> Result<(), ServeError> {
    match discovery {
        Discovery::At(text) => Place::find(text, Some(discovery::PORT), number).map(drop),
        Discovery::Auto | Discovery::Off => Ok(()),
    }
}

/// Opens all endpoints of an arm in the order of the request, or none.
pub(super) fn open_all(
    specs: &[EndpointSpec],
    discovery: &Discovery,
    number: Number,
    service: &mut dyn Service,
) -> Result<Listeners, ServeError> {
    let mut ports = Listeners::new();
    for spec in specs {
        match spec {
            #[cfg(unix)]
            EndpointSpec::Pty(path) => {
                ports.push(Box::new(Pty::open(&of_arm(path, number), service)?))
            }
            EndpointSpec::Udp(text) => {
                let place = Place::find(text, Some(UDP_PORT), number)?;
                let port = Udp::bind(place.address);
                ports.push(Box::new(
                    port.map_err(|error| place.refused("bind", error))?,
                ));
                if *discovery == Discovery::Auto && place.address.port() == UDP_PORT {
                    ports.extend(beside(place.address, service));
                }
            }
            EndpointSpec::Tcp(text) => {
                let place = Place::find(text, None, number)?;
                let port = Tcp::bind(place.address);
                ports.push(Box::new(
                    port.map_err(|error| place.refused("listen", error))?,
                ));
            }
        }
    }
    if let Discovery::At(text) = discovery {
        let place = Place::find(text, Some(discovery::PORT), number)?;
        let port = Answerer::bind(place.address, service);
        ports.push(Box::new(
            port.map_err(|error| place.refused("bind", error))?,
        ));
    }
    Ok(ports)
}

/// Returns the public names of the endpoints, in order.
pub(super) fn endpoints(listeners: &Listeners) -> Vec<Endpoint> {
    listeners
        .iter()
        .map(|listener| listener.endpoint())
        .collect()
}

/// Returns a stable location of the arm with these endpoints: the first of them, by a name that is
/// the same at each start. `None` without endpoints.
pub(super) fn place(listeners: &Listeners) -> Option<String> {
    let first = listeners.first()?.endpoint();
    Some(match &first {
        // The symlink itself leads to another device each time.
        #[cfg(unix)]
        Endpoint::Pty { path, .. } => {
            let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            // The parent is resolved and not the link: its target changes at each start.
            let parent = path.parent().and_then(|parent| parent.canonicalize().ok());
            match (parent, path.file_name()) {
                (Some(parent), Some(name)) => parent.join(name).display().to_string(),
                _ => path.display().to_string(),
            }
        }
        other => other.to_string(),
    })
}

/// Polls all endpoints.
pub(super) fn poll_all(
    listeners: &mut Listeners,
    cx: &mut Context<'_>,
    service: &mut dyn Service,
) -> Result<(), ServeError> {
    for listener in listeners {
        let turned = listener.poll(cx, service);
        turned.map_err(|source| ServeError::at(listener.endpoint(), "go on", source))?;
    }
    Ok(())
}

/// Opens discovery that was not requested explicitly, if its port is free.
fn beside(mut address: SocketAddr, service: &mut dyn Service) -> Option<Box<dyn Listener + Send>> {
    address.set_port(discovery::PORT);
    match Answerer::bind(address, service) {
        Ok(port) => Some(Box::new(port)),
        Err(error) => {
            service.notice(Notice::Undiscoverable { address, error });
            None
        }
    }
}

#[cfg(unix)]
fn of_arm(path: &std::path::Path, number: Number) -> PathBuf {
    number.map_or_else(|| path.to_owned(), |number| numbered(path, number))
}

/// Address of an arm's socket.
struct Place {
    address: SocketAddr,
    /// Name in errors: the address as given, unless it was changed.
    name: String,
}

impl Place {
    /// Resolves an address. Ports count up from that of the first arm, except 0, which means any.
    fn find(text: &str, port: Option<u16>, number: Number) -> Result<Self, ServeError> {
        let mut address = resolve(text, port)?;
        let further = number.unwrap_or(1).saturating_sub(1);
        if further == 0 || address.port() == 0 {
            let name = text.to_owned();
            return Ok(Self { address, name });
        }
        // In 32 bits, so that an overflow of the port is an error and does not wrap.
        let port = u32::from(address.port()).saturating_add(further);
        address.set_port(u16::try_from(port).map_err(|_| ServeError::Address {
            address: text.to_owned(),
            reason: "the ports of that many arms would exceed 65535",
        })?);
        let name = address.to_string();
        Ok(Self { address, name })
    }

    fn refused(&self, action: &'static str, error: std::io::Error) -> ServeError {
        ServeError::at(&self.name, action, error)
    }
}
