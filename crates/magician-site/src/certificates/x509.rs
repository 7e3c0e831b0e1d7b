//! Making and reading certificates.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    KeyUsagePurpose, SerialNumber,
};
use sha2::{Digest, Sha256};
use x509_parser::prelude::{FromDer, GeneralName, X509Certificate};

use super::{CertificateError, is_machine_name};
use crate::keys::is_name;

/// Length of a day, seconds.
const DAY: i64 = 86_400;
/// Validity of the authority: 20 years. It cannot be renewed without every machine joining again.
const AUTHORITY_DAYS: i64 = 7305;
/// Validity of a machine's certificate. Apple's systems refuse longer ones.
const MACHINE_DAYS: i64 = 825;
/// Validity begins this long before the making: clocks of a classroom differ, by a time zone at worst.
const CLOCK_MARGIN: i64 = DAY;

/// Now, Unix seconds.
pub(super) fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| i64::try_from(now.as_secs()).unwrap_or(i64::MAX))
}

/// A time as rcgen takes it.
macro_rules! time {
    ($unix:expr) => {
        rcgen::date_time_ymd(1970, 1, 1) + Duration::from_secs(u64::try_from($unix).unwrap_or(0))
    };
}

/// A serial number of 126 random bits: it never comes again.
fn serial() -> Result<[u8; 16], CertificateError> {
    let mut serial = [0; 16];
    getrandom::fill(&mut serial).map_err(|_| CertificateError::Random)?;
    // Positive and of full length, so that its DER is these bytes.
    serial[0] = serial[0] & 0x7f | 0x40;
    Ok(serial)
}

/// Parameters of the authority of a site.
pub(super) fn authority(site: &str) -> Result<CertificateParams, CertificateError> {
    let now = now();
    let mut params = CertificateParams::default();
    params.distinguished_name = DistinguishedName::new();
    // Apart from the names of machines, so that no machine has the name of its issuer.
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
        // It shows itself to machines that join.
        KeyUsagePurpose::DigitalSignature,
    ];
    Ok(params)
}

/// Parameters of a machine's certificate, which ends no later than its authority.
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

/// Parameters of a list of revoked certificates: serial numbers, each with the time it was revoked.
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
        // The field is required. A list holds until there is a newer one, so no machine looks at it.
        next_update: time!(now + AUTHORITY_DAYS * DAY),
        crl_number: SerialNumber::from(number),
        issuing_distribution_point: None,
        revoked_certs: revoked.iter().map(entry).collect(),
        key_identifier_method: rcgen::KeyIdMethod::Sha256,
    }
}

/// What a machine's certificate says.
#[derive(Clone, Debug)]
pub(super) struct Details {
    pub(super) name: String,
    pub(super) serial: Vec<u8>,
    pub(super) begins: i64,
    pub(super) ends: i64,
    /// SHA-256 of the public key, in hexadecimal digits.
    pub(super) key: String,
}

/// Reads a machine's certificate. `None` if it is none: no certificate, or not with one machine's name.
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

/// The machine's name in a certificate. `None` if it is not of a form that this software makes. The
/// signature is not checked: TLS does that.
#[must_use]
pub fn machine_of(certificate: &[u8]) -> Option<String> {
    read_machine(certificate).map(|details| details.name)
}

/// Site and end of an authority's certificate, Unix seconds. `None` if it is none.
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

/// The day of a time in Unix seconds, UTC: `2029-03-05`.
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

/// Hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Bytes of hexadecimal digits.
pub(super) fn unhex(digits: &str) -> Option<Vec<u8>> {
    let pairs = digits.as_bytes().chunks(2);
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    digits
        .len()
        .is_multiple_of(2)
        .then(|| pairs.map(byte).collect())?
}
