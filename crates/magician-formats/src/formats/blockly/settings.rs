//! Setting and switching blocks of the robot: speeds, tools, pins, motors, sensors.

use magician_host::{build, message};
use magician_motion::ToolBias;
use magician_protocol::commands::{LostStepParams, PtpCoordinateParams, SetDeviceWithL};
use magician_protocol::{Flag, IoFunction, Port, RailVersion, SensorVersion, Set, Stepper};

use super::refused;
use super::robot::Call;
use crate::{Action, Diagnostic, Grip, Tool};

/// Pulses per mm of belt in the studio. In fact the belt moves about 1.9 mm (model section 13).
const STUDIO_PULSES_PER_MM: f64 = 32_000.0 / (36.0 * std::f64::consts::PI);
/// Fastest rate of a motor, pulses/s. Beyond it the arm misreads the number (errata E41).
const MAX_PULSE_RATE: f64 = 1e6;

impl Call<'_, '_> {
    /// Executes a block that does not move the arm.
    pub(super) fn setting(&mut self) -> Result<(), Diagnostic> {
        let action = match self.block.kind.as_str() {
            "dobot_selectendtype" => return self.select_tool(),
            "dobot_SetEndEffectorParams" => {
                let [x, y, z] = self.place(0.0)?;
                return self.fit_tool(ToolBias::new(x, y, z));
            }
            "dobot_setjumpheight" => {
                build::jump_height(self.single(&["height"], 20.0)?, 100.0).into()
            }
            "dobot_setlinearspeed" => {
                let [velocity, acceleration] = self.rates()?;
                build::speed(velocity, acceleration).into()
            }
            "dobot_setptpjointparams" => {
                let [velocity, acceleration] = self.rates()?;
                build::joint_speed([velocity; 4], [acceleration; 4]).into()
            }
            // The studio misspells this block type.
            "dobot_setptpoordinateparams" | "dobot_setptpcoordinateparams" => {
                let [velocity, acceleration] = self.rates()?;
                let params = PtpCoordinateParams {
                    xyz_velocity: velocity,
                    r_velocity: velocity,
                    xyz_acceleration: acceleration,
                    r_acceleration: acceleration,
                };
                Set::from(params).into()
            }
            "dobot_setptplparams" => {
                let [velocity, acceleration] = self.rates()?;
                build::rail_speed(velocity, acceleration).into()
            }
            "dobot_pump" => Action::Suction(self.choice("io", 0..=1)? == 1),
            "dobot_gripper" => Action::Gripper(match self.choice("io", 0..=2)? {
                0 => Grip::Off,
                1 => Grip::Close,
                _ => Grip::Open,
            }),
            "dobot_laser" => return self.laser(),
            _ => return self.beside(),
        };
        self.push(action);
        Ok(())
    }

    fn rates(&mut self) -> Result<[f32; 2], Diagnostic> {
        let velocity = self.single(&["Velocity", "lVelocity"], 20.0)?;
        let acceleration = self.single(&["Acceleration", "lAcceleration"], 50.0)?;
        Ok([velocity, acceleration])
    }

    /// Selects a tool. The block identifies it by its length; the gripper is as long as the suction
    /// cup and has an additional digit.
    fn select_tool(&mut self) -> Result<(), Diagnostic> {
        let out = self.number(&["type"], 59.7)?;
        let tools = [
            (59.7, Tool::Suction),
            (59.701, Tool::Gripper),
            (61.0, Tool::Pen),
            (70.0, Tool::Laser),
        ];
        let Some((_, tool)) = tools.into_iter().find(|(own, _)| *own == out) else {
            let message = message!(
                "unknown end effector type {out}; known are 59.7, 59.701, 61 and 70",
                out
            );
            return Err(self.block.diagnostic(message));
        };
        if self.machine.plan.steps.is_empty() {
            self.machine.plan.tool = Some(tool);
        }
        self.fit_tool(tool.bias())
    }

    fn fit_tool(&mut self, bias: ToolBias) -> Result<(), Diagnostic> {
        self.machine.course.fit(bias);
        self.push(build::tool(bias));
        Ok(())
    }

    fn laser(&mut self) -> Result<(), Diagnostic> {
        let on = self.choice("enable", 0..=1)? == 1;
        if on {
            let power = self.number(&["power"], 50.0)?;
            if power <= 0.0 {
                self.push(Action::Laser(false));
                return Ok(());
            }
            let what = message!("the laser is only switched on or off: its power is left out");
            self.note("power", what);
        }
        self.push(Action::Laser(on));
        Ok(())
    }

    /// Executes blocks for pins, motors, sensors and the rail.
    fn beside(&mut self) -> Result<(), Diagnostic> {
        let action: Action = match self.block.kind.as_str() {
            "dobot_setiomultiplexing" => {
                let function = match self.choice("value", 1..=7)? {
                    1 => IoFunction::DigitalInput,
                    3 => IoFunction::AnalogInput,
                    4..=6 => IoFunction::DigitalOutput,
                    7 => IoFunction::Pwm,
                    other => {
                        let message = message!("unknown pin function {function}", function = other);
                        return Err(self.block.diagnostic(message));
                    }
                };
                build::multiplex(self.choice("io", 1..=20)?, function).into()
            }
            "dobot_set_output" => {
                let pin = self.choice("io", 1..=20)?;
                build::output(pin, self.choice("value", 0..=1)? == 1).into()
            }
            "dobot_set_output5V" | "dobot_set_output12V" => {
                let pin = self.choice("io", 1..=20)?;
                build::output(pin, self.choice("enable", 0..=1)? == 1).into()
            }
            "dobot_setiopwm" => {
                let pin = self.choice("io", 1..=20)?;
                let frequency = self.single(&["frequency"], 1.0)?;
                build::pwm(pin, frequency, self.single(&["dutyCycle"], 40.0)?).into()
            }
            "dobot_conveyor" | "dobot_setemotor" | "dobot_setemotors" => self.motor()?.into(),
            "dobot_set_colorseneor" | "dobot_SetInfraredSensor" => self.sensor()?.into(),
            "dobot_linearRail" => Set::from(SetDeviceWithL {
                with_l: Flag::from(self.choice("enable", 0..=1)? == 1),
                version: Some(match self.choice("version", 0..=1)? {
                    0 => RailVersion::V1,
                    _ => RailVersion::V2,
                }),
            })
            .into(),
            "dobot_SetLostStepCmd" => build::check_lost_steps().into(),
            "dobot_SetLostStepParams" => return self.lost_steps(),
            _ => return Err(refused::diagnostic(self.block)),
        };
        self.push(action);
        Ok(())
    }

    fn motor(&mut self) -> Result<Set, Diagnostic> {
        let stepper = match self.choice("io", 0..=1)? {
            0 => Stepper::Stepper1,
            _ => Stepper::Stepper2,
        };
        let belt = self.block.kind == "dobot_conveyor";
        let pulses = if belt {
            let what = message!(
                "the belt runs about 1.9 times as fast as the block says, as in DobotStudio"
            );
            self.note("belt", what);
            self.number(&["speed"], 50.0)? * STUDIO_PULSES_PER_MM
        } else {
            self.number(&["speed"], 10_000.0)?
        };
        if pulses.abs() > MAX_PULSE_RATE {
            let message = message!(
                "a motor would run at {pulses} pulses/s, limit {limit} pulses/s",
                pulses,
                limit = MAX_PULSE_RATE
            );
            return Err(self.block.diagnostic(message));
        }
        let rate = pulses.trunc() as i32;
        if self.block.kind != "dobot_setemotors" {
            return Ok(build::motor(stepper, rate));
        }
        let distance = self.number(&["distance"], 10_000.0)?;
        if distance > f64::from(u32::MAX) {
            let message = message!(
                "a motor would run {distance} pulses, limit {limit} pulses",
                distance,
                limit = u32::MAX
            );
            return Err(self.block.diagnostic(message));
        }
        if rate == 0 || distance < 1.0 {
            return Ok(build::motor(stepper, 0));
        }
        Ok(build::motor_by(stepper, rate, distance as u32))
    }

    fn sensor(&mut self) -> Result<Set, Diagnostic> {
        let on = self.choice("io", 0..=1)? == 1;
        let version = match self.choice("version", 0..=1)? {
            0 => SensorVersion::V1,
            _ => SensorVersion::V2,
        };
        let port = match self.choice("port", 0..=3)? {
            0 => Port::Gp1,
            1 => Port::Gp2,
            2 => Port::Gp4,
            _ => Port::Gp5,
        };
        Ok(match self.block.kind.as_str() {
            "dobot_SetInfraredSensor" => build::infrared(port, on, version),
            _ => build::color_sensor(port, on, version),
        })
    }

    /// Notes the threshold of lost steps, which cannot be queued (document 1.18.1).
    fn lost_steps(&mut self) -> Result<(), Diagnostic> {
        let value = self.single(&["threshold"], 0.5)?;
        let name = Set::from(LostStepParams { value }).row().set_name;
        let what = message!(
            "{name} cannot be queued: it is left out; set it separately before the run, with the \
                value {value}",
            name,
            value
        );
        self.note("threshold", what);
        Ok(())
    }
}
