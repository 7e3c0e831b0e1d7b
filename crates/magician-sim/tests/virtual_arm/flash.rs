//! Contents of the flash, and their text form (model sections 6 and 12).

use super::arm::{TestArm, arm, arm_with, ptp, running_arm, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Flag, Layout, PoCmd, PoList, PtpMode, Text};
use magician_sim::world::Press;
use magician_sim::{Controller, ExternalEvent, Flash, Profile, World};

fn text(of: &str) -> Text {
    Text::new(of).unwrap()
}

/// Sets every stored value.
fn fill(bench: &mut TestArm) {
    let device_name = text("Ada \"=\n\u{e4}");
    bench.set(&DeviceName { device_name });
    let device_sn = text("X-17");
    bench.set(&DeviceSn { device_sn });
    bench.set(&WifiSsid { ssid: text("lab") });
    let password = text("\\secret\u{7f}");
    bench.set(&WifiPassword { password });
    bench.set(&WifiIpAddress {
        dhcp: Flag(1),
        addr: [10, 0, 0, 7],
    });
    let addr = [255, 255, 0, 0];
    bench.set(&WifiNetmask { addr });
    let addr = [10, 0, 0, 1];
    bench.set(&WifiGateway { addr });
    let addr = [9, 9, 9, 9];
    bench.set(&WifiDns { addr });
    bench.set(&AngleSensorStaticError {
        rear_arm_angle_error: 0.1,
        front_arm_angle_error: -f32::MIN_POSITIVE,
    });
    bench.set(&AngleSensorCoef {
        rear_arm_angle_coef: 1e30,
        front_arm_angle_coef: f32::NEG_INFINITY,
    });
    bench.set(&BaseDecoderStaticError {
        base_decoder_error: -0.0,
    });
    bench.set(&QueuedCmdStartDownload {
        total_loop: 2,
        line_per_loop: 3,
    });
    bench.enqueue(&ptp(6, [10.0, 0.0, 0.0, 0.0]));
    bench.enqueue(&PtpPoCmd {
        ptp_mode: PtpMode::MovjAngleInc,
        x: 0.1,
        y: 0.0,
        z: 0.0,
        r: f32::MAX,
        po: PoList::new(&[PoCmd {
            ratio: 50,
            address: 17,
            level: 1,
        }])
        .unwrap(),
    });
    bench.enqueue(&wait(500));
    bench.set(&QueuedCmdStopDownload {});
}

/// Reads all stored values; returns the parameters of the replies.
fn kept(bench: &mut TestArm) -> Vec<Vec<u8>> {
    [0u8, 1, 140, 141, 142, 151, 152, 153, 154, 155, 156]
        .into_iter()
        .map(|id| bench.frame(id, Ctrl::GET, &[]).frame().params().to_vec())
        .collect()
}

#[test]
fn what_is_kept_comes_back_with_the_power_and_nothing_else_does() {
    let mut bench = arm();
    fill(&mut bench);
    bench.full_speed();
    bench.set(&WifiConfigMode { enable: Flag::ON });
    let before = kept(&mut bench);
    let flash = bench.arm.flash().clone();
    let mut again = TestArm {
        arm: Controller::with_flash(Profile::continuous(), World::default(), flash.clone()),
    };
    assert_eq!(kept(&mut again), before);
    assert_eq!(again.arm.flash(), &flash);
    assert_eq!(again.arm.flash_writes(), 0);
    assert_eq!(again.get::<PtpCommonParams>().velocity_ratio, 50.0);
    assert!(!again.get::<WifiConfigMode>().enable.is_on());
    assert_ne!(kept(&mut arm()), before, "a new arm knows none of it");
}

#[test]
fn it_outlives_a_reset() {
    let mut bench = running_arm();
    fill(&mut bench);
    let (before, writes) = (kept(&mut bench), bench.arm.flash_writes());
    bench.full_speed();
    bench.arm.inject(ExternalEvent::Reset);
    assert_eq!(kept(&mut bench), before);
    assert_eq!(bench.arm.flash_writes(), writes);
    assert_eq!(bench.get::<PtpCommonParams>().velocity_ratio, 50.0);
    bench.set(&ClearAlarmsState {});
    bench.arm.press(Press::Short);
    bench.pass(700_000);
    assert_eq!(bench.joints()[0], 10.0);
}

#[test]
fn a_new_flash_is_the_profiles() {
    let mut bench = arm_with(|profile| profile.identity.name = "Grace".into());
    assert_eq!(bench.get::<DeviceName>().device_name, text("Grace"));
    assert_eq!(bench.arm.flash(), &Flash::new(bench_profile("Grace")));
}

fn bench_profile(name: &str) -> &'static Profile {
    let mut profile = Profile::continuous();
    profile.identity.name = name.into();
    Box::leak(Box::new(profile))
}

#[test]
fn writes_count_what_is_kept_alone() {
    let mut bench = arm();
    assert_eq!(bench.arm.flash_writes(), 0);
    bench.full_speed();
    kept(&mut bench);
    bench.enqueue(&wait(1));
    assert_eq!(bench.arm.flash_writes(), 0);
    fill(&mut bench);
    assert_eq!(bench.arm.flash_writes(), 12);
}

#[test]
fn text_reads_back_bit_for_bit() {
    let mut bench = arm();
    fill(&mut bench);
    let toml = bench.arm.flash().to_toml();
    let read = Flash::from_toml(&toml).unwrap();
    assert_eq!(&read, bench.arm.flash());
    assert_eq!(read.to_toml(), toml);
    assert!(toml.contains("AA AA 06 6E 03 F4 01 00 00 9A"), "{toml}");

    // Latin-1, as some hosts send it.
    let name = DeviceName::decode(b"\xC4da\0").unwrap();
    bench.set(&name);
    let read = Flash::from_toml(&bench.arm.flash().to_toml()).unwrap();
    assert_eq!(&read, bench.arm.flash());
}

#[test]
fn text_that_is_no_flash_says_why() {
    let mut bench = arm();
    fill(&mut bench);
    let good = bench.arm.flash().to_toml();
    for (from, to, says) in [
        ("version = 1", "version = 2", "version is 2"),
        ("version = 1", "", "version"),
        ("[wifi]", "[wlan]", "wlan"),
        ("dhcp = 1", "dhcp = 300", "dhcp"),
        ("\"X-17\"", "\"123456789012345678901234\"", "serial"),
        ("\"X-17\"", "[1, 0]", "serial"),
        ("AA AA 06 6E 03 F4", "AA AA 06 6E 03 F5", "line 3"),
        ("AA AA 06 6E 03 F4", "nonsense", "line 3"),
        ("loops = 2", "loops = -2", "loops"),
        ("[program]", "[program", "unclosed table"),
    ] {
        assert!(good.contains(from), "{from} in {good}");
        let error = Flash::from_toml(&good.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(says), "{from}: {error}");
    }
    for cut in (0..good.len()).filter(|at| good.is_char_boundary(*at)) {
        let _ = Flash::from_toml(&good[..cut]);
    }
}
