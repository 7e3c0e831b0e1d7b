//! Files of a site on one machine.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use magician::files::replace_private;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};

use super::CertificateError;
use super::list::RevocationList;

/// Folder of a site.
///
/// * `ca.pem`: certificate of the authority
/// * `own.pem`, `own.key`: certificate and private key of this machine
/// * `revoked.pem`: list of revoked certificates, once there is one
/// * `ca.key`, `members.json`: on the authority's machine only
/// * `lock`: held by the process that changes the folder
///
/// `own.pem` is written last, so a folder without it is unfinished.
#[derive(Clone, Debug)]
pub struct SiteFolder(PathBuf);

/// Lock of a folder: no other process changes it meanwhile.
#[derive(Debug)]
pub(super) struct FolderLock {
    _file: File,
}

impl SiteFolder {
    /// Returns the folder with this path. Reads nothing.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Path of the authority's certificate.
    #[must_use]
    pub fn authority(&self) -> PathBuf {
        self.0.join("ca.pem")
    }

    /// Path of the authority's private key.
    #[must_use]
    pub fn authority_key(&self) -> PathBuf {
        self.0.join("ca.key")
    }

    /// Path of this machine's certificate.
    #[must_use]
    pub fn certificate(&self) -> PathBuf {
        self.0.join("own.pem")
    }

    /// Path of this machine's private key.
    #[must_use]
    pub fn key(&self) -> PathBuf {
        self.0.join("own.key")
    }

    /// Path of the list of revoked certificates.
    #[must_use]
    pub fn revoked(&self) -> PathBuf {
        self.0.join("revoked.pem")
    }

    /// Path of the authority's record of machines and certificates.
    #[must_use]
    pub fn members(&self) -> PathBuf {
        self.0.join("members.json")
    }

    /// Creates the folder, accessible to its owner alone, and locks it. Waits for other processes.
    pub(super) fn lock(&self) -> Result<FolderLock, CertificateError> {
        let unwritable = |error| CertificateError::Write(self.0.clone(), error);
        make_private(&self.0).map_err(unwritable)?;
        let mut options = File::options();
        let options = options.create(true).truncate(false).write(true);
        let file = options.open(self.0.join("lock")).map_err(unwritable)?;
        match file.lock() {
            // Some network file systems have no locks. Go on without one: usually only one process
            // changes the folder.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => Err(unwritable(error)),
            _ => Ok(FolderLock { _file: file }),
        }
    }

    /// Reads the list of revoked certificates. `None` if there is no such file.
    pub(super) fn list(
        &self,
        authority: &[u8],
    ) -> Result<Option<RevocationList>, CertificateError> {
        let path = self.revoked();
        if !exists(&path)? {
            return Ok(None);
        }
        let der = read_pem::<tokio_rustls::rustls::pki_types::CertificateRevocationListDer<'_>>(
            &path,
            "list of revoked certificates",
        )?;
        match RevocationList::read(&der, authority) {
            Some(list) => Ok(Some(list)),
            None => Err(CertificateError::Content(
                path,
                "list of revoked certificates of the site",
            )),
        }
    }

    /// Stores a list if it is newer than the stored one. Returns the newer of both.
    pub(super) fn store_list(
        &self,
        list: RevocationList,
        authority: &[u8],
        _: &FolderLock,
    ) -> Result<RevocationList, CertificateError> {
        match self.list(authority)? {
            Some(kept) if kept.number >= list.number => Ok(kept),
            _ => {
                write(&self.revoked(), &list.to_pem())?;
                Ok(list)
            }
        }
    }
}

/// True if the file exists.
pub(super) fn exists(path: &Path) -> Result<bool, CertificateError> {
    path.try_exists()
        .map_err(|error| CertificateError::Read(path.to_owned(), error))
}

/// Reads the first PEM item of this kind.
pub(super) fn read_pem<T: PemObject>(
    path: &Path,
    what: &'static str,
) -> Result<T, CertificateError> {
    T::from_pem_file(path).map_err(|error| match error {
        pem::Error::Io(error) => CertificateError::Read(path.to_owned(), error),
        _ => CertificateError::Content(path.to_owned(), what),
    })
}

/// Writes a file atomically, accessible to its owner alone.
pub(super) fn write(path: &Path, text: &str) -> Result<(), CertificateError> {
    replace_private(path, text).map_err(|error| CertificateError::Write(path.to_owned(), error))
}

#[cfg(unix)]
fn make_private(folder: &Path) -> io::Result<()> {
    use std::os::unix::fs::{DirBuilderExt, PermissionsExt};

    if let Some(parent) = folder.parent() {
        fs::create_dir_all(parent)?;
    }
    match fs::DirBuilder::new().mode(0o700).create(folder) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            fs::set_permissions(folder, fs::Permissions::from_mode(0o700))
        }
        made => made,
    }
}

#[cfg(not(unix))]
fn make_private(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)
}
