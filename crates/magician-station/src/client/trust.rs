//! Connections of a client to a station, and whose certificates it trusts.

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

/// A connection, encrypted or not.
pub trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// Whose certificates are trusted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trust {
    /// Those that the system trusts, of the file that it keeps them in: `SSL_CERT_FILE`, else where the systems have it.
    /// Windows has none.
    #[default]
    System,
    /// Those of a file of certificates as PEM: a station's own, or that of who signed it.
    File(PathBuf),
}

impl Trust {
    /// Reads them. Some of a system's may be of a kind that is not known here; one at least must be.
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
            // What cannot be used is not trusted.
            let _ = roots.add(certificate.map_err(|e| unreadable(&e))?);
        }
        if roots.is_empty() {
            let why = format!("{} holds no certificate as PEM", path.display());
            return Err(untrusted(why));
        }
        Ok(roots)
    }

    /// What makes connections to be encrypted.
    pub(super) fn connector(&self) -> Result<TlsConnector, ClientError> {
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_protocol_versions(&[&TLS13])
            .map_err(|error| ClientError::Untrusted(error.to_string()))?
            .with_root_certificates(self.roots()?)
            .with_no_client_auth();
        Ok(TlsConnector::from(Arc::new(config)))
    }
}

/// Opens a connection to a station; with a connector it is encrypted.
pub(super) async fn open(
    address: &StationAddress,
    connector: Option<&TlsConnector>,
) -> Result<Box<dyn Stream>, ClientError> {
    let stream = TcpStream::connect(address.host.as_str()).await;
    let stream = stream.map_err(|error| no_station(&address.host, error))?;
    // A stop is one small message.
    let _ = stream.set_nodelay(true);
    match connector {
        None => Ok(Box::new(stream)),
        Some(connector) => encrypt(connector, address.name(), stream).await,
    }
}

/// Error of an address where no station lets this client in.
pub(super) fn no_station(at: &str, why: impl fmt::Display) -> ClientError {
    ClientError::Unreachable(format!("no station at {at}: {why}"))
}

/// Encrypts a connection to a host, which has to show a certificate of its name.
async fn encrypt(
    connector: &TlsConnector,
    host: &str,
    stream: TcpStream,
) -> Result<Box<dyn Stream>, ClientError> {
    let name = host.trim_start_matches('[').trim_end_matches(']');
    let name = ServerName::try_from(name.to_owned())
        .map_err(|_| ClientError::Address(format!("{host} is no name of a host")))?;
    match connector.connect(name, stream).await {
        Ok(stream) => Ok(Box::new(stream)),
        Err(error) => Err(refused_certificate(host, &error)),
    }
}

/// Why no encrypted connection came about.
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
        _ => ClientError::Unreachable(format!("no station at {host}: {error}")),
    }
}
