//! TLS between machines of a site.

use std::sync::Arc;

use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::version::TLS13;
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

use super::{Machines, connect};
use crate::certificates::Identity;

/// A site with its authority on `desk` and the machine `bench-2`.
async fn site(machines: &Machines) -> (Identity, Identity) {
    machines.init("desk");
    let bench = machines.join("desk", "bench-2").await;
    (machines.identity("desk"), bench)
}

async fn try_connect(
    client: &Identity,
    name: &'static str,
    server: &Identity,
) -> Result<(), String> {
    connect(client.client().unwrap(), name, server.server().unwrap()).await
}

#[tokio::test]
async fn machines_of_a_site_connect_both_ways() {
    let machines = Machines::new();
    let (desk, bench) = site(&machines).await;
    try_connect(&desk, "bench-2", &bench).await.unwrap();
    try_connect(&bench, "desk", &desk).await.unwrap();
}

#[tokio::test]
async fn a_server_with_another_name_is_refused() {
    let machines = Machines::new();
    let (desk, bench) = site(&machines).await;
    let refused = try_connect(&desk, "bench-3", &bench).await.unwrap_err();
    assert!(refused.contains("not valid for name"), "{refused}");
}

#[tokio::test]
async fn a_client_without_certificate_is_refused() {
    let machines = Machines::new();
    let (desk, _) = site(&machines).await;
    let mut roots = RootCertStore::empty();
    roots.add(desk.authority().clone()).unwrap();
    let client = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    let refused = connect(Arc::new(client), "desk", desk.server().unwrap()).await;
    let refused = refused.unwrap_err();
    assert!(refused.contains("CertificateRequired"), "{refused}");
}

#[tokio::test]
async fn certificates_of_another_authority_are_refused() {
    let (machines, others) = (Machines::new(), Machines::new());
    let (desk, bench) = site(&machines).await;
    // An impostor with exactly the same names.
    let (_, impostor) = site(&others).await;
    let refused = try_connect(&desk, "bench-2", &impostor).await.unwrap_err();
    assert!(refused.contains("invalid peer certificate"), "{refused}");
    let mut client = (*impostor.client().unwrap()).clone();
    // A stranger who accepts any server.
    client
        .dangerous()
        .set_certificate_verifier(Arc::new(AcceptAnyServer));
    let refused = connect(Arc::new(client), "desk", desk.server().unwrap()).await;
    let refused = refused.unwrap_err();
    assert!(refused.contains("alert"), "{refused}");
    try_connect(&desk, "bench-2", &bench).await.unwrap();
}

#[tokio::test]
async fn machines_with_the_list_refuse_revoked_clients_and_servers() {
    let machines = Machines::new();
    let (desk, bench) = site(&machines).await;
    let other = machines.join("desk", "bench-3").await;
    let list = machines.authority("desk").revoke("bench-2").unwrap();
    try_connect(&bench, "bench-3", &other).await.unwrap();

    assert!(other.learn(&list).unwrap());
    let refused = try_connect(&bench, "bench-3", &other).await.unwrap_err();
    assert!(refused.contains("CertificateRevoked"), "{refused}");
    let refused = try_connect(&other, "bench-2", &bench).await.unwrap_err();
    assert!(refused.contains("Revoked"), "{refused}");
    try_connect(&desk, "bench-3", &other).await.unwrap();
    try_connect(&other, "desk", &desk).await.unwrap();
}

#[tokio::test]
async fn a_renewed_certificate_is_revoked_with_those_before_it() {
    let machines = Machines::new();
    let (desk, before) = site(&machines).await;
    let renewed = machines.join("desk", "bench-2").await;
    try_connect(&before, "desk", &desk).await.unwrap();
    try_connect(&renewed, "desk", &desk).await.unwrap();
    machines.authority("desk").revoke("bench-2").unwrap();
    for client in [&before, &renewed] {
        let refused = try_connect(client, "desk", &desk).await.unwrap_err();
        assert!(refused.contains("CertificateRevoked"), "{refused}");
    }
}

#[tokio::test]
async fn machine_certificate_cannot_sign_another() {
    let machines = Machines::new();
    let (desk, _) = site(&machines).await;
    let key = std::fs::read_to_string(machines.folder("bench-2").join("own.key")).unwrap();
    let key = rcgen::KeyPair::from_pem(&key).unwrap();
    let own = std::fs::read_to_string(machines.folder("bench-2").join("own.pem")).unwrap();
    let issuer = rcgen::Issuer::from_ca_cert_pem(&own, key);
    // Forge a certificate with a machine's certificate as the issuer. It may not sign, but rcgen
    // does not check that.
    let issuer = issuer.unwrap();
    let forged_key = rcgen::KeyPair::generate().unwrap();
    let mut params = rcgen::CertificateParams::new(vec!["desk".to_owned()]).unwrap();
    params.is_ca = rcgen::IsCa::ExplicitNoCa;
    let forged = params.signed_by(&forged_key, &issuer).unwrap();
    let chain = vec![forged.der().clone(), {
        let pem = own.as_bytes();
        tokio_rustls::rustls::pki_types::pem::PemObject::from_pem_slice(pem).unwrap()
    }];
    let client = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_protocol_versions(&[&TLS13])
        .unwrap()
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(AcceptAnyServer))
        .with_client_auth_cert(chain, forged_key.into())
        .unwrap();
    let refused = connect(Arc::new(client), "desk", desk.server().unwrap()).await;
    let refused = refused.unwrap_err();
    assert!(refused.contains("alert"), "{refused}");
}

/// Accepts any certificate.
#[derive(Debug)]
struct AcceptAnyServer;

mod anybody {
    use tokio_rustls::rustls::client::danger::{
        HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
    };
    use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName, UnixTime};
    use tokio_rustls::rustls::{DigitallySignedStruct, Error, SignatureScheme};

    impl ServerCertVerifier for super::AcceptAnyServer {
        fn verify_server_cert(
            &self,
            _: &CertificateDer<'_>,
            _: &[CertificateDer<'_>],
            _: &ServerName<'_>,
            _: &[u8],
            _: UnixTime,
        ) -> Result<ServerCertVerified, Error> {
            Ok(ServerCertVerified::assertion())
        }

        fn verify_tls12_signature(
            &self,
            _: &[u8],
            _: &CertificateDer<'_>,
            _: &DigitallySignedStruct,
        ) -> Result<HandshakeSignatureValid, Error> {
            Ok(HandshakeSignatureValid::assertion())
        }

        fn verify_tls13_signature(
            &self,
            _: &[u8],
            _: &CertificateDer<'_>,
            _: &DigitallySignedStruct,
        ) -> Result<HandshakeSignatureValid, Error> {
            Ok(HandshakeSignatureValid::assertion())
        }

        fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
            vec![SignatureScheme::ECDSA_NISTP256_SHA256]
        }
    }
}
