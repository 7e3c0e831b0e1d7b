//! Waits, pins, and what is plugged in beside the arm.

use std::time::Duration;

use magician_protocol::commands::{
    EMotor, EMotorS, IoDo, IoMultiplexing, IoPwm, SetColorSensor, SetDeviceWithL, SetIrSwitch,
    TrigCmd, WaitCmd,
};
use magician_protocol::{
    Flag, IoFunction, Port, RailVersion, SensorVersion, Set, Stepper, TriggerCondition, TriggerMode,
};

/// Makes the queue wait, to the millisecond and for at most 49 days.
#[must_use]
pub fn wait(time: Duration) -> Set {
    let timeout = u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
    WaitCmd { timeout }.into()
}

/// Makes the queue wait until a digital input has this level, for ever if need be.
#[must_use]
pub fn wait_for_level(address: u8, level: bool) -> Set {
    TrigCmd {
        address,
        mode: TriggerMode::Level,
        condition: TriggerCondition::EqualOrBelow,
        threshold: level.into(),
    }
    .into()
}

/// Makes the queue wait until an analog input (0 to 4095) compares so, for ever if need be.
#[must_use]
pub fn wait_for_analog(address: u8, condition: TriggerCondition, threshold: u16) -> Set {
    let mode = TriggerMode::Analog;
    TrigCmd {
        address,
        mode,
        condition,
        threshold,
    }
    .into()
}

/// Says what an EIO pin (1 to 20) does; a pin must be told before it is used.
#[must_use]
pub fn multiplex(address: u8, function: IoFunction) -> Set {
    IoMultiplexing {
        address,
        multiplex: function,
    }
    .into()
}

/// Sets the level of a digital output.
#[must_use]
pub fn output(address: u8, high: bool) -> Set {
    IoDo {
        address,
        level: high.into(),
    }
    .into()
}

/// Sets a pulse-width output: Hz (10 to 1000000), and percent of the time that it is high.
#[must_use]
pub fn pwm(address: u8, frequency: f32, duty_cycle: f32) -> Set {
    IoPwm {
        address,
        frequency,
        duty_cycle,
    }
    .into()
}

/// Runs an external motor at so many pulses a second; 0 stops it. The sign is the direction.
#[must_use]
pub fn motor(index: Stepper, speed: i32) -> Set {
    EMotor {
        index,
        is_enabled: (speed != 0).into(),
        speed,
    }
    .into()
}

/// Runs an external motor so many pulses far.
#[must_use]
pub fn motor_by(index: Stepper, speed: i32, distance: u32) -> Set {
    EMotorS {
        index,
        is_enabled: Flag::ON,
        speed,
        distance,
    }
    .into()
}

/// Switches the colour sensor on a port.
#[must_use]
pub fn color_sensor(port: Port, on: bool, version: SensorVersion) -> Set {
    SetColorSensor {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Switches the infrared sensor on a port.
#[must_use]
pub fn infrared(port: Port, on: bool, version: SensorVersion) -> Set {
    SetIrSwitch {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Says whether the arm stands on a rail.
#[must_use]
pub fn rail(on: bool, version: RailVersion) -> Set {
    SetDeviceWithL {
        with_l: on.into(),
        version: Some(version),
    }
    .into()
}
