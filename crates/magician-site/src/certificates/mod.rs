//! Certificates of a site: one authority, one certificate per machine, and a list of revoked ones.
//!
//! The machine that created the site has its [`Authority`]. Every machine of the site, that one
//! included, has an [`Identity`]: a certificate whose only name is the machine's, and a private key
//! that never leaves the machine. To join, a person carries a [`JoinCode`] from an [`Invitation`]
//! at the authority to the new machine, where [`join`] uses it. The code contains a secret, which
//! lets the machine in, and a fingerprint, by which the machine recognises the authority.
//!
//! A revoked machine stays revoked: its name and key get no certificate again. All files of a site
//! are in one folder, see [`SiteFolder`].

mod authority;
mod code;
mod error;
mod folder;
mod identity;
mod invite;
mod join;
mod list;
#[cfg(test)]
mod tests;
mod tls;
mod wire;
mod x509;

pub use authority::{Authority, Member, SignedCertificate};
pub use code::JoinCode;
pub use error::{CertificateError, JoinError, Refusal};
pub use folder::SiteFolder;
pub use identity::Identity;
pub use invite::{Invitation, InvitationEnd, InvitationEvent};
pub use join::{Joined, join};
pub use x509::{day_of, machine_of};

/// True if the text is a valid machine name: a [name](crate::keys::is_name) that is also a host
/// name, so it does not end with `-` and is not a number.
#[must_use]
pub fn is_machine_name(text: &str) -> bool {
    let is_host = tokio_rustls::rustls::pki_types::DnsName::try_from(text).is_ok();
    crate::keys::is_name(text) && is_host
}
