//! TLS: certificate and key from files.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::version::TLS13;
use tokio_rustls::rustls::{self, ServerConfig};
use tokio_rustls::{TlsAcceptor, server::TlsStream};

/// Reason why certificate and key cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum TlsError {
    /// A file cannot be read.
    Read(PathBuf, io::Error),
    /// A file does not contain this item.
    Content(PathBuf, &'static str),
    /// The key does not belong to the certificate.
    NoPair(PathBuf, PathBuf),
    /// TLS refuses the pair.
    Refused(rustls::Error),
}

impl fmt::Display for TlsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(path, error) => write!(f, "{} cannot be read: {error}", path.display()),
            Self::Content(path, what) => write!(f, "{} holds no {what} as PEM", path.display()),
            Self::NoPair(certificate, key) => write!(
                f,
                "the key in {} is not that of the certificate in {}",
                key.display(),
                certificate.display()
            ),
            Self::Refused(error) => write!(f, "the certificate cannot be used: {error}"),
        }
    }
}

impl std::error::Error for TlsError {}

/// Reads the name of a client from its certificate (DER).
type ReadName = fn(&[u8]) -> Option<String>;

/// Certificate and key of a listener. TLS 1.3 only, with HTTP/1.1.
#[derive(Clone)]
pub struct Tls {
    acceptor: TlsAcceptor,
    read_name: Option<ReadName>,
}

impl fmt::Debug for Tls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tls").finish_non_exhaustive()
    }
}

impl Tls {
    /// Reads a certificate chain and its private key, both in PEM. The chain includes intermediate
    /// certificates up to the certificate that clients trust.
    ///
    /// # Errors
    /// [`TlsError`] if a file cannot be read or the pair cannot be used.
    pub fn from_files(certificate: &Path, key: &Path) -> Result<Self, TlsError> {
        let wrong = |path: &Path, what, error| match error {
            pem::Error::Io(error) => TlsError::Read(path.to_owned(), error),
            _ => TlsError::Content(path.to_owned(), what),
        };
        let no_certificate = |error| wrong(certificate, "certificate", error);
        let chain: Vec<_> = CertificateDer::pem_file_iter(certificate)
            .map_err(no_certificate)?
            .collect::<Result<_, _>>()
            .map_err(no_certificate)?;
        if chain.is_empty() {
            return Err(no_certificate(pem::Error::NoItemsFound));
        }
        let secret =
            PrivateKeyDer::from_pem_file(key).map_err(|error| wrong(key, "private key", error))?;
        let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
            // All current browsers and clients support TLS 1.3, and it has no weak cipher suites.
            .with_protocol_versions(&[&TLS13])
            .map(|config| config.with_no_client_auth())
            .and_then(|config| config.with_single_cert(chain, secret));
        let mut config = config.map_err(|error| match error {
            rustls::Error::InconsistentKeys(_) => {
                TlsError::NoPair(certificate.to_owned(), key.to_owned())
            }
            error => TlsError::Refused(error),
        })?;
        // The server supports HTTP/1.1 only.
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self {
            acceptor: TlsAcceptor::from(Arc::new(config)),
            read_name: None,
        })
    }

    /// Uses a configuration that requests client certificates. `read_name` extracts a client's name
    /// from its certificate (DER), for the journal.
    #[must_use]
    pub fn with_clients(config: Arc<ServerConfig>, read_name: fn(&[u8]) -> Option<String>) -> Self {
        Self {
            acceptor: TlsAcceptor::from(config),
            read_name: Some(read_name),
        }
    }

    /// Returns the name in the client's certificate. `None` if it has shown none.
    pub(super) fn name_of<S>(&self, stream: &TlsStream<S>) -> Option<String> {
        let shown = stream.get_ref().1.peer_certificates()?;
        (self.read_name?)(shown.first()?)
    }

    /// Performs the handshake.
    pub(super) async fn accept<S: AsyncRead + AsyncWrite + Unpin>(
        &self,
        stream: S,
    ) -> io::Result<TlsStream<S>> {
        self.acceptor.accept(stream).await
    }
}
