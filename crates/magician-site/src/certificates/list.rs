//! List of revoked certificates (CRL) of a site.

use std::collections::BTreeSet;

use tokio_rustls::rustls::pki_types::CertificateRevocationListDer;
use x509_parser::prelude::{CertificateRevocationList, FromDer, X509Certificate};

use super::tls;

/// Largest list, bytes: several thousand certificates. Bounds what a stranger can make a machine
/// parse.
const MAX_LIST_SIZE: usize = 256 * 1024;

/// List of revoked certificates signed by the authority.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RevocationList {
    der: Vec<u8>,
    /// CRL number. A higher one is newer.
    pub(super) number: u64,
    pub(super) serials: BTreeSet<Vec<u8>>,
}

impl RevocationList {
    /// Parses a list. Returns `None` if it is malformed, not signed by the authority, or rejected
    /// by the TLS library. The last check matters because the signature does not cover the whole
    /// structure: anyone could change a good list so that TLS rejects it.
    pub(super) fn read(der: &[u8], authority: &[u8]) -> Option<Self> {
        if der.len() > MAX_LIST_SIZE {
            return None;
        }
        let (rest, list) = CertificateRevocationList::from_der(der).ok()?;
        tls::server_verifier(&authority.into(), Some(der.to_vec().into())).ok()?;
        let (_, authority) = X509Certificate::from_der(authority).ok()?;
        list.verify_signature(authority.public_key()).ok()?;
        let is_whole = rest.is_empty() && list.issuer().as_raw() == authority.subject().as_raw();
        let revoked = list.iter_revoked_certificates();
        let serials = revoked.map(|revoked| revoked.raw_serial().to_vec());
        let number = u64::try_from(list.crl_number()?).ok()?;
        is_whole.then(|| Self {
            der: der.to_vec(),
            number,
            serials: serials.collect(),
        })
    }

    /// True if the certificate with this serial number is revoked.
    pub(super) fn has(&self, serial: &[u8]) -> bool {
        self.serials.contains(serial)
    }

    pub(super) fn der(&self) -> &[u8] {
        &self.der
    }

    /// List in the type of the TLS library.
    pub(super) fn to_der(&self) -> CertificateRevocationListDer<'static> {
        self.der.clone().into()
    }

    pub(super) fn to_pem(&self) -> String {
        pem::encode(&pem::Pem::new("X509 CRL", self.der.clone()))
    }
}
