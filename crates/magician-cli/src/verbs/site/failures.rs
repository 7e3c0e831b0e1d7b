//! Errors of certificates, with hints.

use magician::ErrorKind;
use magician_site::certificates::{CertificateError, JoinError, Refusal};

use crate::failure::{Failure, Kind};

const OTHER_NAME_HINT: &str = "choose another name: --name MACHINE";

impl From<CertificateError> for Failure {
    fn from(error: CertificateError) -> Self {
        use CertificateError::{
            Exists, Incomplete, Name, Own, Read, Revoked, Taken, Unknown, Write,
        };

        let message = error.to_string();
        let hint = match error {
            Name(_) => return Self::usage(message).hint(OTHER_NAME_HINT),
            Exists(_) => {
                "`magician site invite` lets machines join it; a new site needs another name"
            }
            Incomplete(..) => {
                "restore the file from a backup, or create a new site with another name"
            }
            Taken(_) | Revoked(_) => OTHER_NAME_HINT,
            Unknown(_) => "`magician site list` shows the machines",
            Own(_) => "create a new site, and let the machines join it",
            Read(..) | Write(..) => return Self::invalid(message),
            CertificateError::Content(..)
            | CertificateError::Tls(_)
            | CertificateError::Foreign => {
                "restore the files of the site from a backup; a machine that joined the site may \
                    instead remove its folder and join again. On the machine that created the \
                    site, removing the folder destroys the site"
            }
            _ => return Self::unexpected(message),
        };
        Self::invalid(message).hint(hint)
    }
}

impl From<JoinError> for Failure {
    fn from(error: JoinError) -> Self {
        let message = error.to_string();
        let of_kind = |kind| Self::new(Kind::Driver(kind), message.clone());
        match error {
            JoinError::Connection(..) | JoinError::Silent(_) => {
                let kind = match error {
                    JoinError::Silent(_) => ErrorKind::Timeout,
                    _ => ErrorKind::Port,
                };
                of_kind(kind).hint(
                    "`magician site invite` must be waiting there, on the same network: a used or \
                        expired code must be replaced by a new one; a firewall may block the \
                        connection, and other addresses of that machine are also valid in the code",
                )
            }
            JoinError::WrongAuthority(_) => of_kind(ErrorKind::Unexpected).hint(
                "compare the code with the one on the other screen; if they are identical, \
                    do not continue: another machine is answering",
            ),
            JoinError::Answer => of_kind(ErrorKind::Unexpected)
                .hint("the other machine may have another version of this program"),
            JoinError::Refused(refusal) => of_kind(ErrorKind::InvalidInput).hint(match refusal {
                Refusal::Secret | Refusal::Over => {
                    "get a new code: `magician site invite` on the machine that created the site"
                }
                Refusal::Name | Refusal::Taken => OTHER_NAME_HINT,
                Refusal::Revoked => {
                    "to join again under another name, remove the folder of the site on this \
                        machine, and join with --name MACHINE"
                }
                Refusal::Request | Refusal::Failed => "look at the message on the other machine",
            }),
            JoinError::Other(folder) => {
                let folder = folder.display();
                of_kind(ErrorKind::InvalidInput)
                    .hint(format!("to leave that site, remove {folder}"))
            }
            JoinError::OtherName(_, folder) => {
                let folder = folder.display();
                of_kind(ErrorKind::InvalidInput).hint(format!(
                    "omit --name to renew its certificate; for another name remove {folder} first"
                ))
            }
            JoinError::Certificate(error) => error.into(),
            _ => Self::unexpected(message),
        }
    }
}
