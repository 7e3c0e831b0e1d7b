//! Joining a site: the new machine's side.
//!
//! The machine connects to the address of the code, checks by the fingerprint that the peer is the
//! authority, and only then sends the secret and a certificate request. The private key is stored
//! before the request is sent, so that a repeated attempt continues with the same key and name.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use rcgen::KeyPair;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{
    CertificateDer, CertificateRevocationListDer, PrivateKeyDer, ServerName,
};

use super::folder::{exists, read_pem, write};
use super::list::RevocationList;
use super::wire::{self, Answer, MAX_ANSWER_SIZE, Request};
use super::{CertificateError, Identity, JoinCode, JoinError, SiteFolder, tls, x509};

/// Timeout of the whole exchange. Longer than the invitation's own, so that its reply is not
/// missed.
const JOIN_TIMEOUT: Duration = Duration::from_secs(15);

/// Result of joining.
#[derive(Debug)]
#[non_exhaustive]
pub struct Joined {
    /// Identity of this machine on the site.
    pub identity: Identity,
    /// True if it had a certificate before.
    pub is_renewal: bool,
}

/// Joins the site of a code, or renews this machine's certificate there.
///
/// Files go to the folder of the site's name in `folders`. The machine keeps the name that it has
/// on the site, otherwise it gets `name`, otherwise `usual`. After an interruption the same call
/// continues with the same key.
///
/// # Errors
/// [`JoinError`]. No secret is sent unless the peer is the authority that made the code.
pub async fn join(
    code: &JoinCode,
    folders: &Path,
    name: Option<&str>,
    usual: &str,
) -> Result<Joined, JoinError> {
    let address = code.address();
    let joining = async {
        let stream = TcpStream::connect(address).await;
        let stream = stream.map_err(|error| JoinError::Connection(address.to_owned(), error))?;
        join_over(stream, code, folders, name, usual).await
    };
    match timeout(JOIN_TIMEOUT, joining).await {
        Ok(joined) => joined,
        Err(_) => Err(JoinError::Silent(address.to_owned())),
    }
}

/// Joins over an open connection.
pub(super) async fn join_over(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    code: &JoinCode,
    folders: &Path,
    name: Option<&str>,
    usual: &str,
) -> Result<Joined, JoinError> {
    let failed = |error: io::Error| match error.kind() {
        io::ErrorKind::InvalidData if tls::is_wrong_authority(&error) => {
            JoinError::WrongAuthority(code.address().to_owned())
        }
        io::ErrorKind::InvalidData => JoinError::Answer,
        _ => JoinError::Connection(code.address().to_owned(), error),
    };
    let config = tls::joining_client(code.clone()).map_err(CertificateError::Tls)?;
    // Required by rustls, but neither sent nor compared: the code identifies the certificate.
    let anybody = ServerName::try_from("magician").map_err(|_| JoinError::Answer)?;
    let connector = TlsConnector::from(Arc::new(config));
    let mut stream = connector.connect(anybody, stream).await.map_err(failed)?;
    let shown = stream.get_ref().1.peer_certificates().unwrap_or_default();
    let authority = shown.first().ok_or(JoinError::Answer)?.clone().into_owned();
    let (site, _) = x509::read_authority(&authority).ok_or(JoinError::Answer)?;

    let membership = Membership::of(&folders.join(site), &authority, name, usual)?;
    let request = Request {
        secret: code.secret().to_owned(),
        name: membership.name.clone(),
        request: membership.request()?,
    };
    wire::write(&mut stream, &request).await.map_err(failed)?;
    match wire::read(&mut stream, MAX_ANSWER_SIZE)
        .await
        .map_err(failed)?
    {
        Answer::Refused(refusal) => Err(JoinError::Refused(refusal)),
        Answer::Joined {
            certificate,
            revoked,
        } => membership.take(authority, &certificate, &revoked),
    }
}

/// Place of this machine on a site: folder, key and name.
struct Membership {
    folder: SiteFolder,
    key: KeyPair,
    name: String,
    is_renewal: bool,
}

impl Membership {
    /// Finds the identity and key of this machine on the site, or generates a key.
    fn of(
        folder: &Path,
        authority: &CertificateDer<'_>,
        name: Option<&str>,
        usual: &str,
    ) -> Result<Self, JoinError> {
        let own = Identity::open(folder)?;
        let folder = SiteFolder::at(folder);
        let other = || JoinError::Other(folder.path().to_owned());
        if let Some(own) = &own {
            if own.authority() != authority {
                return Err(other());
            }
            if name.is_some_and(|name| name != own.machine()) {
                let folder = folder.path().to_owned();
                return Err(JoinError::OtherName(own.machine().to_owned(), folder));
            }
        } else if exists(&folder.authority_key())? {
            // This machine was to be the authority of a site of that name; it is unfinished or has
            // lost a file.
            return Err(other());
        }
        let _locked = folder.lock()?;
        let key = if exists(&folder.key())? {
            let what = "private key as PEM";
            let key: PrivateKeyDer<'_> = read_pem(&folder.key(), what)?;
            KeyPair::try_from(&key)
                .map_err(|_| CertificateError::Content(folder.key(), "private key of P-256"))?
        } else {
            let key = KeyPair::generate().map_err(CertificateError::Make)?;
            // Stored before the request is sent: if the reply is lost, the next attempt has the
            // same key, so that its name does not count as taken.
            write(&folder.key(), &key.serialize_pem())?;
            key
        };
        let usual = own.as_ref().map_or(usual, Identity::machine);
        Ok(Self {
            name: name.unwrap_or(usual).to_owned(),
            is_renewal: own.is_some(),
            folder,
            key,
        })
    }

    /// Creates the certificate request, PEM.
    fn request(&self) -> Result<String, CertificateError> {
        let request = rcgen::CertificateParams::default().serialize_request(&self.key)?;
        Ok(request.pem()?)
    }

    /// Checks the reply and stores it.
    fn take(
        self,
        authority: CertificateDer<'static>,
        certificate: &str,
        revoked: &str,
    ) -> Result<Joined, JoinError> {
        let parsed = CertificateDer::from_pem_slice(certificate.as_bytes());
        let parsed = parsed.map_err(|_| JoinError::Answer)?;
        let list = match revoked {
            "" => None,
            revoked => {
                let list = CertificateRevocationListDer::from_pem_slice(revoked.as_bytes());
                let list = list.map_err(|_| JoinError::Answer)?;
                Some(RevocationList::read(&list, &authority).ok_or(JoinError::Answer)?)
            }
        };
        let key = PrivateKeyDer::from(self.key);
        let locked = self.folder.lock()?;
        let identity = Identity::of(self.folder.clone(), authority.clone(), parsed, key)?;
        if identity.machine() != self.name {
            return Err(JoinError::Answer);
        }
        write(
            &self.folder.authority(),
            &pem::encode(&pem::Pem::new("CERTIFICATE", authority.to_vec())),
        )?;
        if let Some(list) = list {
            self.folder.store_list(list, &authority, &locked)?;
        }
        write(&self.folder.certificate(), certificate)?;
        Ok(Joined {
            identity,
            is_renewal: self.is_renewal,
        })
    }
}
