//! Ids, in the families that have them.

use magician::commands::DeviceName;
use magician::protocol::Text;
use magician_capi::Family;

use crate::bench::{connect_v2, connect_v3, fault, pose_of, registry};

#[test]
fn ids_are_the_smallest_that_are_free() {
    let registry = registry();
    for id in 0..3 {
        assert_eq!(connect_v2(&registry, "sim").id, id);
    }
    registry.disconnect(1);
    assert_eq!(pose_of(&registry, 1).0, 2);
    assert_eq!(pose_of(&registry, 2).0, 0);
    let said = connect_v2(&registry, "sim");
    assert_eq!(
        (said.code, said.id, said.firmware.as_str()),
        (0, 1, "DobotSerial")
    );
    let failed = connect_v2(&registry, "/dev/tty-of-no-arm");
    assert_eq!((failed.code, failed.id), (2, -1));
}

#[test]
fn each_id_is_a_separate_arm() {
    let registry = registry();
    let name = |id: i32| DeviceName {
        device_name: Text::new(&format!("arm {id}")).unwrap(),
    };
    for id in 0..4 {
        assert_eq!(connect_v2(&registry, "sim").id, id);
        registry
            .find(Family::V2, id)
            .unwrap()
            .set(&name(id))
            .unwrap();
    }
    for id in 0..4 {
        let arm = registry.find(Family::V2, id).unwrap();
        assert_eq!(arm.get::<DeviceName>().unwrap(), name(id));
    }
}

#[test]
fn a_master_is_a_magician_with_its_version() {
    let registry = registry();
    connect_v3(&registry, "sim");
    let (code, info) = connect_v3(&registry, "sim");
    assert_eq!(code, 0);
    let number = |at: usize| i32::from_le_bytes(info[at..at + 4].try_into().unwrap());
    assert_eq!((number(0), number(4)), (1, 2), "id and type");
    let text = |at: usize| {
        let bytes = std::ffi::CStr::from_bytes_until_nul(&info[at..at + 50]).unwrap();
        bytes.to_str().unwrap()
    };
    assert_eq!(text(8), "Dobot");
    let arm = registry.find(Family::V3, 1).unwrap();
    let version = arm.get::<magician::commands::DeviceVersion>().unwrap();
    let version = [
        version.major_version,
        version.minor_version,
        version.revision,
    ];
    assert_eq!(text(58), version.map(|number| number.to_string()).join("."));
    assert!(info[112..].iter().all(|byte| *byte == 0), "no slaves");
}

#[test]
fn unknown_id_is_an_invalid_device_in_v3_only() {
    let registry = registry();
    let code = |family| registry.run(family, "GetPose", 5, |_| Ok(()));
    assert_eq!([Family::V1, Family::V2, Family::V3].map(code), [2, 2, 4]);
    assert!(fault().contains("id 5"), "{}", fault());
    let (code, info) = connect_v3(&registry, "udp:");
    assert_eq!((code, info[0]), (2, crate::bench::UNTOUCHED));
}
