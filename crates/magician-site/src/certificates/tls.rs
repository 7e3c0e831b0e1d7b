//! TLS 1.3 configurations: between machines of a site, and between a joining machine and the
//! authority.

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

/// ALPN protocol between machines of a site.
const SITE_ALPN: &[u8] = b"http/1.1";
/// ALPN protocol between a joining machine and an invitation.
const JOIN_ALPN: &[u8] = b"magician-join/1";

type CertificateAndKey = (CertificateDer<'static>, PrivateKeyDer<'static>);

fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

fn root_store(authority: &CertificateDer<'_>) -> Result<Arc<RootCertStore>, Error> {
    let mut roots = RootCertStore::empty();
    roots.add(authority.clone())?;
    Ok(Arc::new(roots))
}

/// Converts an error of building a verifier. Its inputs were parsed before, so this is not
/// expected.
fn verifier_error(error: impl std::error::Error) -> Error {
    Error::General(error.to_string())
}

/// Creates a verifier that trusts servers signed by the authority and not revoked. Fails if the
/// list is damaged.
pub(super) fn server_verifier(
    authority: &CertificateDer<'_>,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<Arc<WebPkiServerVerifier>, Error> {
    WebPkiServerVerifier::builder_with_provider(root_store(authority)?, provider())
        .with_crls(list)
        .build()
        .map_err(verifier_error)
}

/// Configuration of a listener for machines of the site.
pub(super) fn server(
    authority: &CertificateDer<'_>,
    (certificate, key): CertificateAndKey,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<ServerConfig, Error> {
    let verifier = WebPkiClientVerifier::builder_with_provider(root_store(authority)?, provider())
        .with_crls(list)
        .build()
        .map_err(verifier_error)?;
    let mut config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_client_cert_verifier(verifier)
        .with_single_cert(vec![certificate], key)?;
    config.alpn_protocols = vec![SITE_ALPN.to_vec()];
    without_resumption(&mut config);
    Ok(config)
}

/// Configuration of connections to machines of the site.
pub(super) fn client(
    authority: &CertificateDer<'_>,
    (certificate, key): CertificateAndKey,
    list: Option<CertificateRevocationListDer<'static>>,
) -> Result<ClientConfig, Error> {
    let verifier = server_verifier(authority, list)?;
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_webpki_verifier(verifier)
        .with_client_auth_cert(vec![certificate], key)?;
    config.alpn_protocols = vec![SITE_ALPN.to_vec()];
    config.resumption = Resumption::disabled();
    Ok(config)
}

/// Configuration of an invitation. It shows the authority's own certificate, so that no machine of
/// the site can pose as the authority.
pub(super) fn invitation_server(
    (authority, key): CertificateAndKey,
) -> Result<ServerConfig, Error> {
    let mut config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .with_no_client_auth()
        .with_single_cert(vec![authority], key)?;
    config.alpn_protocols = vec![JOIN_ALPN.to_vec()];
    without_resumption(&mut config);
    Ok(config)
}

/// Configuration of a joining machine. Trusts only the authority that made the code.
pub(super) fn joining_client(code: JoinCode) -> Result<ClientConfig, Error> {
    let mut config = ClientConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])?
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(CodeVerifier(code)))
        .with_no_client_auth();
    config.alpn_protocols = vec![JOIN_ALPN.to_vec()];
    // The certificate contains no host name.
    config.enable_sni = false;
    config.resumption = Resumption::disabled();
    Ok(config)
}

/// Disables resumption: a resumed session shows no certificate, so a revoked machine could continue
/// with it.
fn without_resumption(config: &mut ServerConfig) {
    config.session_storage = Arc::new(NoServerSessionStorage {});
    config.send_tls13_tickets = 0;
}

/// True if the peer is not the authority that made the code.
pub(super) fn is_wrong_authority(error: &std::io::Error) -> bool {
    let inner = error.get_ref().and_then(|error| error.downcast_ref());
    let strange = Error::InvalidCertificate(CertificateError::ApplicationVerificationFailure);
    inner == Some(&strange)
}

/// Verifier that trusts the authority of a code, if it proves possession of its key. Validity and
/// names are not checked: the code identifies this very certificate.
#[derive(Debug)]
struct CodeVerifier(JoinCode);

impl ServerCertVerifier for CodeVerifier {
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
