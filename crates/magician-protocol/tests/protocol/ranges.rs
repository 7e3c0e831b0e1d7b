//! Values of fields against the ranges of the command table.

use magician_protocol::commands::{
    ClearAlarmsState, CpCmd, CpLeCmd, DeviceSn, IoPwm, JogCommonParams, JogJointParams,
    LostStepParams, PtpCmd, PtpCommonParams, PtpPoCmd, PtpPoWithLCmd, PtpWithLCmd, SetDeviceWithL,
    SetEndEffectorLaser, TrigCmd,
};
use magician_protocol::{
    CpMode, FieldType, Flag, Number, PoCmd, PoList, PtpMode, RailVersion, Range, Set, TABLE, Text,
    TriggerCondition, TriggerMode,
};

fn trigger(mode: u8, condition: u8, threshold: u16) -> Set {
    Set::TrigCmd(TrigCmd {
        address: 4,
        mode: TriggerMode::from(mode),
        condition: TriggerCondition::from(condition),
        threshold,
    })
}

fn ratio(velocity_ratio: f32) -> Set {
    Set::from(PtpCommonParams {
        velocity_ratio,
        acceleration_ratio: 50.0,
    })
}

fn pulses(address: u8, frequency: f32, duty_cycle: f32) -> Set {
    Set::from(IoPwm {
        address,
        frequency,
        duty_cycle,
    })
}

fn serial(length: usize) -> Set {
    let device_sn = Text::new(&"A".repeat(length)).unwrap();
    Set::from(DeviceSn { device_sn })
}

fn joints(velocity: [f32; 4]) -> Set {
    Set::from(JogJointParams {
        velocity,
        acceleration: [1.0; 4],
    })
}

fn burn(cp_mode: u8, x: f32, velocity_or_power: f32) -> Set {
    Set::from(CpLeCmd {
        cp_mode: CpMode::from(cp_mode),
        x,
        y: 0.0,
        z: 0.0,
        velocity_or_power,
    })
}

fn outputs(outputs: &[PoCmd]) -> Set {
    Set::from(PtpPoCmd {
        ptp_mode: PtpMode::MovlXyz,
        x: 200.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        po: PoList::new(outputs).unwrap(),
    })
}

fn rail(ptp_mode: u8, l: f32) -> Set {
    Set::from(PtpWithLCmd {
        ptp_mode: ptp_mode.into(),
        x: 200.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        l,
    })
}

const OUTPUT: PoCmd = PoCmd {
    ratio: 50,
    address: 4,
    level: 1,
};

#[test]
fn value_out_of_range_is_named_with_the_range_that_applies() {
    let power = PoCmd {
        ratio: 101,
        ..OUTPUT
    };
    let pin = PoCmd {
        address: 21,
        ..OUTPUT
    };
    let level = PoCmd { level: 2, ..OUTPUT };
    for (command, sentence) in [
        (
            ratio(0.001),
            "velocity_ratio 0.001 % is below the minimum of 1 %",
        ),
        (
            ratio(f32::NAN),
            "velocity_ratio is NaN, not a finite number",
        ),
        (
            trigger(1, 0, 60_000),
            "threshold 60000 is out of range: 0 to 4095 counts in analog mode",
        ),
        (
            trigger(0, 0, 2),
            "threshold 2 is out of range: 0 or 1 in level mode",
        ),
        (
            trigger(0, 2, 0),
            "condition 2 is out of range: 0 or 1 in level mode",
        ),
        (
            trigger(1, 4, 0),
            "condition 4 is out of range: 0 to 3 in analog mode",
        ),
        (trigger(2, 4, 9), "mode 2 is out of range: 0 or 1"),
        (pulses(21, 50.0, 1.0), "address 21 is out of range: 1 to 20"),
        (
            pulses(4, 9.5, 1.0),
            "frequency 9.5 Hz is out of range: 10 to 1000000 Hz",
        ),
        (
            pulses(4, 50.0, 100.01),
            "duty_cycle 100.01 % is out of range: 0 to 100 %",
        ),
        (serial(24), "device_sn has 24 bytes, limit 23"),
        (
            joints([1.0, 1.0, -0.1, 1.0]),
            "velocity[2] -0.1 deg/s must be above 0 deg/s",
        ),
        (
            joints([1.0, f32::INFINITY, 1.0, 1.0]),
            "velocity[1] is inf, not a finite number",
        ),
        (
            Set::from(LostStepParams { value: 0.0 }),
            "value 0 deg must be above 0 deg",
        ),
        (burn(7, 0.0, 200.0), "cp_mode 7 is out of range: 0 or 1"),
        (
            outputs(&[OUTPUT, power]),
            "po[1].ratio 101 % is out of range: 0 to 100 %",
        ),
        (outputs(&[pin]), "po[0].address 21 is out of range: 1 to 20"),
        (
            outputs(&[OUTPUT, OUTPUT, level]),
            "po[2].level 2 is out of range: 0 or 1",
        ),
        (
            Set::from(SetDeviceWithL {
                with_l: Flag::ON,
                version: Some(RailVersion::from(5)),
            }),
            "version 5 is out of range: 0 or 1",
        ),
    ] {
        let error = command.check().unwrap_err();
        assert_eq!(error.to_string(), sentence, "{command:?}");
    }
}

#[test]
fn ends_of_a_range_are_within_it() {
    for (command, in_range) in [
        (ratio(0.99), false),
        (ratio(1.0), true),
        (ratio(100.0), true),
        (ratio(500.0), true),
        (trigger(0, 0, 0), true),
        (trigger(0, 1, 1), true),
        (trigger(0, 3, 0), false),
        (trigger(1, 3, 4095), true),
        (trigger(1, 3, 4096), false),
        (pulses(1, 10.0, 0.0), true),
        (pulses(20, 1e6, 100.0), true),
        (pulses(0, 10.0, 0.0), false),
        (pulses(4, 1_000_001.0, 0.0), false),
        (pulses(4, 10.0, -1e-45), false),
        (serial(23), true),
        (joints([f32::MIN_POSITIVE; 4]), true),
        (joints([0.0; 4]), false),
        (burn(1, 1e30, 100.0), true),
        (burn(1, f32::NAN, 100.0), false),
        (outputs(&[OUTPUT; 57]), true),
        // The rail's range depends on the mode: the planner checks it.
        (rail(1, 2000.0), true),
        (rail(1, f32::NAN), false),
        // A flag is on for any byte but 0.
        (
            Set::from(SetEndEffectorLaser {
                enable_ctrl: Flag(7),
                on: Flag(255),
            }),
            true,
        ),
        (Set::from(ClearAlarmsState {}), true),
    ] {
        assert_eq!(command.check().is_ok(), in_range, "{command:?}");
    }
    let jogs = |velocity_ratio, acceleration_ratio| {
        Set::from(JogCommonParams {
            velocity_ratio,
            acceleration_ratio,
        })
    };
    assert_eq!(jogs(0.5, 1.0).check().unwrap_err().field, "velocity_ratio");
    assert_eq!(
        jogs(1.0, 0.5).check().unwrap_err().field,
        "acceleration_ratio"
    );
}

/// The list does not fit the frame either, but the range is checked first.
#[test]
fn overlong_list_error_states_length_and_limit() {
    let command = Set::from(PtpPoWithLCmd {
        ptp_mode: PtpMode::MovlXyz,
        x: 200.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        l: 0.0,
        po: PoList::new(&[OUTPUT; 57]).unwrap(),
    });
    let error = command.check().unwrap_err();
    assert_eq!(error.to_string(), "po has 57 outputs, limit 56");
    assert_eq!(
        (error.value, error.limit(), error.unit),
        (Number::Integer(57), Some(56), "outputs")
    );
}

#[test]
fn error_has_value_limit_and_unit() {
    let error = trigger(1, 0, 60_000).check().unwrap_err();
    assert_eq!(
        (error.value, error.limit(), error.unit),
        (Number::Integer(60_000), Some(4095), "level or counts")
    );
    let error = pulses(4, 10.0, -0.25).check().unwrap_err();
    assert_eq!(
        (error.value, error.limit(), error.range),
        (Number::Float(-0.25), Some(0), Range::Within(0, 100))
    );
    assert_eq!(ratio(f32::INFINITY).check().unwrap_err().limit(), None);
}

#[test]
fn only_wanted_fields_are_checked() {
    let command = burn(7, f32::NAN, 101.0);
    let error = command.check_fields(|field| field.unit == "percent");
    assert_eq!(error.unwrap_err().field, "velocity_or_power");
    assert_eq!(command.check_fields(|_| false), Ok(()));
    let segment = CpCmd {
        cp_mode: CpMode::Absolute,
        x: 0.0,
        y: 0.0,
        z: 0.0,
        velocity_or_power: f32::NAN,
    };
    let error = Set::from(segment).check().unwrap_err();
    assert_eq!(error.field, "velocity_or_power");
    let at = PtpCmd {
        ptp_mode: PtpMode::from(10),
        x: 0.0,
        y: 0.0,
        z: 0.0,
        r: f32::NAN,
    };
    assert_eq!(Set::from(at).check().unwrap_err().field, "ptp_mode");
}

/// A value of an enum field is therefore out of range exactly if it has no name.
#[test]
fn enum_range_spans_its_named_values() {
    let layouts = TABLE.iter().flat_map(|row| [row.query, row.value, row.set]);
    let fields = layouts.flatten().flat_map(|layout| layout.fields);
    let mut seen = 0;
    for field in fields {
        let FieldType::Enum(info) = field.ty else {
            continue;
        };
        let values = || info.variants.iter().map(|variant| i32::from(variant.value));
        let bounds = field.range.bounds();
        assert_eq!(bounds.minimum, values().min(), "{field:?}");
        assert_eq!(bounds.maximum, values().max(), "{field:?}");
        assert_eq!(values().count() as i32, bounds.maximum.unwrap() + 1);
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}
