//! Identities of several virtual arms that share a profile.

use super::{Identity, MAX_NAME, MAX_SERIAL};

impl Identity {
    /// Returns the identity of arm `number` of several, counted from 1.
    ///
    /// The name ends with the number. The serial number and the seed of the device id count up from
    /// those of the first arm.
    ///
    /// ```
    /// let [_, third] = [1, 3].map(|n| magician_sim::Profile::default().identity.numbered(n));
    /// assert_eq!((&third.name[..], &third.serial[..]), ("Dobot 2.0 #3", "00000003"));
    /// ```
    #[must_use]
    pub fn numbered(&self, number: u32) -> Self {
        let further = number.saturating_sub(1);
        Self {
            version: self.version,
            name: name(&self.name, number),
            serial: serial(&self.serial, number, further),
            device_id_seed: self.device_id_seed.wrapping_add(further.into()),
        }
    }
}

/// Serial number of a virtual arm, derived from its place: the path of a pseudo-terminal or the
/// address of a socket.
///
/// A place yields the same number at each start. Different places yield different numbers, unless
/// their 32-bit hashes collide. Hosts store what they know of an arm under its serial number, so
/// two arms should not share one.
pub(crate) fn serial_at(place: &str) -> String {
    // FNV-1a: short, and the same on every machine and in every version.
    let hash = place.bytes().fold(0x811c_9dc5_u32, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("SIM{hash:08X}")
}

fn name(first: &str, number: u32) -> String {
    let end = format!(" #{number}");
    let mut kept = first.to_owned();
    // Pop whole characters: a cut inside one would not be UTF-8.
    while kept.len() > MAX_NAME - end.len() {
        kept.pop();
    }
    kept + &end
}

/// Counts up the digits at the end of a serial number, or appends the number if it ends without
/// digits.
fn serial(first: &str, number: u32, further: u32) -> String {
    let text = first.trim_end_matches(|digit: char| digit.is_ascii_digit());
    let digits = &first[text.len()..];
    let count = match digits.parse::<u128>() {
        Ok(count) => count.saturating_add(further.into()),
        Err(_) => number.into(),
    };
    let counted = format!("{text}{count:0width$}", width = digits.len());
    // If the count has grown too long, keep its end: the digits that differ.
    let mut ends = counted.char_indices().map(|(at, _)| &counted[at..]);
    let fitting = ends.find(|end| end.len() <= MAX_SERIAL);
    fitting.unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    #[test]
    fn serial_numbers_count_up() {
        for (first, third) in [
            ("00000001", "00000003"),
            ("DT99", "DT101"),
            ("unit", "unit3"),
            ("", "3"),
            ("99999999999999999999999", "00000000000000000000001"),
            ("\u{e4}bcdefghijklmnopqrstuv", "bcdefghijklmnopqrstuv3"),
        ] {
            assert_eq!(serial(first, 3, 2), third);
            assert!(third.len() <= MAX_SERIAL);
        }
    }

    #[test]
    fn serial_number_of_a_place_is_short_stable_and_its_own() {
        assert_eq!(serial_at(""), "SIM811C9DC5");
        assert_eq!(
            serial_at("tcp:127.0.0.1:9000"),
            serial_at("tcp:127.0.0.1:9000")
        );
        let places = (0..2_000).map(|port| serial_at(&format!("tcp:127.0.0.1:{port}")));
        let serials: std::collections::BTreeSet<_> = places.collect();
        assert_eq!(serials.len(), 2_000);
        assert!(serials.iter().all(|serial| serial.len() <= MAX_SERIAL));
    }

    #[test]
    fn a_name_is_cut_before_its_number_is() {
        let long = "\u{e4}".repeat(32);
        let cut = name(&long, 1000);
        assert!(
            cut.ends_with("\u{e4} #1000") && cut.len() <= MAX_NAME,
            "{cut}"
        );
    }

    #[test]
    fn no_two_arms_are_alike() {
        let first = Profile::default().identity;
        let all: Vec<Identity> = (1..=100).map(|n| first.numbered(n)).collect();
        for (at, one) in all.iter().enumerate() {
            for other in &all[at + 1..] {
                assert!(one.name != other.name && one.serial != other.serial);
                assert_ne!(one.device_id_seed, other.device_id_seed);
            }
        }
    }
}
