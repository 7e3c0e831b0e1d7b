//! Creation and parsing of certificates.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    KeyUsagePurpose, SerialNumber,
};
use sha2::{Digest, Sha256};
use x509_parser::prelude::{FromDer, GeneralName, X509Certificate};

use super::{CertificateError, is_machine_name};
use crate::keys::is_name;

/// Seconds of a day.
const DAY: i64 = 86_400;
/// Validity of the authority: 20 years. Renewing it would make every machine join again.
const AUTHORITY_DAYS: i64 = 7305;
/// Validity of a machine's certificate, days. Apple's systems refuse longer ones.
const MACHINE_DAYS: i64 = 825;
/// Validity starts this much before creation, seconds: clocks of a classroom differ, in the worst
/// case by a time zone.
const CLOCK_MARGIN: i64 = DAY;

/// Current Unix time, seconds.
pub(super) fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| i64::try_from(now.as_secs()).unwrap_or(i64::MAX))
}

/// Converts Unix seconds to the time type of rcgen. A macro, because a function would have to name
/// that type, and its crate is not a dependency.
macro_rules! time {
    ($unix:expr) => {
        rcgen::date_time_ymd(1970, 1, 1) + Duration::from_secs(u64::try_from($unix).unwrap_or(0))
    };
}

/// Generates a serial number of 126 random bits, so that none occurs twice.
fn serial() -> Result<[u8; 16], CertificateError> {
    let mut serial = [0; 16];
    getrandom::fill(&mut serial).map_err(|_| CertificateError::Random)?;
    // Positive and of full length, so that its DER encoding is exactly these bytes.
    serial[0] = serial[0] & 0x7f | 0x40;
    Ok(serial)
}

/// Parameters for the certificate of an authority.
pub(super) fn authority(site: &str) -> Result<CertificateParams, CertificateError> {
    let now = now();
    let mut params = CertificateParams::default();
    params.distinguished_name = DistinguishedName::new();
    // An organization, which machines do not have: no subject can equal that of its issuer.
    let name = &mut params.distinguished_name;
    name.push(DnType::OrganizationName, "magician site");
    name.push(DnType::CommonName, site);
    params.serial_number = Some(SerialNumber::from_slice(&serial()?));
    params.not_before = time!(now - CLOCK_MARGIN);
    params.not_after = time!(now + AUTHORITY_DAYS * DAY);
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![
        KeyUsagePurpose::KeyCertSign,
        KeyUsagePurpose::CrlSign,
        // The authority uses its own certificate in TLS when machines join.
        KeyUsagePurpose::DigitalSignature,
    ];
    Ok(params)
}

/// Parameters for the certificate of a machine. It ends no later than its authority.
pub(super) fn machine(
    name: &str,
    authority_ends: i64,
) -> Result<CertificateParams, CertificateError> {
    let now = now();
    let mut params = CertificateParams::new(vec![name.to_owned()])?;
    params.distinguished_name = DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, name);
    params.serial_number = Some(SerialNumber::from_slice(&serial()?));
    params.not_before = time!(now - CLOCK_MARGIN);
    params.not_after = time!((now + MACHINE_DAYS * DAY).min(authority_ends));
    params.is_ca = IsCa::ExplicitNoCa;
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    params.extended_key_usages = vec![
        ExtendedKeyUsagePurpose::ServerAuth,
        ExtendedKeyUsagePurpose::ClientAuth,
    ];
    params.use_authority_key_identifier_extension = true;
    Ok(params)
}

/// Parameters for a list of revoked certificates: serial numbers, each with its time of revocation
/// in Unix seconds.
pub(super) fn list(
    number: u64,
    revoked: &[(Vec<u8>, i64)],
) -> rcgen::CertificateRevocationListParams {
    let now = now();
    let entry = |(serial, at): &(Vec<u8>, i64)| rcgen::RevokedCertParams {
        serial_number: SerialNumber::from_slice(serial),
        revocation_time: time!(*at),
        reason_code: None,
        invalidity_date: None,
    };
    rcgen::CertificateRevocationListParams {
        this_update: time!(now),
        // The field is required. Machines ignore it: a list is valid until there is a newer one.
        next_update: time!(now + AUTHORITY_DAYS * DAY),
        crl_number: SerialNumber::from(number),
        issuing_distribution_point: None,
        revoked_certs: revoked.iter().map(entry).collect(),
        key_identifier_method: rcgen::KeyIdMethod::Sha256,
    }
}

/// Contents of a machine's certificate.
#[derive(Clone, Debug)]
pub(super) struct Details {
    pub(super) name: String,
    pub(super) serial: Vec<u8>,
    pub(super) begins: i64,
    pub(super) ends: i64,
    /// SHA-256 of the public key, hexadecimal.
    pub(super) key: String,
}

/// Parses the certificate of a machine. Returns `None` if it is malformed or does not have exactly
/// one machine name.
pub(super) fn read_machine(certificate: &[u8]) -> Option<Details> {
    let (rest, parsed) = X509Certificate::from_der(certificate).ok()?;
    let mut common = parsed.subject().iter_common_name();
    let name = common.next()?.as_str().ok()?;
    let alternative = parsed.subject_alternative_name().ok()??;
    let [GeneralName::DNSName(host)] = alternative.value.general_names[..] else {
        return None;
    };
    let is_machine = rest.is_empty() && common.next().is_none() && host == name;
    (is_machine && is_machine_name(name)).then(|| Details {
        name: name.to_owned(),
        serial: parsed.raw_serial().to_vec(),
        begins: parsed.validity().not_before.timestamp(),
        ends: parsed.validity().not_after.timestamp(),
        key: hex(&Sha256::digest(
            &parsed.public_key().subject_public_key.data,
        )),
    })
}

/// Returns the machine name in a certificate, or `None` if this software would not create such a
/// certificate. Does not check the signature; TLS does.
#[must_use]
pub fn machine_of(certificate: &[u8]) -> Option<String> {
    read_machine(certificate).map(|details| details.name)
}

/// Parses an authority's certificate into the name of its site and the end of validity, Unix
/// seconds. Returns `None` if it is not one.
pub(super) fn read_authority(certificate: &[u8]) -> Option<(String, i64)> {
    let (rest, parsed) = X509Certificate::from_der(certificate).ok()?;
    let site = parsed.subject().iter_common_name().next()?.as_str().ok()?;
    let is_authority = rest.is_empty() && parsed.is_ca() && is_name(site);
    is_authority.then(|| (site.to_owned(), parsed.validity().not_after.timestamp()))
}

/// True if the authority signed the certificate.
pub(super) fn is_signed(certificate: &[u8], authority: &[u8]) -> bool {
    let parsed = X509Certificate::from_der(certificate);
    let (Ok((_, parsed)), Ok((_, authority))) = (parsed, X509Certificate::from_der(authority))
    else {
        return false;
    };
    let issuer = authority.subject().as_raw();
    parsed.issuer().as_raw() == issuer
        && parsed
            .verify_signature(Some(authority.public_key()))
            .is_ok()
}

/// Formats the day of a Unix time, UTC: `2029-03-05`.
#[must_use]
pub fn day_of(unix: i64) -> String {
    (time!(unix)).date().to_string()
}

/// SHA-256 of a certificate, in groups of four hexadecimal digits.
pub(super) fn fingerprint(certificate: &[u8]) -> String {
    let digits = hex(&Sha256::digest(certificate));
    let groups: Vec<_> = { digits.as_bytes().chunks(4) }
        .map(|group| String::from_utf8_lossy(group))
        .collect();
    groups.join(" ")
}

/// Encodes bytes as hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Decodes hexadecimal digits. Returns `None` if the text is malformed.
pub(super) fn unhex(digits: &str) -> Option<Vec<u8>> {
    let pairs = digits.as_bytes().chunks(2);
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    digits
        .len()
        .is_multiple_of(2)
        .then(|| pairs.map(byte).collect())?
}
