//! Errors of certificates, with hints.

use magician::ErrorKind;
use magician_site::certificates::{CertificateError, JoinError, Refusal};

use crate::failure::{Failure, Kind};

const OTHER_NAME_HINT: &str = "choose another one: --name MACHINE";

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
            Incomplete(..) => "put the file back from a copy, or make a new site of another name",
            Taken(_) | Revoked(_) => OTHER_NAME_HINT,
            Unknown(_) => "`magician site list` shows the machines",
            Own(_) => "make a new site, and let its machines join that one",
            Read(..) | Write(..) => return Self::invalid(message),
            CertificateError::Content(..)
            | CertificateError::Tls(_)
            | CertificateError::Foreign => {
                "put the files of the site back from a copy; a machine that did not make the site may remove \
                 its folder and join again, the one that made it never: the site would be lost"
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
                    "`magician site invite` has to wait there, on the same network: a code that is used up or expired needs a new one; a firewall may be in the way, \
                     and other addresses of that machine are good in the code, too",
                )
            }
            JoinError::WrongAuthority(_) => of_kind(ErrorKind::Unexpected)
                .hint("compare the code with the one on the other screen; if they are alike, do not go on"),
            JoinError::Answer => of_kind(ErrorKind::Unexpected)
                .hint("the other machine may have another version of this program"),
            JoinError::Refused(refusal) => of_kind(ErrorKind::InvalidInput).hint(match refusal {
                Refusal::Secret | Refusal::Over => {
                    "get a new code: `magician site invite` at the machine that made the site"
                }
                Refusal::Name | Refusal::Taken => OTHER_NAME_HINT,
                Refusal::Revoked => {
                    "to come back under another name, remove the folder of the site on this machine, and join with --name MACHINE"
                }
                Refusal::Request | Refusal::Failed => "look at what the other machine says",
            }),
            JoinError::Other(folder) => {
                let folder = folder.display();
                of_kind(ErrorKind::InvalidInput)
                    .hint(format!("if this machine is to leave that one, remove {folder}"))
            }
            JoinError::OtherName(_, folder) => {
                let folder = folder.display();
                of_kind(ErrorKind::InvalidInput).hint(format!(
                    "leave --name out to renew its certificate; for another name remove {folder} first"
                ))
            }
            JoinError::Certificate(error) => error.into(),
            _ => Self::unexpected(message),
        }
    }
}
