//! Encrypted and plain connections to a station, and the trusted certificates.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::version::TLS13;
use tokio_rustls::rustls::{self, ClientConfig, RootCertStore};

use super::{ClientError, StationAddress};

/// Connection, encrypted or not.
pub trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// Certificates to trust.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trust {
    /// The certificates that the system trusts, read from its file: `SSL_CERT_FILE`, or the usual
    /// place. Not available on Windows.
    #[default]
    System,
    /// The certificates in a PEM file: the station's own, or that of its issuer.
    File(PathBuf),
}

impl Trust {
    /// Reads the certificates. Some may be of an unknown kind; at least one must be usable.
    fn roots(&self) -> Result<RootCertStore, ClientError> {
        let path = match self {
            Self::File(path) => Some(path.clone()),
            Self::System => openssl_probe::probe().cert_file,
        };
        let untrusted = |why: String| ClientError::Untrusted(why);
        let Some(path) = path else {
            return Err(untrusted("this system has no file of certificates".into()));
        };
        let unreadable = |why: &dyn std::fmt::Display| {
            untrusted(format!("{} cannot be read: {why}", path.display()))
        };
        let certificates = CertificateDer::pem_file_iter(&path).map_err(|e| unreadable(&e))?;
        let mut roots = RootCertStore::empty();
        for certificate in certificates {
            // A certificate that cannot be used is skipped: system files contain some of old kinds.
            let _ = roots.add(certificate.map_err(|e| unreadable(&e))?);
        }
        // An empty store would refuse every certificate with a misleading error.
        if roots.is_empty() {
            let why = format!("{} holds no certificate as PEM", path.display());
            return Err(untrusted(why));
        }
        Ok(roots)
    }

    /// Creates the TLS connector.
    pub(super) fn connector(&self) -> Result<TlsConnector, ClientError> {
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_protocol_versions(&[&TLS13])
            .map_err(|error| ClientError::Untrusted(error.to_string()))?
            .with_root_certificates(self.roots()?)
            .with_no_client_auth();
        Ok(TlsConnector::from(Arc::new(config)))
    }
}

/// Opens a connection to a station, encrypted if there is a connector.
pub(super) async fn open(
    address: &StationAddress,
    connector: Option<&TlsConnector>,
) -> Result<Box<dyn Stream>, ClientError> {
    let stream = TcpStream::connect(address.host.as_str()).await;
    let stream = stream.map_err(|error| no_station(&address.host, error))?;
    // A stop is one small message and must not wait for Nagle's algorithm.
    let _ = stream.set_nodelay(true);
    match connector {
        None => Ok(Box::new(stream)),
        Some(connector) => encrypt(connector, address.name(), stream).await,
    }
}

/// Returns the error for an address at which no station admits this client.
pub(super) fn no_station(at: &str, why: impl fmt::Display) -> ClientError {
    ClientError::Unreachable(format!("no station at {at}: {why}"))
}

/// Performs the TLS handshake. The host must show a certificate with its name.
async fn encrypt(
    connector: &TlsConnector,
    host: &str,
    stream: TcpStream,
) -> Result<Box<dyn Stream>, ClientError> {
    // Brackets of an IPv6 address belong to the URL, not to the name.
    let name = host.trim_start_matches('[').trim_end_matches(']');
    let name = ServerName::try_from(name.to_owned())
        .map_err(|_| ClientError::Address(format!("{host} is no name of a host")))?;
    match connector.connect(name, stream).await {
        Ok(stream) => Ok(Box::new(stream)),
        Err(error) => Err(refused_certificate(host, &error)),
    }
}

/// Returns the error for a failed handshake.
pub(super) fn refused_certificate(host: &str, error: &std::io::Error) -> ClientError {
    use rustls::Error;
    let source = error.get_ref();
    match source.and_then(|source| source.downcast_ref::<Error>()) {
        Some(Error::InvalidCertificate(why)) => ClientError::Untrusted(format!(
            "the certificate of the station at {host} is not trusted: {why}"
        )),
        Some(Error::InvalidMessage(_)) => ClientError::Unreachable(format!(
            "the station at {host} does not encrypt: use http instead of https"
        )),
        // The connection broke, or something other than a station answered.
        _ => ClientError::Unreachable(format!("no station at {host}: {error}")),
    }
}
