//! Errors about certificates, as data. Front ends add what to do about them.

use std::fmt;
use std::io;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use tokio_rustls::rustls;

/// Reason why a certificate, key or list cannot be made, read or used.
#[derive(Debug)]
#[non_exhaustive]
pub enum CertificateError {
    /// A file cannot be read.
    Read(PathBuf, io::Error),
    /// A file cannot be written, or a folder not be made.
    Write(PathBuf, io::Error),
    /// A file has the wrong content. Names the expected one.
    Content(PathBuf, &'static str),
    /// The folder already holds a site.
    Exists(PathBuf),
    /// The folder holds an authority with machines, but lacks a necessary file.
    Incomplete(PathBuf, &'static str),
    /// Invalid name of a site or machine.
    Name(String),
    /// Another machine has this name.
    Taken(String),
    /// The machine of this name was revoked. Its name is never used again.
    Revoked(String),
    /// The authority knows no machine of this name.
    Unknown(String),
    /// The authority's own machine cannot be revoked.
    Own(String),
    /// The certificate request is damaged, or not signed by its own key.
    Request,
    /// The bytes are not a list of revoked certificates signed by the authority.
    List,
    /// The certificate was not signed by the authority of the site.
    Foreign,
    /// The operating system provides no random numbers.
    Random,
    /// A certificate cannot be made.
    Make(rcgen::Error),
    /// TLS cannot use the certificate with this key.
    Tls(rustls::Error),
}

impl fmt::Display for CertificateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(path, error) => write!(f, "{} cannot be read: {error}", path.display()),
            Self::Write(path, error) => write!(f, "{} cannot be written: {error}", path.display()),
            Self::Content(path, what) => write!(f, "{} holds no {what}", path.display()),
            Self::Exists(folder) => write!(f, "{} holds a site already", folder.display()),
            Self::Incomplete(folder, file) => {
                write!(
                    f,
                    "{} lacks {file} of the site's authority",
                    folder.display()
                )
            }
            Self::Name(name) => write!(
                f,
                "`{}` is no name: a-z, 0-9, _ and -, 32 at most, with a letter or digit at both ends, \
                 and no number",
                magician_protocol::visible(name)
            ),
            Self::Taken(name) => write!(f, "another machine has the name {name}"),
            Self::Revoked(name) => write!(f, "{name} was revoked; the name is never given again"),
            Self::Unknown(name) => write!(
                f,
                "the site has no machine {}",
                magician_protocol::visible(name)
            ),
            Self::Own(name) => write!(f, "{name} has the authority, and cannot be revoked"),
            Self::Request => f.write_str("the request for a certificate is damaged"),
            Self::List => f.write_str("this is no list of revoked certificates of the site"),
            Self::Foreign => f.write_str("the certificate is not of the site's authority"),
            Self::Random => f.write_str("the system has no random numbers"),
            Self::Make(error) => write!(f, "the certificate cannot be made: {error}"),
            Self::Tls(error) => write!(f, "the certificate cannot be used: {error}"),
        }
    }
}

impl std::error::Error for CertificateError {}

impl From<rcgen::Error> for CertificateError {
    fn from(error: rcgen::Error) -> Self {
        Self::Make(error)
    }
}

impl From<rustls::Error> for CertificateError {
    fn from(error: rustls::Error) -> Self {
        Self::Tls(error)
    }
}

/// Reason why an invitation refused a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// The secret of the code is wrong.
    Secret,
    /// The code is no longer valid: used up, expired, or too many wrong attempts.
    Over,
    /// Invalid machine name.
    Name,
    /// Another machine has the name.
    Taken,
    /// The machine of this name was revoked.
    Revoked,
    /// The certificate request is damaged.
    Request,
    /// The authority failed. Its own user sees the reason.
    Failed,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Secret => "the code is wrong",
            Self::Over => "the code is no longer good",
            Self::Name => "no machine can have this name",
            Self::Taken => "another machine has this name",
            Self::Revoked => "the machine of this name was revoked; the name is never given again",
            Self::Request => "the request was damaged",
            Self::Failed => "the authority could not make the certificate",
        })
    }
}

/// Reason why a machine could not join.
#[derive(Debug)]
#[non_exhaustive]
pub enum JoinError {
    /// The address is unreachable, or the connection broke.
    Connection(String, io::Error),
    /// No answer from the address in time.
    Silent(String),
    /// The peer is not the authority that made the code. No secret was sent to it.
    WrongAuthority(String),
    /// The peer's reply is malformed.
    Answer,
    /// The authority refused the machine.
    Refused(Refusal),
    /// The folder belongs to another site with the same name, or to the authority itself.
    Other(PathBuf),
    /// This machine is already on the site under another name. Gives that name and the folder.
    OtherName(String, PathBuf),
    /// Error about files or certificates.
    Certificate(CertificateError),
}

impl fmt::Display for JoinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connection(address, error) => write!(f, "{address} cannot be reached: {error}"),
            Self::Silent(address) => write!(f, "{address} does not answer"),
            Self::WrongAuthority(address) => write!(
                f,
                "{address} is not the machine that made this code, or the code is mistyped; nothing \
                 secret was sent"
            ),
            Self::Answer => f.write_str("the answer is not that of a site"),
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Other(folder) => write!(
                f,
                "{} is of another site with the same name",
                folder.display()
            ),
            Self::OtherName(name, _) => write!(f, "this machine is {name} on the site already"),
            Self::Certificate(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for JoinError {}

impl From<CertificateError> for JoinError {
    fn from(error: CertificateError) -> Self {
        Self::Certificate(error)
    }
}
