//! The tokens of a station, in a file of the user's: made once, kept as digests, revoked at any time.

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

/// A code is good for so long.
pub const CODE: Duration = Duration::from_secs(120);
/// Uses within so many seconds are one, for people who look when a token was used.
const NOTED: u64 = 60;
/// Characters of a token of somebody else's making, at least.
const LEAST: usize = 32;

/// Name of the token of the station's own user. No other one has it: names have no brackets.
const OWN: &str = "(this user)";

/// What is told of a token while the station cannot know whether it is good.
pub const UNCHECKED: &str = "the station cannot check tokens now: try again";

/// A token as its file has it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TokenEntry {
    /// Its role.
    pub role: String,
    /// SHA-256 of it, in hex.
    sha256: String,
    /// When it was made, Unix seconds.
    pub made: u64,
    /// When it was used last, Unix seconds, to the minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub used: Option<u64>,
}

/// A code for which one token is given.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
struct PairingCode {
    /// SHA-256 of it, in hex.
    sha256: String,
    role: String,
    /// Until when it is good, Unix seconds.
    until: u64,
}

#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
struct File {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    code: Vec<PairingCode>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    token: BTreeMap<String, TokenEntry>,
}

/// Why a file of tokens cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum TokenError {
    /// It cannot be read or written.
    Io(PathBuf, io::Error),
    /// It is no file of tokens.
    Damaged(PathBuf, String),
    /// There is a token of this name already.
    Taken(String),
    /// There is no token of this name.
    Unknown(String),
    /// A line of a list of tokens is wrong.
    Line(PathBuf, usize, &'static str),
    /// Others than its owner may read it.
    Open(PathBuf),
    /// The system has no random numbers.
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

/// The file of tokens.
#[derive(Clone, Debug)]
pub struct TokenStore {
    path: PathBuf,
    /// Tokens of another file, which are not written.
    more: BTreeMap<String, (Role, String)>,
    /// What the file held when it was read last. As long as it has not changed, a token is checked without a descriptor: a
    /// station that has none left still lets people in.
    last: Arc<Mutex<Option<ReadFile>>>,
}

/// A file as it was read.
#[derive(Clone, Debug)]
struct ReadFile {
    stamp: Stamp,
    content: Arc<File>,
}

/// What tells one state of a file from another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
    /// Device, inode and change time, which a file that takes the place of another does not share with it.
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
    /// In this file, which need not exist.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            more: BTreeMap::new(),
            last: Arc::default(),
        }
    }

    /// Adds the tokens of a list: `TOKEN ROLE [NAME]` a line, `#` begins a comment.
    ///
    /// # Errors
    /// [`TokenError`], for a file that others may read as well.
    pub fn with_list(mut self, path: &Path) -> Result<Self, TokenError> {
        let io = |error| TokenError::Io(path.to_owned(), error);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            if fs::metadata(path).map_err(io)?.permissions().mode() & 0o077 != 0 {
                return Err(TokenError::Open(path.to_owned()));
            }
        }
        let text = fs::read_to_string(path).map_err(io)?;
        for (at, line) in text.lines().enumerate() {
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
            if token.len() < LEAST || !token.bytes().all(sign) {
                return Err(wrong("a token is at least 32 of A-Z, a-z, 0-9, _ and -"));
            }
            let role = Role::named(role);
            let role = role.ok_or_else(|| wrong("the role is viewer, student or teacher"))?;
            self.more.insert(name, (role, digest(token)));
        }
        Ok(self)
    }

    /// Adds a teacher's token for commands of the station's own user, which counts from this machine alone. Returns it.
    ///
    /// # Errors
    /// [`TokenError::Random`].
    pub fn with_own(mut self) -> Result<(Self, String), TokenError> {
        let token = secret()?;
        let entry = (Role::Teacher, digest(&token));
        self.more.insert(OWN.to_owned(), entry);
        Ok((self, token))
    }

    /// Makes a token, and returns it: it can not be had again.
    ///
    /// # Errors
    /// [`TokenError`].
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

    /// All tokens, by name.
    ///
    /// # Errors
    /// [`TokenError`].
    pub fn list(&self) -> Result<BTreeMap<String, TokenEntry>, TokenError> {
        Ok(self.read()?.token.clone())
    }

    /// Ends a token.
    ///
    /// # Errors
    /// [`TokenError::Unknown`], and the others.
    pub fn revoke(&self, name: &str) -> Result<(), TokenError> {
        self.update(|file| match file.token.remove(name) {
            Some(_) => Ok(()),
            None => Err(TokenError::Unknown(name.to_owned())),
        })
    }

    /// Makes a code of six digits, good for one token of this role within [`CODE`].
    ///
    /// # Errors
    /// [`TokenError`].
    pub fn pair(&self, role: Role) -> Result<String, TokenError> {
        let mut bytes = [0; 8];
        getrandom::fill(&mut bytes).map_err(|_| TokenError::Random)?;
        let code = format!("{:06}", u64::from_le_bytes(bytes) % 1_000_000);
        self.update(|file| {
            file.code.retain(|code| code.until > unix_now());
            file.code.push(PairingCode {
                sha256: digest(&code),
                role: role.name().to_owned(),
                until: unix_now() + CODE.as_secs(),
            });
            Ok(())
        })?;
        Ok(code)
    }

    /// A token for a code; none for one that is not good. A code is good once.
    ///
    /// # Errors
    /// [`TokenError`].
    pub fn redeem(&self, code: &str, name: &str) -> Result<Option<(String, Role)>, TokenError> {
        let wanted = digest(code);
        self.update(|file| {
            let good = |known: &PairingCode| {
                same_secret(&known.sha256, &wanted) && known.until > unix_now()
            };
            let Some(at) = file.code.iter().position(good) else {
                return Ok(None);
            };
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

    /// What a token allows; `None` for one that is not good. It looks at the file, and writes it at times: not to be asked
    /// where others wait.
    ///
    /// # Errors
    /// [`TokenError`] if the file cannot be read, so that nothing is known of the token.
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
        // To the minute: it is for people to read.
        if found
            .used
            .is_none_or(|used| now.saturating_sub(used) >= NOTED)
        {
            let noted = self.update(|file| {
                // It may have been revoked meanwhile.
                if let Some(found) = file.token.get_mut(name) {
                    found.used = Some(now);
                }
                Ok(())
            });
            // A disk that is full locks nobody out.
            if let Err(error) = noted {
                tracing::warn!(%error, "the use of a token is not noted");
            }
        }
        Ok(Some(grant))
    }

    /// As [`grant`](Self::grant), beside everything else that goes on.
    ///
    /// # Errors
    /// As [`grant`](Self::grant).
    pub async fn granted(&self, token: String) -> Result<Option<Grant>, TokenError> {
        let granted = beside(self, move |tokens| tokens.grant(&token)).await;
        let granted = granted.unwrap_or(Ok(None));
        if let Err(error) = &granted {
            tracing::warn!(%error, "a token cannot be checked");
        }
        granted
    }

    /// As [`granted`](Self::granted), for a request that comes from this machine, or from elsewhere.
    pub(super) async fn granted_at(
        &self,
        token: String,
        loopback: bool,
    ) -> Result<Option<Grant>, TokenError> {
        let granted = self.granted(token).await?;
        let is_own = |grant: &Grant| grant.token.as_deref() == Some(OWN);
        Ok(granted.filter(|grant| loopback || !is_own(grant)))
    }

    /// The names of all tokens that are good.
    pub(super) fn names(&self) -> Result<Vec<String>, TokenError> {
        let file = self.read()?;
        let own = file.token.keys().cloned();
        Ok(own.chain(self.more.keys().cloned()).collect())
    }

    /// The file as it is now. It is read only if it has changed.
    fn read(&self) -> Result<Arc<File>, TokenError> {
        let io = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => Ok(Arc::default()),
            _ => Err(TokenError::Io(self.path.clone(), error)),
        };
        // Taken before the file is read: what changes meanwhile is seen by the next look.
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

    /// Changes the file, one program after the other: else one that notes the use of a token brings back another that was
    /// revoked meanwhile.
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
            // Some file systems know no locks.
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

    /// Whole or not at all, and for its owner alone.
    fn write(&self, file: &File) -> Result<(), TokenError> {
        let io = |error| TokenError::Io(self.path.clone(), error);
        let text = toml::to_string(file)
            .map_err(|error| TokenError::Damaged(self.path.clone(), error.to_string()))?;
        replace_private(&self.path, &text).map_err(io)
    }
}

/// Does something with the file where a slow disk holds up nothing else; `None` when the runtime ends.
pub(super) async fn beside<T: Send + 'static>(
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
    /// Whoever comes from elsewhere, with a new secret for its session.
    ///
    /// # Errors
    /// [`TokenError::Random`].
    pub fn elsewhere(grant: Option<Grant>, address: String) -> Result<Self, TokenError> {
        Ok(Self {
            grant,
            origin: Origin::Elsewhere,
            address,
            secret: secret()?,
        })
    }
}

/// 32 random bytes as text.
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
    fn file_that_has_not_changed_is_not_read_again() {
        let (_folder, store, token) = stored();
        assert!(store.grant(&token).unwrap().is_some());
        // The use was noted in the file. What is in memory counts as long as that stays as it is.
        let _ = store.read().unwrap();
        let mut last = store.last.lock().unwrap();
        last.as_mut().unwrap().content = Arc::default();
        drop(last);
        assert!(store.grant(&token).unwrap().is_none());
    }

    #[test]
    fn change_by_another_program_is_seen_by_the_next_look() {
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
    fn file_that_cannot_be_read_is_an_error() {
        let (_folder, store, token) = stored();
        fs::remove_file(&store.path).unwrap();
        fs::create_dir(&store.path).unwrap();
        let error = store.grant(&token).unwrap_err();
        assert!(matches!(error, TokenError::Io(..)), "{error}");
    }
}
