#![no_main]
//! Flash file of arbitrary bytes: refused, or an arm starts with it, runs its program and writes
//! the same flash again.

use libfuzzer_sys::fuzz_target;
use magician_sim::world::Press;
use magician_sim::{Controller, ExternalEvent, Flash, Profile, World};

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let flash = match Flash::from_toml(text) {
        Ok(flash) => flash,
        Err(error) => {
            assert!(!error.to_string().contains('\n'));
            return;
        }
    };
    let written = flash.to_toml();
    let again = Flash::from_toml(&written).expect("what we have written");
    assert_eq!(again.to_toml(), written);
    let mut arm = Controller::with_flash(Profile::default(), World::default(), flash);
    arm.inject(ExternalEvent::Key(Press::Short));
    for _ in 0..200 {
        let Some(next) = arm.poll_timeout() else {
            break;
        };
        arm.advance(next);
        while arm.poll_event().is_some() {}
    }
});
