//! What a machine has of a site.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;
use tokio_rustls::rustls::{ClientConfig, ServerConfig};

use super::folder::{is_there, read_pem};
use super::list::RevocationList;
use super::x509::{self, Details};
use super::{CertificateError, SiteFolder, tls};

/// This machine's certificate and key on a site, the authority that it trusts, and the list of revoked
/// certificates. Clones share the list.
///
/// The list in the folder is looked at whenever the list matters, so what another process of this
/// machine wrote counts too. Certificate and key are those of [`open`](Self::open).
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
    /// Opens the folder of a site. `None` where there is no `own.pem`.
    ///
    /// # Errors
    /// A file that is missing, unreadable or damaged, a key that is not that of the certificate, and a
    /// certificate that the authority did not sign. An expired or revoked certificate is no error.
    pub fn open(folder: &Path) -> Result<Option<Self>, CertificateError> {
        let folder = SiteFolder::at(folder);
        if !is_there(&folder.certificate())? {
            return Ok(None);
        }
        let authority = read_pem(&folder.authority(), "certificate as PEM")?;
        let certificate = read_pem(&folder.certificate(), "certificate as PEM")?;
        let key = read_pem(&folder.key(), "private key as PEM")?;
        Self::of(folder, authority, certificate, key).map(Some)
    }

    /// Checks that the parts belong together.
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
        // Fails unless the key is that of the certificate.
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

    /// The site's name.
    #[must_use]
    pub fn site(&self) -> &str {
        &self.0.site
    }

    /// This machine's name on the site, the only name in its certificate.
    #[must_use]
    pub fn machine(&self) -> &str {
        &self.0.details.name
    }

    /// The file of the authority's certificate.
    #[must_use]
    pub fn authority_file(&self) -> PathBuf {
        self.0.folder.authority()
    }

    /// The file of this machine's certificate.
    #[must_use]
    pub fn certificate_file(&self) -> PathBuf {
        self.0.folder.certificate()
    }

    /// The file of this machine's private key.
    #[must_use]
    pub fn key_file(&self) -> PathBuf {
        self.0.folder.key()
    }

    /// The authority's certificate, DER.
    pub(super) fn authority(&self) -> &CertificateDer<'static> {
        &self.0.authority
    }

    /// TLS 1.3 for a listener: it requires a certificate of the authority that is not revoked. Sessions
    /// are not resumed, so each connection is checked by the list of the time this was called.
    ///
    /// # Errors
    /// [`CertificateError::Tls`] if TLS cannot use the certificate.
    pub fn server(&self) -> Result<Arc<ServerConfig>, CertificateError> {
        let list = self.list().as_ref().map(RevocationList::to_der);
        let own = (self.0.certificate.clone(), self.0.key.clone_key());
        Ok(Arc::new(tls::server(&self.0.authority, own, list)?))
    }

    /// TLS 1.3 for connections to machines of the site: it shows this machine's certificate and trusts
    /// the authority alone, and no revoked server. The server name of a connection is the machine's.
    ///
    /// # Errors
    /// As [`server`](Self::server).
    pub fn client(&self) -> Result<Arc<ClientConfig>, CertificateError> {
        let list = self.list().as_ref().map(RevocationList::to_der);
        let own = (self.0.certificate.clone(), self.0.key.clone_key());
        Ok(Arc::new(tls::client(&self.0.authority, own, list)?))
    }

    /// The list of revoked certificates, DER, signed by the authority. Empty if there is none.
    #[must_use]
    pub fn revoked(&self) -> Vec<u8> {
        let list = self.list();
        list.as_ref()
            .map_or_else(Vec::new, |list| list.der().to_vec())
    }

    /// Takes a list from anywhere. A list that the authority signed and that is newer is kept on disk,
    /// and holds for what [`server`](Self::server) and [`client`](Self::client) make from now on. True
    /// if the list was newer than the one before.
    ///
    /// # Errors
    /// [`CertificateError::List`] if these bytes are no list of the authority; else what is wrong with
    /// the folder, after which the list holds in this process all the same.
    pub fn learn(&self, list: &[u8]) -> Result<bool, CertificateError> {
        let list = RevocationList::read(list, &self.0.authority).ok_or(CertificateError::List)?;
        let mut kept = self.list();
        if kept.as_ref().is_some_and(|kept| kept.number >= list.number) {
            return Ok(false);
        }
        *kept = Some(list.clone());
        let locked = self.0.folder.lock()?;
        self.0.folder.keep_list(list, &self.0.authority, &locked)?;
        Ok(true)
    }

    /// True if this machine's own certificate is revoked.
    #[must_use]
    pub fn is_revoked(&self) -> bool {
        let list = self.list();
        list.as_ref()
            .is_some_and(|list| list.has(&self.0.details.serial))
    }

    /// Begin of the validity of this machine's certificate, Unix seconds.
    #[must_use]
    pub fn begins(&self) -> i64 {
        self.0.details.begins
    }

    /// End of the validity of this machine's certificate, Unix seconds.
    #[must_use]
    pub fn ends(&self) -> i64 {
        self.0.details.ends
    }

    /// SHA-256 of the authority's certificate, in groups of four hexadecimal digits.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        x509::fingerprint(&self.0.authority)
    }

    /// The list, after a look at the folder. What cannot be read there leaves the list as it was.
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
