//! TLS 1.3 between machines of a site, and with the authority.

use std::sync::Arc;

use tokio_rustls::rustls::client::danger::{
    HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
};
use tokio_rustls::rustls::client::{Resumption, WebPkiServerVerifier};
use tokio_rustls::rustls::crypto::{CryptoProvider, ring, verify_tls13_signature};
use tokio_rustls::rustls::pki_types::{
    CertificateDer, CertificateRevocationListDer, PrivateKeyDer, ServerName, UnixTime,
};
use tokio_rustls::rustls::server::{NoServerSessionStorage, WebPkiClientVerifier};
use tokio_rustls::rustls::version::TLS13;
use tokio_rustls::rustls::{
    self, CertificateError, ClientConfig, DigitallySignedStruct, Error, RootCertStore,
    ServerConfig, SignatureScheme,
};

use super::JoinCode;

/// What machines talk within TLS.
const HTTP: &[u8] = b"http/1.1";
/// What a joining machine and an invitation talk within TLS.
const JOINING: &[u8] = b"magician-join/1";

type Pair = (CertificateDer<'static>, PrivateKeyDer<'static>);

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

fn only(authority: &CertificateDer<'_>) -> Result<Arc<RootCertStore>, Error> {
    let mut roots = RootCertStore::empty();
    roots.add(authority.clone())?;
    Ok(Arc::new(roots))
}

/// What a verifier is built of has been read before, so it is of the right form.
fn unusable(error: impl std::error::Error) -> Error {
    Error::General(error.to_string())
}

/// Trusts servers that the authority has signed and not revoked. Fails if the list is damaged.
pub(super) fn server_verifier(
    authority: &CertificateDer<'_>,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<Arc<WebPkiServerVerifier>, Error> {
    WebPkiServerVerifier::builder_with_provider(only(authority)?, provider())
        .with_crls(list)
        .build()
        .map_err(unusable)
}

/// A listener for machines of the site.
pub(super) fn server(
    authority: &CertificateDer<'_>,
    (certificate, key): Pair,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<ServerConfig, Error> {
    let verifier = WebPkiClientVerifier::builder_with_provider(only(authority)?, provider())
        .with_crls(list)
        .build()
        .map_err(unusable)?;
    let mut config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_client_cert_verifier(verifier)
        .with_single_cert(vec![certificate], key)?;
    config.alpn_protocols = vec![HTTP.to_vec()];
    without_resumption(&mut config);
    Ok(config)
}

/// Connections to machines of the site.
pub(super) fn client(
    authority: &CertificateDer<'_>,
    (certificate, key): Pair,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<ClientConfig, Error> {
    let verifier = server_verifier(authority, list)?;
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_webpki_verifier(verifier)
        .with_client_auth_cert(vec![certificate], key)?;
    config.alpn_protocols = vec![HTTP.to_vec()];
    config.resumption = Resumption::disabled();
    Ok(config)
}

/// An invitation. It shows the authority itself, so that no machine of the site can pose as it.
pub(super) fn inviting((authority, key): Pair) -> Result<ServerConfig, Error> {
    let mut config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_no_client_auth()
        .with_single_cert(vec![authority], key)?;
    config.alpn_protocols = vec![JOINING.to_vec()];
    without_resumption(&mut config);
    Ok(config)
}

/// A connection to the invitation that a code is of.
pub(super) fn joining(code: JoinCode) -> Result<ClientConfig, Error> {
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(OfCode(code)))
        .with_no_client_auth();
    config.alpn_protocols = vec![JOINING.to_vec()];
    // The certificate has no host name.
    config.enable_sni = false;
    config.resumption = Resumption::disabled();
    Ok(config)
}

/// A resumed session shows no certificate: a revoked machine could go on by it.
fn without_resumption(config: &mut ServerConfig) {
    config.session_storage = Arc::new(NoServerSessionStorage {});
    config.send_tls13_tickets = 0;
}

/// True if the other side is not the authority of the code.
pub(super) fn is_stranger(error: &std::io::Error) -> bool {
    let inner = error.get_ref().and_then(|error| error.downcast_ref());
    let strange = Error::InvalidCertificate(CertificateError::ApplicationVerificationFailure);
    inner == Some(&strange)
}

/// Trusts the authority of a code, which proves that it has its key. Validity and names do not matter:
/// the code names this certificate and no other.
#[derive(Debug)]
struct OfCode(JoinCode);

impl ServerCertVerifier for OfCode {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        if self.0.is_of(end_entity) {
            Ok(ServerCertVerified::assertion())
        } else {
            Err(CertificateError::ApplicationVerificationFailure.into())
        }
    }

    fn verify_tls12_signature(
        &self,
        _: &[u8],
        _: &CertificateDer<'_>,
        _: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        Err(rustls::PeerIncompatible::Tls12NotOffered.into())
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = ring::default_provider().signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signature, &algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        { ring::default_provider().signature_verification_algorithms }.supported_schemes()
    }
}
