//! Tokens of a station: created once, stored as digests, revocable at any time.
//!
//! The file belongs to the user and is shared by all stations and by the command line, which change
//! it under a lock. A token is checked against the file as it is now, so a revocation takes effect
//! without a restart; the content is cached by the file's metadata.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use magician::admission::Origin;
use magician_job::files::replace_private;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::Role;
use crate::secret::same_secret;
use crate::station::{Grant, Peer};

/// Lifetime of a pairing code.
pub const CODE_LIFETIME: Duration = Duration::from_secs(120);
/// Resolution of the time of last use, s. Finer times would rewrite the file with every request.
const USE_RESOLUTION: u64 = 60;
/// Least number of characters of a token that the user has made.
const MIN_TOKEN_LENGTH: usize = 32;

/// Name of the token for the station's own user. Pairing and lists of tokens cannot produce this
/// name. A token created with it on the command line is valid on this machine alone.
const OWN_TOKEN_NAME: &str = "(this user)";

/// Message while the station cannot check a token.
pub const TOKENS_UNAVAILABLE: &str = "the station cannot check tokens now: try again";

/// Stored token.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TokenEntry {
    /// Role.
    pub role: String,
    /// SHA-256 of the token, hexadecimal.
    sha256: String,
    /// Creation, Unix seconds.
    pub made: u64,
    /// Last use, Unix seconds, to the minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub used: Option<u64>,
}

/// Pairing code, good for one token.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
struct PairingCode {
    /// SHA-256 of the code, hexadecimal.
    sha256: String,
    role: String,
    /// Expiry, Unix seconds.
    until: u64,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
struct File {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    code: Vec<PairingCode>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    token: BTreeMap<String, TokenEntry>,
}

/// Reason why a file of tokens cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum TokenError {
    /// The file cannot be read or written.
    Io(PathBuf, io::Error),
    /// The file is not a valid file of tokens.
    Damaged(PathBuf, String),
    /// The name is used by another token.
    Taken(String),
    /// No token has this name.
    Unknown(String),
    /// A line in a list of tokens is invalid.
    Line(PathBuf, usize, &'static str),
    /// Others than the owner can read the file.
    Open(PathBuf),
    /// The system provides no random numbers.
    Random,
}

impl std::fmt::Display for TokenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Damaged(path, why) => write!(f, "{} is damaged: {why}", path.display()),
            Self::Taken(name) => write!(f, "there is a token {name} already"),
            Self::Unknown(name) => write!(f, "there is no token {name}"),
            Self::Line(path, line, why) => write!(f, "{}, line {line}: {why}", path.display()),
            Self::Open(path) => write!(
                f,
                "{} can be read by others than its owner: chmod 600 it",
                path.display()
            ),
            Self::Random => f.write_str("the system gives no random numbers"),
        }
    }
}

impl std::error::Error for TokenError {}

/// File of tokens.
#[derive(Clone, Debug)]
pub struct TokenStore {
    path: PathBuf,
    /// Tokens from a list, which are never written.
    more: BTreeMap<String, (Role, String)>,
    /// Content when the file was read last. While the file is unchanged, a token is checked without
    /// opening it: a station out of descriptors can still admit clients.
    last: Arc<Mutex<Option<ReadFile>>>,
}

/// Content of a file with its stamp.
#[derive(Clone, Debug)]
struct ReadFile {
    stamp: Stamp,
    content: Arc<File>,
}

/// Metadata that identifies a version of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
    /// Device, inode and change time. They differ if another file was moved into its place.
    #[cfg(unix)]
    identity: (u64, u64, i64, i64),
}

impl Stamp {
    fn of(metadata: &fs::Metadata) -> Self {
        #[cfg(unix)]
        use std::os::unix::fs::MetadataExt;
        Self {
            modified: metadata.modified().ok(),
            length: metadata.len(),
            #[cfg(unix)]
            identity: (
                metadata.dev(),
                metadata.ino(),
                metadata.ctime(),
                metadata.ctime_nsec(),
            ),
        }
    }
}

impl TokenStore {
    /// Uses this file, which need not exist.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            more: BTreeMap::new(),
            last: Arc::default(),
        }
    }

    /// Adds tokens from a list with lines `TOKEN ROLE [NAME]`; `#` starts a comment.
    ///
    /// # Errors
    /// [`TokenError`] if a line is invalid, or others than the owner can read the file.
    pub fn with_list(mut self, path: &Path) -> Result<Self, TokenError> {
        let io = |error| TokenError::Io(path.to_owned(), error);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Tokens in this file are plain text, unlike those in the store.
            if fs::metadata(path).map_err(io)?.permissions().mode() & 0o077 != 0 {
                return Err(TokenError::Open(path.to_owned()));
            }
        }
        let text = fs::read_to_string(path).map_err(io)?;
        for (at, line) in text.lines().enumerate() {
            // Tokens contain no `#`, so comments need no escaping.
            let line = line.split('#').next().unwrap_or_default();
            let words: Vec<_> = line.split_whitespace().collect();
            let wrong = |why| TokenError::Line(path.to_owned(), at + 1, why);
            let (token, role, name) = match words.as_slice() {
                [] => continue,
                [token, role] => (*token, *role, format!("line-{}", at + 1)),
                [token, role, name] => (*token, *role, (*name).to_owned()),
                _ => return Err(wrong("expected TOKEN ROLE [NAME]")),
            };
            let sign = |byte: u8| byte.is_ascii_alphanumeric() || b"_-".contains(&byte);
            if token.len() < MIN_TOKEN_LENGTH || !token.bytes().all(sign) {
                return Err(wrong("a token is at least 32 of A-Z, a-z, 0-9, _ and -"));
            }
            let role = Role::named(role);
            let role = role.ok_or_else(|| wrong("the role is viewer, student or teacher"))?;
            // Kept as a digest like the others, so that memory holds no token.
            self.more.insert(name, (role, digest(token)));
        }
        Ok(self)
    }

    /// Adds a teacher's token for commands of the station's own user, valid on this machine alone.
    /// Returns it.
    ///
    /// # Errors
    /// [`TokenError::Random`] if the system provides no random numbers.
    pub fn with_own(mut self) -> Result<(Self, String), TokenError> {
        let token = secret()?;
        let entry = (Role::Teacher, digest(&token));
        self.more.insert(OWN_TOKEN_NAME.to_owned(), entry);
        Ok((self, token))
    }

    /// Creates a token and returns its name and text. The text is not stored and cannot be shown
    /// again.
    ///
    /// # Errors
    /// [`TokenError`] if the name is taken or the file cannot be written.
    pub fn create(&self, name: Option<&str>, role: Role) -> Result<(String, String), TokenError> {
        self.update(|file| {
            let name = match name {
                Some(name) if file.token.contains_key(name) => {
                    return Err(TokenError::Taken(name.to_owned()));
                }
                Some(name) => name.to_owned(),
                None => free_name(file),
            };
            let token = secret()?;
            file.token.insert(name.clone(), entry(&token, role));
            Ok((name, token))
        })
    }

    /// Returns all tokens by name.
    ///
    /// # Errors
    /// [`TokenError`] if the file cannot be read.
    pub fn list(&self) -> Result<BTreeMap<String, TokenEntry>, TokenError> {
        Ok(self.read()?.token.clone())
    }

    /// Revokes a token.
    ///
    /// # Errors
    /// [`TokenError::Unknown`] if there is no such token, or an error of the file.
    pub fn revoke(&self, name: &str) -> Result<(), TokenError> {
        self.update(|file| match file.token.remove(name) {
            Some(_) => Ok(()),
            None => Err(TokenError::Unknown(name.to_owned())),
        })
    }

    /// Creates a code of six digits, good for one token with this role within [`CODE_LIFETIME`].
    ///
    /// # Errors
    /// [`TokenError`] if the file cannot be written.
    pub fn pair(&self, role: Role) -> Result<String, TokenError> {
        let mut bytes = [0; 8];
        getrandom::fill(&mut bytes).map_err(|_| TokenError::Random)?;
        let code = format!("{:06}", u64::from_le_bytes(bytes) % 1_000_000);
        self.update(|file| {
            // Expired codes are removed whenever a new one is made.
            file.code.retain(|code| code.until > unix_now());
            file.code.push(PairingCode {
                sha256: digest(&code),
                role: role.name().to_owned(),
                until: unix_now() + CODE_LIFETIME.as_secs(),
            });
            Ok(())
        })?;
        Ok(code)
    }

    /// Exchanges a code for a token. `None` if the code is wrong or expired. A code can be used
    /// once.
    ///
    /// # Errors
    /// [`TokenError`] if the file cannot be written.
    pub fn redeem(&self, code: &str, name: &str) -> Result<Option<(String, Role)>, TokenError> {
        let wanted = digest(code);
        self.update(|file| {
            let good = |known: &PairingCode| {
                same_secret(&known.sha256, &wanted) && known.until > unix_now()
            };
            let Some(at) = file.code.iter().position(good) else {
                return Ok(None);
            };
            // Used up even if no token can be made from it.
            let known = file.code.remove(at);
            let Some(role) = Role::named(&known.role) else {
                return Ok(None);
            };
            let mut own = name.to_owned();
            if own.is_empty() || file.token.contains_key(&own) {
                own = free_name(file);
            }
            let token = secret()?;
            file.token.insert(own, entry(&token, role));
            Ok(Some((token, role)))
        })
    }

    /// Returns the rights of a token. `None` if it is not valid. Reads the file and sometimes
    /// writes it, so it may block.
    ///
    /// # Errors
    /// [`TokenError`] if the file cannot be read: then it is unknown whether the token is valid.
    pub fn grant(&self, token: &str) -> Result<Option<Grant>, TokenError> {
        let wanted = digest(token);
        let more = { self.more.iter() }.find(|(_, (_, sha256))| same_secret(sha256, &wanted));
        if let Some((name, (role, _))) = more {
            return Ok(Some(Grant {
                role: *role,
                token: Some(name.clone()),
            }));
        }
        let file = self.read()?;
        let found = { file.token.iter() }.find(|(_, known)| same_secret(&known.sha256, &wanted));
        let Some((name, found)) = found else {
            return Ok(None);
        };
        let Some(role) = Role::named(&found.role) else {
            return Ok(None);
        };
        let grant = Grant {
            role,
            token: Some(name.clone()),
        };
        let now = unix_now();
        // Only once a minute: the time is for people, and each note rewrites the file.
        if found
            .used
            .is_none_or(|used| now.saturating_sub(used) >= USE_RESOLUTION)
        {
            let noted = self.update(|file| {
                // The token may have been revoked meanwhile.
                if let Some(found) = file.token.get_mut(name) {
                    found.used = Some(now);
                }
                Ok(())
            });
            // A full disk must not lock anyone out.
            if let Err(error) = noted {
                tracing::warn!(%error, "the use of a token is not noted");
            }
        }
        Ok(Some(grant))
    }

    /// Returns the rights of a token, from a blocking thread.
    ///
    /// # Errors
    /// The same as [`grant`](Self::grant).
    pub async fn granted(&self, token: String) -> Result<Option<Grant>, TokenError> {
        let granted = run_blocking(self, move |tokens| tokens.grant(&token)).await;
        let granted = granted.unwrap_or(Ok(None));
        if let Err(error) = &granted {
            tracing::warn!(%error, "a token cannot be checked");
        }
        granted
    }

    /// Returns the rights of a token for a request from this machine or from elsewhere.
    pub(super) async fn granted_at(
        &self,
        token: String,
        loopback: bool,
    ) -> Result<Option<Grant>, TokenError> {
        let granted = self.granted(token).await?;
        // The token of the station's own user is not valid from elsewhere.
        let is_own = |grant: &Grant| grant.token.as_deref() == Some(OWN_TOKEN_NAME);
        Ok(granted.filter(|grant| loopback || !is_own(grant)))
    }

    /// Returns the names of all valid tokens.
    pub(super) fn names(&self) -> Result<Vec<String>, TokenError> {
        let file = self.read()?;
        let own = file.token.keys().cloned();
        Ok(own.chain(self.more.keys().cloned()).collect())
    }

    /// Returns the content of the file. Reads it only if it has changed.
    fn read(&self) -> Result<Arc<File>, TokenError> {
        let io = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => Ok(Arc::default()),
            _ => Err(TokenError::Io(self.path.clone(), error)),
        };
        // The stamp is taken first: a change during reading is found by the next call.
        let stamp = match fs::metadata(&self.path) {
            Ok(metadata) => Stamp::of(&metadata),
            Err(error) => return io(error),
        };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = last.as_ref().filter(|last| last.stamp == stamp) {
            return Ok(Arc::clone(&last.content));
        }
        let text = match fs::read_to_string(&self.path) {
            Ok(text) => text,
            Err(error) => return io(error),
        };
        let file: File = toml::from_str(&text)
            .map_err(|error| TokenError::Damaged(self.path.clone(), error.message().to_owned()))?;
        let content = Arc::new(file);
        *last = Some(ReadFile {
            stamp,
            content: Arc::clone(&content),
        });
        Ok(content)
    }

    /// Changes the file under a lock. Without it, a program that notes the use of a token could
    /// write back a token that another program has just revoked.
    fn update<T>(
        &self,
        change: impl FnOnce(&mut File) -> Result<T, TokenError>,
    ) -> Result<T, TokenError> {
        let io = |error| TokenError::Io(self.path.clone(), error);
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder).map_err(io)?;
        }
        let mut options = fs::File::options();
        options.write(true).create(true).truncate(false);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let lock = options.open(self.path.with_extension("lock")).map_err(io)?;
        match lock.lock() {
            // Some file systems, such as network mounts, support no locks: go on without.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => return Err(io(error)),
            _ => {}
        }
        let before = self.read()?;
        let mut file = File::clone(&before);
        let changed = change(&mut file)?;
        if file != *before {
            self.write(&file)?;
        }
        Ok(changed)
    }

    /// Replaces the file as a whole, readable by its owner alone.
    fn write(&self, file: &File) -> Result<(), TokenError> {
        let io = |error| TokenError::Io(self.path.clone(), error);
        let text = toml::to_string(file)
            .map_err(|error| TokenError::Damaged(self.path.clone(), error.to_string()))?;
        replace_private(&self.path, &text).map_err(io)
    }
}

/// Runs a function on a blocking thread, because the disk may be slow. `None` if the runtime shuts
/// down.
pub(super) async fn run_blocking<T: Send + 'static>(
    tokens: &TokenStore,
    act: impl FnOnce(TokenStore) -> T + Send + 'static,
) -> Option<T> {
    let tokens = tokens.clone();
    tokio::task::spawn_blocking(move || act(tokens)).await.ok()
}

fn entry(token: &str, role: Role) -> TokenEntry {
    TokenEntry {
        role: role.name().to_owned(),
        sha256: digest(token),
        made: unix_now(),
        used: None,
    }
}

fn free_name(file: &File) -> String {
    let mut names = (1..).map(|number| format!("token-{number}"));
    names
        .find(|name| !file.token.contains_key(name))
        .unwrap_or_default()
}

impl Peer {
    /// Creates a peer from elsewhere, with a new secret for its session.
    ///
    /// # Errors
    /// [`TokenError::Random`] if the system provides no random numbers.
    pub fn elsewhere(grant: Option<Grant>, address: String) -> Result<Self, TokenError> {
        Ok(Self {
            grant,
            origin: Origin::Elsewhere,
            address,
            secret: secret()?,
        })
    }
}

/// Returns 32 random bytes as text.
fn secret() -> Result<String, TokenError> {
    use base64::Engine;
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(|_| TokenError::Random)?;
    Ok(base64::engine::general_purpose::URL_SAFE_NO_PAD.encode(bytes))
}

fn digest(text: &str) -> String {
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unix_now() -> u64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored() -> (tempfile::TempDir, TokenStore, String) {
        let folder = tempfile::TempDir::new().unwrap();
        let store = TokenStore::at(folder.path().join("tokens.toml"));
        let token = store.create(Some("anna"), Role::Student).unwrap().1;
        (folder, store, token)
    }

    #[test]
    fn unchanged_token_file_is_not_reread() {
        let (_folder, store, token) = stored();
        assert!(store.grant(&token).unwrap().is_some());
        // The use was noted in the file; the cached content stays valid while the file is
        // unchanged.
        let _ = store.read().unwrap();
        let mut last = store.last.lock().unwrap();
        last.as_mut().unwrap().content = Arc::default();
        drop(last);
        assert!(store.grant(&token).unwrap().is_none());
    }

    #[test]
    fn foreign_change_is_seen_by_the_next_read() {
        let (_folder, store, token) = stored();
        let other = TokenStore::at(store.path.clone());
        for _ in 0..20 {
            assert!(store.grant(&token).unwrap().is_some());
            let second = other.create(Some("ben"), Role::Viewer).unwrap().1;
            assert!(store.grant(&second).unwrap().is_some());
            other.revoke("ben").unwrap();
            assert!(store.grant(&second).unwrap().is_none());
        }
        fs::remove_file(&store.path).unwrap();
        assert!(store.grant(&token).unwrap().is_none());
    }

    #[test]
    fn unreadable_token_file_is_an_error() {
        let (_folder, store, token) = stored();
        fs::remove_file(&store.path).unwrap();
        fs::create_dir(&store.path).unwrap();
        let error = store.grant(&token).unwrap_err();
        assert!(matches!(error, TokenError::Io(..)), "{error}");
    }
}
