use std::net::SocketAddr;
#[cfg(unix)]
use std::path::PathBuf;

use magician_protocol::UDP_PORT;

use super::address::resolve;
use super::discovery::{self, Answerer, Discovery};
use super::hub::Hub;
#[cfg(unix)]
use super::pty::Pty;
use super::tcp::Tcp;
use super::udp::Udp;
use super::{Notice, Port, ServeError};

/// An endpoint that was asked for.
pub(super) enum Door {
    #[cfg(unix)]
    Pty(PathBuf),
    Udp(String),
    Tcp(String),
}

pub(super) type Ports = Vec<Box<dyn Port + Send>>;

/// Opens all doors of an arm, in the order in which they were asked for, or none.
pub(super) fn open_all(
    doors: Vec<Door>,
    discovery: &Discovery,
    hub: &mut Hub,
) -> Result<Ports, ServeError> {
    let mut ports = Ports::new();
    for door in doors {
        match door {
            #[cfg(unix)]
            Door::Pty(path) => ports.push(Box::new(Pty::open(&path, hub)?)),
            Door::Udp(address) => {
                let resolved = resolve(&address, Some(UDP_PORT))?;
                let port = Udp::bind(resolved);
                let port = port.map_err(|source| ServeError::at(&address, "bind", source))?;
                ports.push(Box::new(port));
                if *discovery == Discovery::Auto && resolved.port() == UDP_PORT {
                    ports.extend(beside(resolved, hub));
                }
            }
            Door::Tcp(address) => {
                let resolved = resolve(&address, None)?;
                let port = Tcp::bind(resolved);
                let port = port.map_err(|source| ServeError::at(&address, "listen", source))?;
                ports.push(Box::new(port));
            }
        }
    }
    if let Discovery::At(address) = discovery {
        let port = Answerer::bind(resolve(address, Some(discovery::PORT))?, hub);
        let port = port.map_err(|source| ServeError::at(address, "bind", source))?;
        ports.push(Box::new(port));
    }
    Ok(ports)
}

/// Discovery that nobody asked for by name: served where it can be.
fn beside(mut address: SocketAddr, hub: &mut Hub) -> Option<Box<dyn Port + Send>> {
    address.set_port(discovery::PORT);
    match Answerer::bind(address, hub) {
        Ok(port) => Some(Box::new(port)),
        Err(error) => {
            hub.notice(Notice::Undiscoverable { address, error });
            None
        }
    }
}
