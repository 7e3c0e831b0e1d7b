//! The identity of a machine on a site: certificate, key, trusted authority and revocation list.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;
use tokio_rustls::rustls::{ClientConfig, ServerConfig};

use super::folder::{exists, read_pem};
use super::list::RevocationList;
use super::x509::{self, Details};
use super::{CertificateError, SiteFolder, tls};

/// Certificate and key of this machine on a site, the authority that it trusts, and the list of
/// revoked certificates. Clones share the list.
///
/// The list is read again from the folder whenever it matters, so that a list written by another
/// process of this machine takes effect. Certificate and key are read once, by
/// [`open`](Self::open).
#[derive(Clone)]
pub struct Identity(Arc<Inner>);

struct Inner {
    folder: SiteFolder,
    site: String,
    authority: CertificateDer<'static>,
    certificate: CertificateDer<'static>,
    key: PrivateKeyDer<'static>,
    details: Details,
    list: Mutex<Option<RevocationList>>,
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Identity")
            .field("site", &self.0.site)
            .field("machine", &self.0.details.name)
            .finish_non_exhaustive()
    }
}

impl Identity {
    /// Opens the folder of a site. Returns `None` if it has no `own.pem`.
    ///
    /// # Errors
    /// A file is missing, unreadable or damaged, the key does not match the certificate, or the
    /// authority did not sign the certificate. An expired or revoked certificate is no error.
    pub fn open(folder: &Path) -> Result<Option<Self>, CertificateError> {
        let folder = SiteFolder::at(folder);
        if !exists(&folder.certificate())? {
            return Ok(None);
        }
        let authority = read_pem(&folder.authority(), "certificate as PEM")?;
        let certificate = read_pem(&folder.certificate(), "certificate as PEM")?;
        let key = read_pem(&folder.key(), "private key as PEM")?;
        Self::of(folder, authority, certificate, key).map(Some)
    }

    /// Checks that the parts belong together, and combines them.
    pub(super) fn of(
        folder: SiteFolder,
        authority: CertificateDer<'static>,
        certificate: CertificateDer<'static>,
        key: PrivateKeyDer<'static>,
    ) -> Result<Self, CertificateError> {
        let Some((site, _)) = x509::read_authority(&authority) else {
            let what = "certificate of an authority";
            return Err(CertificateError::Content(folder.authority(), what));
        };
        let Some(details) = x509::read_machine(&certificate) else {
            let what = "certificate of a machine";
            return Err(CertificateError::Content(folder.certificate(), what));
        };
        if !x509::is_signed(&certificate, &authority) {
            return Err(CertificateError::Foreign);
        }
        // Fails unless the key matches the certificate.
        let chain = vec![certificate.clone()];
        CertifiedKey::from_der(chain, key.clone_key(), &ring::default_provider())?;
        let list = folder.list(&authority)?;
        Ok(Self(Arc::new(Inner {
            folder,
            site,
            authority,
            certificate,
            key,
            details,
            list: Mutex::new(list),
        })))
    }

    /// Name of the site.
    #[must_use]
    pub fn site(&self) -> &str {
        &self.0.site
    }

    /// Name of this machine on the site, the only name in its certificate.
    #[must_use]
    pub fn machine(&self) -> &str {
        &self.0.details.name
    }

    /// Path of the authority's certificate.
    #[must_use]
    pub fn authority_file(&self) -> PathBuf {
        self.0.folder.authority()
    }

    /// Path of this machine's certificate.
    #[must_use]
    pub fn certificate_file(&self) -> PathBuf {
        self.0.folder.certificate()
    }

    /// Path of this machine's private key.
    #[must_use]
    pub fn key_file(&self) -> PathBuf {
        self.0.folder.key()
    }

    /// Certificate of the authority, DER.
    pub(super) fn authority(&self) -> &CertificateDer<'static> {
        &self.0.authority
    }

    /// TLS 1.3 configuration for a listener. Clients need a certificate of the authority that is
    /// not revoked.
    ///
    /// It uses the revocation list as of this call. Sessions are not resumed, so that every
    /// connection is checked.
    ///
    /// # Errors
    /// [`CertificateError::Tls`] if TLS cannot use the certificate.
    pub fn server(&self) -> Result<Arc<ServerConfig>, CertificateError> {
        let list = self.list().as_ref().map(RevocationList::to_der);
        let own = (self.0.certificate.clone(), self.0.key.clone_key());
        Ok(Arc::new(tls::server(&self.0.authority, own, list)?))
    }

    /// TLS 1.3 configuration for connections to machines of the site.
    ///
    /// It shows this machine's certificate, and trusts only servers that the authority signed and
    /// did not revoke. The server name of a connection is the name of the machine.
    ///
    /// # Errors
    /// Same as [`server`](Self::server).
    pub fn client(&self) -> Result<Arc<ClientConfig>, CertificateError> {
        let list = self.list().as_ref().map(RevocationList::to_der);
        let own = (self.0.certificate.clone(), self.0.key.clone_key());
        Ok(Arc::new(tls::client(&self.0.authority, own, list)?))
    }

    /// List of revoked certificates, DER, signed by the authority. Empty if no list exists.
    #[must_use]
    pub fn revoked(&self) -> Vec<u8> {
        let list = self.list();
        list.as_ref()
            .map_or_else(Vec::new, |list| list.der().to_vec())
    }

    /// Learns a list from any source. Returns true if it was newer than the known one.
    ///
    /// A newer list signed by the authority is stored on disk, and applies to configurations that
    /// [`server`](Self::server) and [`client`](Self::client) create from now on.
    ///
    /// # Errors
    /// [`CertificateError::List`] if the bytes are not a list signed by the authority. Errors of
    /// the folder: then the list applies to this process, but is not stored.
    pub fn learn(&self, list: &[u8]) -> Result<bool, CertificateError> {
        let list = RevocationList::read(list, &self.0.authority).ok_or(CertificateError::List)?;
        let mut kept = self.list();
        if kept.as_ref().is_some_and(|kept| kept.number >= list.number) {
            return Ok(false);
        }
        // Before it is stored: the list applies even if the folder is not writable.
        *kept = Some(list.clone());
        let locked = self.0.folder.lock()?;
        self.0.folder.store_list(list, &self.0.authority, &locked)?;
        Ok(true)
    }

    /// True if the certificate of this machine is revoked.
    #[must_use]
    pub fn is_revoked(&self) -> bool {
        let list = self.list();
        list.as_ref()
            .is_some_and(|list| list.has(&self.0.details.serial))
    }

    /// Start of validity of this machine's certificate, Unix seconds.
    #[must_use]
    pub fn begins(&self) -> i64 {
        self.0.details.begins
    }

    /// End of validity of this machine's certificate, Unix seconds.
    #[must_use]
    pub fn ends(&self) -> i64 {
        self.0.details.ends
    }

    /// SHA-256 of the authority's certificate, in groups of four hexadecimal digits.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        x509::fingerprint(&self.0.authority)
    }

    /// Returns the newest list, after a look at the folder. If that cannot be read, the known list
    /// stays.
    fn list(&self) -> MutexGuard<'_, Option<RevocationList>> {
        let written = self.0.folder.list(&self.0.authority);
        let mut list = self.0.list.lock().unwrap_or_else(PoisonError::into_inner);
        match written {
            Ok(Some(written))
                if list
                    .as_ref()
                    .is_none_or(|list| list.number < written.number) =>
            {
                *list = Some(written);
            }
            Err(error) => tracing::warn!(%error, "the list of revoked certificates cannot be read"),
            Ok(_) => {}
        }
        list
    }
}
