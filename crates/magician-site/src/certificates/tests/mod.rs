//! Tests of the certificates of a site, with temporary folders and in-memory connections.

mod authority;
mod connections;
mod identity;
mod joining;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rcgen::KeyPair;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio_rustls::rustls::pki_types::ServerName;
use tokio_rustls::rustls::{ClientConfig, ServerConfig};
use tokio_rustls::{TlsAcceptor, TlsConnector};

use super::join::join_over;
use super::{Authority, Identity, Invitation, InvitationEvent, JoinCode, JoinError, Joined};

/// Capacity of an in-memory pipe, bytes.
const PIPE: usize = 64 * 1024;

/// Machines, each with a folder for its sites.
struct Machines(TempDir);

impl Machines {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn sites(&self, machine: &str) -> PathBuf {
        self.0.path().join(machine)
    }

    /// Folder of the site `lab` on a machine.
    fn folder(&self, machine: &str) -> PathBuf {
        self.sites(machine).join("lab")
    }

    /// Creates the site `lab` on a machine.
    fn init(&self, machine: &str) -> Authority {
        Authority::init(&self.folder(machine), "lab", machine).unwrap()
    }

    fn authority(&self, machine: &str) -> Authority {
        Authority::open(&self.folder(machine)).unwrap().unwrap()
    }

    fn identity(&self, machine: &str) -> Identity {
        Identity::open(&self.folder(machine)).unwrap().unwrap()
    }

    /// Lets a machine join, and returns its identity.
    async fn join(&self, authority: &str, machine: &str) -> Identity {
        let invitation = self.invite(authority, 1);
        let (joined, event) = self.try_join(&invitation, machine, machine).await;
        assert!(
            matches!(event, Some(InvitationEvent::Joined { .. })),
            "{event:?}"
        );
        joined.unwrap().identity
    }

    fn invite(&self, authority: &str, machines: usize) -> Invitation {
        Invitation::new(self.authority(authority), machines).unwrap()
    }

    async fn try_join(
        &self,
        invitation: &Invitation,
        machine: &str,
        name: &str,
    ) -> (Result<Joined, JoinError>, Option<InvitationEvent>) {
        let code = invitation.code("authority:1");
        self.try_code(invitation, &code, machine, name).await
    }

    async fn try_code(
        &self,
        invitation: &Invitation,
        code: &JoinCode,
        machine: &str,
        name: &str,
    ) -> (Result<Joined, JoinError>, Option<InvitationEvent>) {
        let (here, there) = duplex(PIPE);
        let folders = self.sites(machine);
        let joining = join_over(here, code, &folders, Some(name), machine);
        let acceptor = acceptor(invitation);
        tokio::join!(
            joining,
            invitation.answer(&acceptor, there, std::future::pending())
        )
    }
}

fn acceptor(invitation: &Invitation) -> TlsAcceptor {
    TlsAcceptor::from(Arc::new(
        invitation.authority().invitation_server().unwrap(),
    ))
}

/// Certificate request of a new key.
fn request() -> String {
    let key = KeyPair::generate().unwrap();
    let request = rcgen::CertificateParams::default().serialize_request(&key);
    request.unwrap().pem().unwrap()
}

/// Connects and sends a byte each way. Returns the error of the client, or else that of the server.
async fn connect(
    client: Arc<ClientConfig>,
    name: &'static str,
    server: Arc<ServerConfig>,
) -> Result<(), String> {
    let (here, there) = duplex(PIPE);
    let calling = async {
        let name = ServerName::try_from(name).unwrap();
        let mut stream = TlsConnector::from(client).connect(name, here).await?;
        // With TLS 1.3 the client learns only now whether it is accepted.
        stream.read_u8().await?;
        stream.write_u8(1).await?;
        stream.flush().await
    };
    let answering = async {
        let mut stream = TlsAcceptor::from(server).accept(there).await?;
        stream.write_u8(0).await?;
        stream.flush().await?;
        stream.read_u8().await
    };
    let (called, answered) = tokio::join!(calling, answering);
    called.map_err(|error| error.to_string())?;
    answered.map(drop).map_err(|error| error.to_string())
}

/// Names of the files in a folder.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name != "lock").collect();
    names.sort();
    names
}
