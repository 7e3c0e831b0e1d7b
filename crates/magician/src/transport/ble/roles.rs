//! Selection of the characteristics for writes and for notifications.

use std::collections::BTreeSet;

use btleplug::api::{CharPropFlags, Characteristic, Service};

use crate::{Error, ErrorCode, Message, Result, message};

/// Service of the document's Table 1, and its characteristics for reading and for writing.
pub(super) const SERVICE: u128 = 0x0003_CDD0_0000_1000_8000_0080_5F9B_0131;
const READ: u128 = 0x0003_CDD1_0000_1000_8000_0080_5F9B_0131;
const WRITE: u128 = 0x0003_CDD2_0000_1000_8000_0080_5F9B_0131;

const WRITABLE: CharPropFlags = CharPropFlags::WRITE.union(CharPropFlags::WRITE_WITHOUT_RESPONSE);
const NOTIFIES: CharPropFlags = CharPropFlags::NOTIFY.union(CharPropFlags::INDICATE);

/// Pairs of characteristics for writes and notifications, in order of preference among the pairs
/// that the properties allow: as in the document from the host's view, swapped, one for both.
const WAYS: [(u128, u128); 4] = [(WRITE, READ), (READ, WRITE), (WRITE, WRITE), (READ, READ)];

/// Returns the characteristic for writes and the one for notifications.
pub(super) fn settle(
    wanted: &str,
    services: &BTreeSet<Service>,
) -> Result<(Characteristic, Characteristic)> {
    let wrong = |message: Message| Error::new(ErrorCode::NotAnArm, message);
    let service = services.iter().find(|one| one.uuid.as_u128() == SERVICE);
    let Some(service) = service else {
        let found = list(services.iter().map(|service| service.uuid.to_string()));
        return Err(wrong(message!(
            "ble:{wanted} is not a Magician: it has no service \
                0003cdd0-0000-1000-8000-00805f9b0131; its services: {found}",
            wanted,
            found
        )));
    };
    let named = |uuid, able: CharPropFlags| {
        let mut all = service.characteristics.iter();
        all.find(|one| one.uuid.as_u128() == uuid && one.properties.intersects(able))
    };
    let mut ways = WAYS.iter().filter_map(|&(writes, notifies)| {
        Some((named(writes, WRITABLE)?, named(notifies, NOTIFIES)?))
    });
    if let Some((writes, notifies)) = ways.next() {
        return Ok((writes.clone(), notifies.clone()));
    }
    let found = list((service.characteristics.iter()).map(|one| {
        let properties = one.properties.iter_names().map(|(name, _)| name);
        let properties: Vec<_> = properties.collect();
        let properties = properties.join(" ").to_lowercase().replace('_', "-");
        format!("{} ({properties})", one.uuid)
    }));
    Err(wrong(message!(
        "ble:{wanted} cannot be used: of its characteristics 0003cdd1 and 0003cdd2 one must accept \
            writes and one must notify, and it has {found}",
        wanted,
        found
    )))
}

fn list(all: impl Iterator<Item = String>) -> Message {
    let all: Vec<_> = all.collect();
    match all.as_slice() {
        [] => message!("nothing"),
        all => all.join(", ").into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    const FAST: CharPropFlags = CharPropFlags::WRITE_WITHOUT_RESPONSE;
    const NOTIFY: CharPropFlags = CharPropFlags::NOTIFY;
    const BOTH: CharPropFlags = CharPropFlags::WRITE.union(CharPropFlags::INDICATE);

    /// Builds a service with characteristics named by the last digit of their number.
    fn offering(all: &[(u8, CharPropFlags)]) -> BTreeSet<Service> {
        let named = |digit| format!("0003cdd{digit}-0000-1000-8000-00805f9b0131");
        let characteristics = all.iter().map(|&(digit, properties)| Characteristic {
            uuid: named(digit).parse().unwrap(),
            service_uuid: named(0).parse().unwrap(),
            properties,
            descriptors: BTreeSet::new(),
        });
        let service = Service {
            uuid: named(0).parse().unwrap(),
            primary: true,
            characteristics: characteristics.collect(),
        };
        BTreeSet::from([service])
    }

    #[test]
    fn properties_decide_and_the_document_where_they_do_not() {
        for (offered, writes, notifies) in [
            (&[(1, NOTIFY), (2, FAST)][..], WRITE, READ),
            (&[(1, FAST), (2, NOTIFY)], READ, WRITE),
            (&[(1, BOTH), (2, BOTH)], WRITE, READ),
            (&[(1, BOTH), (2, NOTIFY)], READ, WRITE),
            (&[(1, BOTH)], READ, READ),
            (&[(2, BOTH), (3, BOTH)], WRITE, WRITE),
        ] {
            let settled = settle("arm", &offering(offered)).unwrap();
            let settled = (settled.0.uuid.as_u128(), settled.1.uuid.as_u128());
            assert_eq!(settled, (writes, notifies), "{offered:?}");
        }
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        for offered in [&[][..], &[(1, NOTIFY)], &[(2, FAST)], &[(3, BOTH)]] {
            let error = settle("arm", &offering(offered)).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Unexpected, "{offered:?}");
        }
        let read_only = [(1, NOTIFY), (2, CharPropFlags::READ)];
        let message = settle("arm", &offering(&read_only)).unwrap_err();
        let message = message.to_string();
        let found = "0003cdd2-0000-1000-8000-00805f9b0131 (read)";
        assert!(message.contains(found), "{message}");
        let foreign = settle("watch", &BTreeSet::new()).unwrap_err();
        assert!(foreign.to_string().contains("not a Magician"), "{foreign}");
    }
}
