//! Which characteristic is written to, and which one notifies.

use std::collections::BTreeSet;

use btleplug::api::{CharPropFlags, Characteristic, Service};

use crate::{Error, ErrorKind, Result};

/// The service of the document's Table 1, and what it calls the ports for reading and for writing.
pub(super) const SERVICE: u128 = 0x0003_CDD0_0000_1000_8000_0080_5F9B_0131;
const READ: u128 = 0x0003_CDD1_0000_1000_8000_0080_5F9B_0131;
const WRITE: u128 = 0x0003_CDD2_0000_1000_8000_0080_5F9B_0131;

const WRITABLE: CharPropFlags = CharPropFlags::WRITE.union(CharPropFlags::WRITE_WITHOUT_RESPONSE);
const NOTIFIES: CharPropFlags = CharPropFlags::NOTIFY.union(CharPropFlags::INDICATE);

/// Who writes and who notifies, in the order of preference among what the properties allow: as the document has it
/// from the host's side, the other way round, one for both.
const WAYS: [(u128, u128); 4] = [(WRITE, READ), (READ, WRITE), (WRITE, WRITE), (READ, READ)];

/// The characteristic to write to and the one that notifies.
pub(super) fn settle(
    wanted: &str,
    services: &BTreeSet<Service>,
) -> Result<(Characteristic, Characteristic)> {
    let wrong = |what| Error::new(ErrorKind::Unexpected, format!("ble:{wanted} {what}"));
    let service = services.iter().find(|one| one.uuid.as_u128() == SERVICE);
    let Some(service) = service else {
        let found = list(services.iter().map(|service| service.uuid.to_string()));
        return Err(wrong(format!(
            "is no Magician: it has no service 0003cdd0-0000-1000-8000-00805f9b0131, but {found}"
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
        format!("{} ({})", one.uuid, properties.join(" ").to_lowercase())
    }));
    Err(wrong(format!(
        "cannot be talked to: of its characteristics 0003cdd1 and 0003cdd2 one has to take writes and one to notify, and \
         there is {found}"
    )))
}

fn list(all: impl Iterator<Item = String>) -> String {
    let all: Vec<_> = all.collect();
    match all.as_slice() {
        [] => "nothing".to_owned(),
        all => all.join(", "),
    }
}
