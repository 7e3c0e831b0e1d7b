//! The code with which a machine joins a site.

use std::fmt;
use std::str::FromStr;

use sha2::{Digest, Sha256};

use super::CertificateError;

/// Crockford's base 32, without I, L, O and U, which are easily confused.
const SYMBOLS: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";
/// Symbols of the secret: 65 bits.
const SECRET_SYMBOLS: usize = 13;
/// Symbols of the check: 60 bits.
const CHECK_SYMBOLS: usize = 12;
/// Symbols per group.
const GROUP_SYMBOLS: usize = 5;
/// Longest host name with a port, characters.
const MAX_ADDRESS_LENGTH: usize = 261;

/// Code of an invitation: `HOST:PORT/XXXXX-XXXXX-XXXXX-XXXXX-XXXXX`.
///
/// It contains the address, 65 bits of secret and 60 bits of fingerprint. Case and hyphens are
/// ignored; O is read as 0, I and L as 1.
///
/// The fingerprint covers secret and certificate together. An attacker therefore cannot search in
/// advance for a certificate that matches future codes, and a mistyped secret does not match, so it
/// never leaves the joining machine.
#[derive(Clone, PartialEq, Eq)]
pub struct JoinCode {
    address: String,
    secret: String,
    check: String,
}

impl fmt::Debug for JoinCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("JoinCode")
            .field("address", &self.address)
            .finish_non_exhaustive()
    }
}

impl JoinCode {
    /// Creates the code of an invitation at `address`, `HOST:PORT`.
    pub(super) fn new(address: &str, secret: &str, authority: &[u8]) -> Self {
        Self {
            address: address.to_owned(),
            secret: secret.to_owned(),
            check: check(secret, authority),
        }
    }

    /// Address of the invitation, `HOST:PORT`.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    pub(super) fn secret(&self) -> &str {
        &self.secret
    }

    /// True if the authority with this certificate made the code.
    pub(super) fn is_of(&self, authority: &[u8]) -> bool {
        self.check == check(&self.secret, authority)
    }
}

/// Generates the secret of an invitation.
pub(super) fn new_secret() -> Result<String, CertificateError> {
    let mut bytes = [0; SECRET_SYMBOLS];
    getrandom::fill(&mut bytes).map_err(|_| CertificateError::Random)?;
    Ok(symbols(&bytes))
}

/// First 60 bits of the fingerprint of secret and certificate.
fn check(secret: &str, authority: &[u8]) -> String {
    let digest = { Sha256::new() }
        .chain_update(b"magician site join\0")
        .chain_update(secret)
        .chain_update(authority)
        .finalize();
    symbols(&digest[..CHECK_SYMBOLS])
}

/// Encodes the lowest 5 bits of each byte as one symbol.
fn symbols(bytes: &[u8]) -> String {
    let symbol = |byte: &u8| char::from(SYMBOLS[usize::from(byte & 31)]);
    bytes.iter().map(symbol).collect()
}

/// Maps a typed character to its symbol, look-alikes included. `None` if it is invalid.
fn symbol_of(typed: char) -> Option<char> {
    let symbol = match typed.to_ascii_uppercase() {
        'O' => '0',
        'I' | 'L' => '1',
        other => other,
    };
    SYMBOLS
        .contains(&u8::try_from(symbol).ok()?)
        .then_some(symbol)
}

impl fmt::Display for JoinCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/", self.address)?;
        for (at, symbol) in self.secret.chars().chain(self.check.chars()).enumerate() {
            let hyphen = if at > 0 && at % GROUP_SYMBOLS == 0 {
                "-"
            } else {
                ""
            };
            write!(f, "{hyphen}{symbol}")?;
        }
        Ok(())
    }
}

impl FromStr for JoinCode {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let rule = "a code is HOST:PORT/XXXXX-XXXXX-XXXXX-XXXXX-XXXXX";
        let (address, typed) = text.trim().rsplit_once('/').ok_or(rule)?;
        let (host, port) = address.rsplit_once(':').ok_or(rule)?;
        let is_host = |c: char| c.is_ascii_alphanumeric() || "-_.:[]%".contains(c);
        let is_address = !host.is_empty()
            && address.len() <= MAX_ADDRESS_LENGTH
            && host.chars().all(is_host)
            && port.parse::<u16>().is_ok_and(|port| port > 0);
        let typed = typed.chars().filter(|c| *c != '-' && !c.is_whitespace());
        let typed: String = typed.map(symbol_of).collect::<Option<_>>().ok_or(rule)?;
        if !is_address || typed.len() != SECRET_SYMBOLS + CHECK_SYMBOLS {
            return Err(rule);
        }
        let (secret, check) = typed.split_at(SECRET_SYMBOLS);
        Ok(Self {
            address: address.to_owned(),
            secret: secret.to_owned(),
            check: check.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AUTHORITY: &[u8] = b"any bytes";

    #[test]
    fn code_parses_in_displayed_and_typed_forms() {
        let code = JoinCode::new("192.168.1.5:41234", "01ABCDEFGHJKM", AUTHORITY);
        let text = code.to_string();
        assert!(
            text.starts_with("192.168.1.5:41234/01ABC-DEFGH-JKM"),
            "{text}"
        );
        assert_eq!(text.len(), "192.168.1.5:41234/".len() + 29);
        let typed = text.replace('-', "").to_lowercase();
        let looked_alike = text.replacen("/01", "/oL", 1);
        for text in [&text, &typed, &looked_alike, &format!(" {text}\n")] {
            assert_eq!(text.parse(), Ok(code.clone()), "{text}");
        }
        assert!(!format!("{code:?}").contains("ABC"), "no secret in a log");
    }

    #[test]
    fn code_with_another_host_remains_valid() {
        for host in ["bench-3.local:1", "[fe80::1%eth0]:65535", "10.0.0.1:80"] {
            let code = JoinCode::new(host, "01ABCDEFGHJKM", AUTHORITY);
            assert_eq!(code.to_string().parse(), Ok(code.clone()));
            assert_eq!(code.address(), host);
            assert!(code.is_of(AUTHORITY));
        }
    }

    #[test]
    fn wrong_symbol_anywhere_fails_the_check() {
        let code = JoinCode::new("a:1", "01ABCDEFGHJKM", AUTHORITY);
        let text = code.to_string();
        for (at, symbol) in text.char_indices().skip("a:1/".len()) {
            let wrong = if symbol == '7' { "8" } else { "7" };
            let mut wrongly = text.clone();
            wrongly.replace_range(at..=at, wrong);
            if let Ok(code) = wrongly.parse::<JoinCode>() {
                assert!(!code.is_of(AUTHORITY), "{wrongly}");
            }
        }
        assert!(!code.is_of(b"other bytes"));
    }

    #[test]
    fn malformed_codes_are_refused() {
        let good = "01ABC-DEFGH-JKMNP-QRSTV-WXYZ0";
        assert!(format!("a:1/{good}").parse::<JoinCode>().is_ok());
        for wrong in [
            String::new(),
            good.to_owned(),
            format!("a/{good}"),
            format!("a:/{good}"),
            format!("a:0/{good}"),
            format!("a:70000/{good}"),
            format!(":1/{good}"),
            format!("a b:1/{good}"),
            format!("\u{1b}:1/{good}"),
            format!("{}:1/{good}", "a".repeat(300)),
            format!("a:1/{good}0"),
            format!("a:1/{}", &good[1..]),
            format!("a:1/{}", good.replace('A', "U")),
            format!("a:1/{}", good.replace('A', "ä")),
        ] {
            assert!(wrong.parse::<JoinCode>().is_err(), "{wrong}");
        }
    }
}
