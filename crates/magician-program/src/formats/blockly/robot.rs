//! What the robot's own blocks have the arm do. Fields, units and the numbers for what is missing are those of the blocks in
//! DobotStudio 1.9.

use magician::words;
use magician_motion::ToolBias;
use magician_protocol::commands::{
    LostStepParams, PtpCoordinateParams, PtpWithLCmd, SetDeviceWithL,
};
use magician_protocol::{
    Flag, IoFunction, Port, PtpMode, RailVersion, SensorVersion, Set, Stepper,
};

use super::machine::Machine;
use super::refused;
use super::tree::Block;
use crate::{Action, Grip, Problem, Tool, Travel};

pub(super) const JOINT_ANGLE: &str = "dobot_get_joint_angle";

/// Pulses by which the studio has the belt go 1 mm. The belt goes about 1.9 mm by them (model section 13).
const STUDIO_PULSES_PER_MM: f64 = 32_000.0 / (36.0 * std::f64::consts::PI);
/// Beyond it the arm reads a rate as another one (errata E41), pulses/s.
const FASTEST_PULSES: f64 = 1e6;

/// One block under way.
struct Call<'m, 't> {
    machine: &'m mut Machine<'t>,
    index: usize,
    block: &'t Block,
    depth: u32,
}

impl<'t> Machine<'t> {
    /// Does what a robot's block says.
    pub(super) fn robot(
        &mut self,
        index: usize,
        block: &'t Block,
        depth: u32,
    ) -> Result<(), Problem> {
        let mut call = Call {
            machine: self,
            index,
            block,
            depth,
        };
        match block.kind.as_str() {
            "dobot_home" => call.home(),
            "dobot_goto" => return call.go(Travel::Line),
            "dobot_jumpto" => return call.go(Travel::Jump),
            "dobot_move" => return call.shift(),
            "dobot_setr" => return call.turn(),
            "dobot_setl" => return call.slide(),
            "dobot_setjointangle" => return call.bend(),
            "dobot_delaytime" => return call.wait(),
            _ => return call.setting(),
        }
        Ok(())
    }

    /// What a block reads of the arm's place, as far as the blocks before it tell.
    pub(super) fn reading(
        &mut self,
        index: usize,
        block: &Block,
        depth: u32,
    ) -> Result<f64, Problem> {
        let nth = self.number(index, block, &["value"], 1.0, depth)?;
        let course = &self.course;
        let axis = |axis: usize| course.at.and_then(|at| at.get(axis).copied());
        let joint = |joint: usize| {
            course
                .joints()
                .and_then(|joints| joints.get(joint).copied())
        };
        let (what, known) = match nth as i64 {
            1 => ("x", axis(0)),
            2 => ("y", axis(1)),
            3 => ("z", axis(2)),
            4 => ("r", course.r),
            5 => ("joint 1", course.j1()),
            6 => ("joint 2", joint(1)),
            7 => ("joint 3", joint(2)),
            8 => ("joint 4", course.j4()),
            0 => ("the place on the rail", course.rail),
            _ => return Err(block.problem(format!("there is no coordinate {nth}"))),
        };
        known.ok_or_else(|| {
            let message = format!(
                "it asks for {what}, which is not known when the plan is made: no block before it says where the arm is"
            );
            let help = "select the end effector and go to coordinates first; `dobot_home` leads to a point that the arm keeps";
            block.problem(message).help(help)
        })
    }
}

impl Call<'_, '_> {
    fn number(&mut self, names: &[&'static str], otherwise: f64) -> Result<f64, Problem> {
        let Self {
            index,
            block,
            depth,
            ..
        } = *self;
        self.machine.number(index, block, names, otherwise, depth)
    }

    /// As the wire has it.
    fn single(&mut self, names: &[&'static str], otherwise: f64) -> Result<f32, Problem> {
        let number = self.number(names, otherwise)?;
        let name = names.first().copied().unwrap_or_default();
        fit(self.block, name, number)
    }

    /// One of a few whole numbers, in a field of the block.
    fn choice(
        &mut self,
        name: &'static str,
        known: std::ops::RangeInclusive<u8>,
    ) -> Result<u8, Problem> {
        let otherwise = f64::from(*known.start());
        let number = self.number(&[name], otherwise)?;
        let found = known.clone().find(|code| f64::from(*code) == number);
        found.ok_or_else(|| {
            let (kind, from, to) = (&self.block.kind, known.start(), known.end());
            self.block.problem(format!(
                "{name} of {kind} is {number}; {from} to {to} can be"
            ))
        })
    }

    fn push(&mut self, action: impl Into<Action>) {
        self.machine.push(self.index, action);
    }

    fn note(&mut self, about: &'static str, what: &str) {
        self.machine.note(self.index, about, what);
    }

    fn unknown_place(&self, what: &str) -> Problem {
        let message = format!(
            "{what}, which is not known when the plan is made: no block before it says where the arm is"
        );
        let help = "go to coordinates or joint angles first; `dobot_home` leads to a point that the arm keeps";
        self.block.problem(message).help(help)
    }

    fn home(&mut self) {
        self.push(Action::Home);
        self.machine.course.home();
    }

    fn place(&mut self, x: f64) -> Result<[f64; 3], Problem> {
        let x = self.single(&["xBias"], x)?;
        let y = self.single(&["yBias"], 0.0)?;
        let z = self.single(&["zBias"], 0.0)?;
        Ok([x, y, z].map(f64::from))
    }

    /// A line keeps r, a jump has r = 0.
    fn go(&mut self, by: Travel) -> Result<(), Problem> {
        let [x, y, z] = self.place(208.0)?;
        let r = match (by, self.machine.course.r) {
            (Travel::Line, Some(r)) => r,
            (Travel::Line, None) => {
                let what = "it keeps r, which no block before it has set: 0 is taken";
                self.note("r", what);
                0.0
            }
            _ => 0.0,
        };
        self.arrive([x, y, z, r], by)
    }

    fn arrive(&mut self, to: [f64; 4], by: Travel) -> Result<(), Problem> {
        self.machine.course.go(to);
        let to = poses(self.block, to)?;
        self.push(Action::Move { to, by });
        Ok(())
    }

    fn shift(&mut self) -> Result<(), Problem> {
        let by = self.place(0.0)?;
        self.machine.course.shift(by);
        let [x, y, z] = by;
        let by = poses(self.block, [x, y, z, 0.0])?;
        self.push(Action::Shift { by, line: true });
        Ok(())
    }

    /// The studio turns J4 to the number and leaves the other joints: the same place, with r = J1 + J4.
    fn turn(&mut self) -> Result<(), Problem> {
        let j4 = self.number(&["R"], 0.0)?;
        let course = &self.machine.course;
        if let (Some([x, y, z]), Some(j1)) = (course.at, course.j1()) {
            return self.arrive([x, y, z, j1 + j4], Travel::Joints);
        }
        let Some([j1, j2, j3, _]) = course.joints() else {
            return Err(self.unknown_place("it turns the tool where the arm is"));
        };
        self.joints([j1, j2, j3, j4])
    }

    fn joints(&mut self, joints: [f64; 4]) -> Result<(), Problem> {
        let to = poses(self.block, joints)?;
        self.machine.course.bend(to.map(f64::from));
        let by = Travel::Joints;
        self.push(Action::Joints { to, by });
        Ok(())
    }

    /// J4 stays as it is.
    fn bend(&mut self) -> Result<(), Problem> {
        let j1 = self.number(&["Joint1"], 0.0)?;
        let j2 = self.number(&["Joint2"], 0.0)?;
        let j3 = self.number(&["Joint3"], 0.0)?;
        let j4 = self.machine.course.j4().unwrap_or_else(|| {
            let what = "it keeps joint 4, which no block before it has set: 0 is taken";
            self.note("j4", what);
            0.0
        });
        self.joints([j1, j2, j3, j4])
    }

    /// The arm keeps its place, the carriage moves.
    fn slide(&mut self) -> Result<(), Problem> {
        let l = self.single(&["L"], 0.0)?;
        let course = &self.machine.course;
        let (ptp_mode, numbers) = match (course.at, course.r, course.joints()) {
            (Some([x, y, z]), Some(r), _) => (PtpMode::MovjXyz, [x, y, z, r]),
            (_, _, Some(joints)) => (PtpMode::MovjAngle, joints),
            _ => return Err(self.unknown_place("it moves the rail under the arm where that is")),
        };
        let [x, y, z, r] = poses(self.block, numbers)?;
        let course = &mut self.machine.course;
        course.rail = Some(f64::from(l));
        self.push(Set::from(PtpWithLCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
            l,
        }));
        Ok(())
    }

    fn wait(&mut self) -> Result<(), Problem> {
        let seconds = self.number(&["time"], 0.5)?;
        let milliseconds = (seconds * 1000.0).round();
        if !(0.0..=f64::from(u32::MAX)).contains(&milliseconds) {
            let most = f64::from(u32::MAX) / 1000.0;
            let message = format!("it waits for {seconds} s; 0 to {most} s can be");
            return Err(self.block.problem(message));
        }
        if milliseconds > 0.0 {
            self.push(Action::Wait(milliseconds as u32));
        }
        Ok(())
    }

    fn setting(&mut self) -> Result<(), Problem> {
        let action = match self.block.kind.as_str() {
            "dobot_selectendtype" => return self.select_tool(),
            "dobot_SetEndEffectorParams" => {
                let [x, y, z] = self.place(0.0)?;
                return self.fit_tool(ToolBias::new(x, y, z));
            }
            "dobot_setjumpheight" => {
                words::jump_height(self.single(&["height"], 20.0)?, 100.0).into()
            }
            "dobot_setlinearspeed" => {
                let [velocity, acceleration] = self.rates()?;
                words::speed(velocity, acceleration).into()
            }
            "dobot_setptpjointparams" => {
                let [velocity, acceleration] = self.rates()?;
                words::joint_speed([velocity; 4], [acceleration; 4]).into()
            }
            // The studio has it with this spelling.
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
                words::rail_speed(velocity, acceleration).into()
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

    fn rates(&mut self) -> Result<[f32; 2], Problem> {
        let velocity = self.single(&["Velocity", "lVelocity"], 20.0)?;
        let acceleration = self.single(&["Acceleration", "lAcceleration"], 50.0)?;
        Ok([velocity, acceleration])
    }

    /// The block says the tool by how far it stands out; the gripper, as far out as the suction cup, has a digit more.
    fn select_tool(&mut self) -> Result<(), Problem> {
        let out = self.number(&["type"], 59.7)?;
        let tools = [
            (59.7, Tool::Suction),
            (59.701, Tool::Gripper),
            (61.0, Tool::Pen),
            (70.0, Tool::Laser),
        ];
        let Some((_, tool)) = tools.into_iter().find(|(own, _)| *own == out) else {
            let message = format!(
                "there is no end effector of type {out}; there are 59.7, 59.701, 61 and 70"
            );
            return Err(self.block.problem(message));
        };
        if self.machine.plan.steps.is_empty() {
            self.machine.plan.tool = Some(tool);
        }
        self.fit_tool(tool.bias())
    }

    fn fit_tool(&mut self, bias: ToolBias) -> Result<(), Problem> {
        self.machine.course.fit(bias);
        self.push(words::tool(bias));
        Ok(())
    }

    fn laser(&mut self) -> Result<(), Problem> {
        let on = self.choice("enable", 0..=1)? == 1;
        if on {
            let power = self.number(&["power"], 50.0)?;
            if power <= 0.0 {
                self.push(Action::Laser(false));
                return Ok(());
            }
            let what = "the laser is on or off here: its power is left out";
            self.note("power", what);
        }
        self.push(Action::Laser(on));
        Ok(())
    }

    /// What is beside the arm: pins, motors, sensors, the rail.
    fn beside(&mut self) -> Result<(), Problem> {
        let action: Action = match self.block.kind.as_str() {
            "dobot_setiomultiplexing" => {
                let function = match self.choice("value", 1..=7)? {
                    1 => IoFunction::DigitalInput,
                    3 => IoFunction::AnalogInput,
                    4..=6 => IoFunction::DigitalOutput,
                    7 => IoFunction::Pwm,
                    other => {
                        let message =
                            format!("there is no function {other} of a pin in the studio");
                        return Err(self.block.problem(message));
                    }
                };
                words::multiplex(self.choice("io", 1..=20)?, function).into()
            }
            "dobot_set_output" => {
                let pin = self.choice("io", 1..=20)?;
                words::output(pin, self.choice("value", 0..=1)? == 1).into()
            }
            "dobot_set_output5V" | "dobot_set_output12V" => {
                let pin = self.choice("io", 1..=20)?;
                words::output(pin, self.choice("enable", 0..=1)? == 1).into()
            }
            "dobot_setiopwm" => {
                let pin = self.choice("io", 1..=20)?;
                let frequency = self.single(&["frequency"], 1.0)?;
                words::pwm(pin, frequency, self.single(&["dutyCycle"], 40.0)?).into()
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
            "dobot_SetLostStepCmd" => words::check_lost_steps().into(),
            "dobot_SetLostStepParams" => return self.lost_steps(),
            _ => return Err(refused::problem(self.block)),
        };
        self.push(action);
        Ok(())
    }

    fn motor(&mut self) -> Result<Set, Problem> {
        let stepper = match self.choice("io", 0..=1)? {
            0 => Stepper::Stepper1,
            _ => Stepper::Stepper2,
        };
        let belt = self.block.kind == "dobot_conveyor";
        let pulses = match belt {
            true => {
                let what = "the belt goes about 1.9 times as fast as the block says, as it does in the studio";
                self.note("belt", what);
                self.number(&["speed"], 50.0)? * STUDIO_PULSES_PER_MM
            }
            false => self.number(&["speed"], 10_000.0)?,
        };
        if pulses.abs() > FASTEST_PULSES {
            let message =
                format!("a motor is to go at {pulses} pulses/s, at most {FASTEST_PULSES} can be");
            return Err(self.block.problem(message));
        }
        let rate = pulses.trunc() as i32;
        if self.block.kind != "dobot_setemotors" {
            return Ok(words::motor(stepper, rate));
        }
        let distance = self.number(&["distance"], 10_000.0)?;
        if distance > f64::from(u32::MAX) {
            let message = format!(
                "a motor is to go {distance} pulses far, at most {} can be",
                u32::MAX
            );
            return Err(self.block.problem(message));
        }
        if rate == 0 || distance < 1.0 {
            return Ok(words::motor(stepper, 0));
        }
        Ok(words::motor_by(stepper, rate, distance as u32))
    }

    fn sensor(&mut self) -> Result<Set, Problem> {
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
            "dobot_SetInfraredSensor" => words::infrared(port, on, version),
            _ => words::color_sensor(port, on, version),
        })
    }

    /// It cannot be queued (document 1.18.1).
    fn lost_steps(&mut self) -> Result<(), Problem> {
        let value = self.single(&["threshold"], 0.5)?;
        let name = Set::from(LostStepParams { value }).row().set_name;
        let what = format!(
            "{name} cannot be queued: it is left out; send `magician set {name} value={value}` before"
        );
        self.note("threshold", &what);
        Ok(())
    }
}

fn fit(block: &Block, name: &str, number: f64) -> Result<f32, Problem> {
    let single = number as f32;
    match single.is_finite() {
        true => Ok(single),
        false => Err(block.problem(format!(
            "{name} of {} is {number}, out of all range",
            block.kind
        ))),
    }
}

fn poses(block: &Block, numbers: [f64; 4]) -> Result<[f32; 4], Problem> {
    let mut pose = [0.0; 4];
    for (number, single) in numbers.into_iter().zip(&mut pose) {
        *single = fit(block, "a number", number)?;
    }
    Ok(pose)
}
