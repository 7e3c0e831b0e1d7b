//! Certificates of a site: one authority, one certificate for each machine, a list of the revoked.
//!
//! The machine that made a site has its [`Authority`]. Each machine of the site, that one included, has
//! an [`Identity`]: a certificate whose only name is the machine's, and the private key, which never
//! leaves the machine. A machine joins by a [`JoinCode`], which a person carries from an [`Invitation`]
//! at the authority to [`join`]. Files of a site are in one folder, see [`SiteFolder`].

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

pub use authority::{Authority, Member, Signed};
pub use code::JoinCode;
pub use error::{CertificateError, JoinError, Refusal};
pub use folder::SiteFolder;
pub use identity::Identity;
pub use invite::{Invitation, InvitationEnd, InvitationEvent};
pub use join::{Joined, join};
pub use x509::{day_of, machine_of};

/// True if a machine can have this name in its certificate: a [name](crate::keys::is_name) that is a
/// host name too, so it does not end with `-` and is no number.
#[must_use]
pub fn is_machine_name(text: &str) -> bool {
    let is_host = tokio_rustls::rustls::pki_types::DnsName::try_from(text).is_ok();
    crate::keys::is_name(text) && is_host
}
