//! The authority of a site: signs the certificates of machines, and revokes them.
//!
//! `members.json` records every certificate before it is handed out, because revocation needs its
//! serial number. All changes hold the lock of the folder, so that several processes may use the
//! authority at once.

use std::fmt;
use std::fs;
use std::io;
use std::path::Path;

use rcgen::{
    CertificateSigningRequestParams, Issuer, KeyPair, PKCS_ECDSA_P256_SHA256, PublicKeyData,
};
use serde::{Deserialize, Serialize};
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;

use super::folder::{FolderLock, exists, read_pem, write};
use super::list::RevocationList;
use super::{CertificateError, Identity, SiteFolder, is_machine_name, tls, x509};
use crate::keys::is_name;

/// Length of an uncompressed P-256 public key, bytes: a tag and two coordinates.
const PUBLIC_KEY_LENGTH: usize = 65;

/// Authority of a site, on the machine that created the site. Several processes may use it at once.
pub struct Authority {
    folder: SiteFolder,
    site: String,
    ends: i64,
    certificate: CertificateDer<'static>,
    issuer: Issuer<'static, KeyPair>,
}

impl fmt::Debug for Authority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Authority")
            .field("site", &self.site)
            .finish_non_exhaustive()
    }
}

/// Machine of a site.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Member {
    /// Name of the machine.
    pub name: String,
    /// End of validity of its latest certificate, Unix seconds.
    pub ends: i64,
    /// Time of revocation, Unix seconds. `None` for a member in good standing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revoked: Option<i64>,
    /// SHA-256 of its public key.
    key: String,
    /// Serial numbers of all its certificates.
    serials: Vec<String>,
}

/// Content of `members.json`.
#[derive(Default, Deserialize, Serialize)]
struct Members {
    members: Vec<Member>,
}

/// Newly signed certificate.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SignedCertificate {
    /// Certificate, PEM.
    pub certificate: String,
    /// End of validity, Unix seconds.
    pub ends: i64,
    /// True if the machine had a certificate before.
    pub is_renewal: bool,
}

impl Authority {
    /// Creates a site: its authority, and the certificate of this machine. A folder left by an
    /// interrupted call is overwritten.
    ///
    /// # Errors
    /// [`CertificateError::Exists`] if the folder already holds a site;
    /// [`CertificateError::Incomplete`] if it holds an authority that has other machines but lacks
    /// a file; [`CertificateError::Name`] for an invalid name; errors of the folder.
    pub fn init(folder: &Path, site: &str, machine: &str) -> Result<Self, CertificateError> {
        if !is_name(site) {
            return Err(CertificateError::Name(site.to_owned()));
        }
        if !is_machine_name(machine) {
            return Err(CertificateError::Name(machine.to_owned()));
        }
        let folder = SiteFolder::at(folder);
        let locked = folder.lock()?;
        if exists(&folder.certificate())? {
            return Err(CertificateError::Exists(folder.path().to_owned()));
        }
        if exists(&folder.members())? && read_members(&folder)?.members.len() > 1 {
            let folder = folder.path().to_owned();
            return Err(CertificateError::Incomplete(folder, "own.pem"));
        }
        // A list left by an earlier authority has to go, because the new one has not signed it.
        match fs::remove_file(folder.revoked()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(CertificateError::Write(folder.revoked(), error));
            }
            _ => {}
        }
        let key = KeyPair::generate()?;
        let params = x509::authority(site)?;
        let certificate = params.self_signed(&key)?;
        write(&folder.authority_key(), &key.serialize_pem())?;
        write(&folder.authority(), &certificate.pem())?;
        write_members(&folder, &Members::default())?;
        let certificate = certificate.der().clone();
        let authority = Self {
            ends: x509::read_authority(&certificate).map_or(0, |(_, ends)| ends),
            issuer: Issuer::new(params, key),
            site: site.to_owned(),
            certificate,
            folder,
        };
        let own = KeyPair::generate()?;
        let request = rcgen::CertificateParams::default().serialize_request(&own)?;
        let signed = authority.sign_locked(&request.pem()?, machine, &locked)?;
        write(&authority.folder.key(), &own.serialize_pem())?;
        write(&authority.folder.certificate(), &signed.certificate)?;
        Ok(authority)
    }

    /// Opens the authority of a site. Returns `None` if this machine does not have it.
    ///
    /// # Errors
    /// A file is missing, unreadable or damaged.
    pub fn open(folder: &Path) -> Result<Option<Self>, CertificateError> {
        let folder = SiteFolder::at(folder);
        if !exists(&folder.authority_key())? || !exists(&folder.certificate())? {
            return Ok(None);
        }
        let certificate: CertificateDer<'_> = read_pem(&folder.authority(), "certificate as PEM")?;
        let Some((site, ends)) = x509::read_authority(&certificate) else {
            let what = "certificate of an authority";
            return Err(CertificateError::Content(folder.authority(), what));
        };
        let key: PrivateKeyDer<'_> = read_pem(&folder.authority_key(), "private key as PEM")?;
        let no_key = || CertificateError::Content(folder.authority_key(), "key of the authority");
        let chain = vec![certificate.clone()];
        CertifiedKey::from_der(chain, key.clone_key(), &ring::default_provider())
            .map_err(|_| no_key())?;
        let key = KeyPair::try_from(&key).map_err(|_| no_key())?;
        let issuer = Issuer::from_ca_cert_der(&certificate, key)?;
        Ok(Some(Self {
            folder,
            site,
            ends,
            certificate,
            issuer,
        }))
    }

    /// Name of the site.
    #[must_use]
    pub fn site(&self) -> &str {
        &self.site
    }

    /// Folder of the site.
    #[must_use]
    pub fn folder(&self) -> &SiteFolder {
        &self.folder
    }

    /// End of validity of the authority's certificate, Unix seconds.
    #[must_use]
    pub fn ends(&self) -> i64 {
        self.ends
    }

    /// SHA-256 of the authority's certificate, in groups of four hexadecimal digits.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        x509::fingerprint(&self.certificate)
    }

    /// Identity of this machine.
    ///
    /// # Errors
    /// Same as [`Identity::open`].
    pub fn identity(&self) -> Result<Identity, CertificateError> {
        let identity = Identity::open(self.folder.path())?;
        identity
            .ok_or_else(|| CertificateError::Incomplete(self.folder.path().to_owned(), "own.pem"))
    }

    /// All machines of the site, revoked ones included, in the order in which they joined.
    ///
    /// # Errors
    /// `members.json` is missing, unreadable or damaged.
    pub fn members(&self) -> Result<Vec<Member>, CertificateError> {
        Ok(read_members(&self.folder)?.members)
    }

    /// Signs the certificate request (PKCS #10, PEM) of a machine.
    ///
    /// Only the key of the request is used. The name has to be new, or belong to a machine with the
    /// same key, whose certificate is then renewed.
    ///
    /// # Errors
    /// [`CertificateError::Name`], [`Taken`](CertificateError::Taken),
    /// [`Revoked`](CertificateError::Revoked), [`Request`](CertificateError::Request); errors of
    /// the folder.
    pub fn sign(&self, request: &str, name: &str) -> Result<SignedCertificate, CertificateError> {
        let locked = self.folder.lock()?;
        self.sign_locked(request, name, &locked)
    }

    fn sign_locked(
        &self,
        request: &str,
        name: &str,
        _: &FolderLock,
    ) -> Result<SignedCertificate, CertificateError> {
        if !is_machine_name(name) {
            return Err(CertificateError::Name(name.to_owned()));
        }
        // Parsing checks that the request is signed by its own key. The sender does not matter:
        // only the owner of the key can use the certificate.
        let request = CertificateSigningRequestParams::from_pem(request)
            .map_err(|_| CertificateError::Request)?;
        let key = &request.public_key;
        let is_p256 = key.algorithm() == &PKCS_ECDSA_P256_SHA256;
        if !is_p256 || key.der_bytes().len() != PUBLIC_KEY_LENGTH {
            return Err(CertificateError::Request);
        }
        let params = x509::machine(name, self.ends)?;
        let made = params.signed_by(key, &self.issuer)?;
        let details = x509::read_machine(made.der()).ok_or(CertificateError::Request)?;

        let mut members = read_members(&self.folder)?;
        let is_revoked = |member: &&Member| {
            member.revoked.is_some() && (member.name == name || member.key == details.key)
        };
        if let Some(revoked_member) = members.members.iter().find(is_revoked) {
            return Err(CertificateError::Revoked(revoked_member.name.clone()));
        }
        let known = members
            .members
            .iter_mut()
            .find(|member| member.name == name);
        let is_renewal = known.is_some();
        match known {
            Some(member) if member.key == details.key => {
                member.ends = details.ends;
                member.serials.push(x509::hex(&details.serial));
            }
            Some(_) => return Err(CertificateError::Taken(name.to_owned())),
            None => members.members.push(Member {
                name: name.to_owned(),
                ends: details.ends,
                revoked: None,
                key: details.key,
                serials: vec![x509::hex(&details.serial)],
            }),
        }
        // Before the certificate is handed out: without this record it could not be revoked.
        write_members(&self.folder, &members)?;
        Ok(SignedCertificate {
            certificate: made.pem(),
            ends: details.ends,
            is_renewal,
        })
    }

    /// Revokes all certificates of a machine and returns the new list, DER. Idempotent.
    ///
    /// # Errors
    /// [`CertificateError::Unknown`] for an unknown name; [`CertificateError::Own`] for the
    /// authority's own machine, which could not be admitted again; errors of the folder.
    pub fn revoke(&self, name: &str) -> Result<Vec<u8>, CertificateError> {
        if self.identity()?.machine() == name {
            return Err(CertificateError::Own(name.to_owned()));
        }
        let locked = self.folder.lock()?;
        let mut members = read_members(&self.folder)?;
        let known = members
            .members
            .iter_mut()
            .find(|member| member.name == name);
        let known = known.ok_or_else(|| CertificateError::Unknown(name.to_owned()))?;
        known.revoked = known.revoked.or_else(|| Some(x509::now()));
        // First: from here on the name gets no certificate, even if writing the list fails.
        write_members(&self.folder, &members)?;

        let mut revoked: Vec<_> = { members.members.iter() }
            .filter_map(|member| Some((&member.serials, member.revoked?)))
            .flat_map(|(serials, at)| serials.iter().map(move |serial| (serial, at)))
            .filter_map(|(serial, at)| Some((x509::unhex(serial)?, at)))
            .collect();
        let kept = self.folder.list(&self.certificate)?;
        if let Some(kept) = &kept
            && revoked.iter().all(|(serial, _)| kept.has(serial))
        {
            return Ok(kept.der().to_vec());
        }
        let now = x509::now();
        if let Some(kept) = &kept {
            // Serials on the old list stay revoked. If the folder was restored from a backup,
            // `members.json` does not know them, but this machine has learned the list from others.
            let others = { kept.serials.iter() }
                .filter(|serial| revoked.iter().all(|(known, _)| known != *serial));
            let others: Vec<_> = others.map(|serial| (serial.clone(), now)).collect();
            revoked.extend(others);
        }
        // CRL numbers must grow even if the own list was lost, so start from the clock.
        let number = kept.map_or(1, |kept| kept.number.saturating_add(1));
        let number = number.max(u64::try_from(now).unwrap_or(0));
        let list = x509::list(number, &revoked).signed_by(&self.issuer)?;
        let list =
            RevocationList::read(list.der(), &self.certificate).ok_or(CertificateError::List)?;
        let list = self.folder.store_list(list, &self.certificate, &locked)?;
        Ok(list.der().to_vec())
    }

    /// Certificate of the authority, DER.
    pub(super) fn certificate(&self) -> &CertificateDer<'static> {
        &self.certificate
    }

    /// TLS configuration that shows the certificate of the authority itself.
    pub(super) fn invitation_server(&self) -> Result<ServerConfig, CertificateError> {
        let key = self.issuer.key().serialize_der();
        let key = PrivateKeyDer::try_from(key).map_err(|_| {
            CertificateError::Content(self.folder.authority_key(), "key of the authority")
        })?;
        Ok(tls::invitation_server((self.certificate.clone(), key))?)
    }
}

fn read_members(folder: &SiteFolder) -> Result<Members, CertificateError> {
    let path = folder.members();
    let text = match fs::read_to_string(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let folder = folder.path().to_owned();
            return Err(CertificateError::Incomplete(folder, "members.json"));
        }
        read => read.map_err(|error| CertificateError::Read(path.clone(), error))?,
    };
    serde_json::from_str(&text)
        .map_err(|_| CertificateError::Content(path, "list of a site's machines"))
}

fn write_members(folder: &SiteFolder, members: &Members) -> Result<(), CertificateError> {
    // Cannot fail: members consist of strings and numbers.
    let text = serde_json::to_string_pretty(members).unwrap_or_default();
    write(&folder.members(), &(text + "\n"))
}
