//! Motion blocks of the robot. Fields, units and defaults are those of DobotStudio 1.9.

use magician_host::{Message, message};
use magician_protocol::commands::PtpWithLCmd;
use magician_protocol::{PtpMode, Set};

use super::machine::Machine;
use super::tree::Block;
use crate::{Action, Diagnostic, Travel};

pub(super) const JOINT_ANGLE: &str = "dobot_get_joint_angle";

/// Execution of one block.
pub(super) struct Call<'m, 't> {
    pub(super) machine: &'m mut Machine<'t>,
    index: usize,
    pub(super) block: &'t Block,
    depth: u32,
}

impl<'t> Machine<'t> {
    /// Executes a block of the robot.
    pub(super) fn robot(
        &mut self,
        index: usize,
        block: &'t Block,
        depth: u32,
    ) -> Result<(), Diagnostic> {
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

    /// Returns the coordinate or joint angle that a block reads, if earlier blocks determine it.
    pub(super) fn reading(
        &mut self,
        index: usize,
        block: &Block,
        depth: u32,
    ) -> Result<f64, Diagnostic> {
        let nth = self.number(index, block, &["value"], 1.0, depth)?;
        let course = &self.course;
        let axis = |axis: usize| course.at.and_then(|at| at.get(axis).copied());
        let joint = |joint: usize| {
            course
                .joints()
                .and_then(|joints| joints.get(joint).copied())
        };
        let (what, known): (Message, _) = match nth as i64 {
            1 => ("x".into(), axis(0)),
            2 => ("y".into(), axis(1)),
            3 => ("z".into(), axis(2)),
            4 => ("r".into(), course.r),
            5 => (message!("joint 1"), course.j1()),
            6 => (message!("joint 2"), joint(1)),
            7 => (message!("joint 3"), joint(2)),
            8 => (message!("joint 4"), course.j4()),
            0 => (message!("the position on the rail"), course.rail),
            _ => return Err(block.diagnostic(message!("there is no coordinate {nth}", nth))),
        };
        known.ok_or_else(|| {
            let message = message!(
                "it needs {what}, which is unknown when the plan is made: no earlier block gives \
                    the arm's position",
                what
            );
            let help = message!(
                "select the end effector and go to coordinates first; 'dobot_home' leads to a point that the arm keeps"
            );
            block.diagnostic(message).help(help)
        })
    }
}

impl Call<'_, '_> {
    pub(super) fn number(
        &mut self,
        names: &[&'static str],
        otherwise: f64,
    ) -> Result<f64, Diagnostic> {
        let Self {
            index,
            block,
            depth,
            ..
        } = *self;
        self.machine.number(index, block, names, otherwise, depth)
    }

    /// Returns a number as f32, as on the wire.
    pub(super) fn single(
        &mut self,
        names: &[&'static str],
        otherwise: f64,
    ) -> Result<f32, Diagnostic> {
        let number = self.number(names, otherwise)?;
        let name = names.first().copied().unwrap_or_default();
        fit(self.block, Some(name), number)
    }

    /// Returns one of a few whole numbers from a field.
    pub(super) fn choice(
        &mut self,
        name: &'static str,
        known: std::ops::RangeInclusive<u8>,
    ) -> Result<u8, Diagnostic> {
        let otherwise = f64::from(*known.start());
        let number = self.number(&[name], otherwise)?;
        let found = known.clone().find(|code| f64::from(*code) == number);
        found.ok_or_else(|| {
            let (kind, from, to) = (&self.block.kind, known.start(), known.end());
            self.block.diagnostic(message!(
                "{name} of {kind} is {number}, it must be {from} to {to}",
                name,
                kind,
                number,
                from,
                to
            ))
        })
    }

    pub(super) fn push(&mut self, action: impl Into<Action>) {
        self.machine.push(self.index, action);
    }

    pub(super) fn note(&mut self, about: &'static str, what: Message) {
        self.machine.note(self.index, about, what);
    }

    fn unknown_place(&self, what: Message) -> Diagnostic {
        let message = message!(
            "{what}, which is unknown when the plan is made: no earlier block gives the arm's \
                position",
            what
        );
        let help = message!(
            "go to coordinates or joint angles first; 'dobot_home' leads to a point that the arm keeps"
        );
        self.block.diagnostic(message).help(help)
    }

    fn home(&mut self) {
        self.push(Action::Home);
        self.machine.course.home();
    }

    pub(super) fn place(&mut self, x: f64) -> Result<[f64; 3], Diagnostic> {
        let x = self.single(&["xBias"], x)?;
        let y = self.single(&["yBias"], 0.0)?;
        let z = self.single(&["zBias"], 0.0)?;
        Ok([x, y, z].map(f64::from))
    }

    /// Moves to coordinates. A line keeps r; a jump has r = 0.
    fn go(&mut self, by: Travel) -> Result<(), Diagnostic> {
        let [x, y, z] = self.place(208.0)?;
        let r = match (by, self.machine.course.r) {
            (Travel::Line, Some(r)) => r,
            (Travel::Line, None) => {
                let what = message!("it keeps r, which no earlier block has set: 0 is used");
                self.note("r", what);
                0.0
            }
            _ => 0.0,
        };
        self.arrive([x, y, z, r], by)
    }

    fn arrive(&mut self, to: [f64; 4], by: Travel) -> Result<(), Diagnostic> {
        self.machine.course.go(to);
        let to = poses(self.block, to)?;
        self.push(Action::Move { to, by });
        Ok(())
    }

    fn shift(&mut self) -> Result<(), Diagnostic> {
        let by = self.place(0.0)?;
        self.machine.course.shift(by);
        let [x, y, z] = by;
        let by = poses(self.block, [x, y, z, 0.0])?;
        self.push(Action::Shift { by, line: true });
        Ok(())
    }

    /// Turns the tool. The studio moves only J4 to the angle, so the position stays and r = J1 +
    /// J4.
    fn turn(&mut self) -> Result<(), Diagnostic> {
        let j4 = self.number(&["R"], 0.0)?;
        let course = &self.machine.course;
        if let (Some([x, y, z]), Some(j1)) = (course.at, course.j1()) {
            return self.arrive([x, y, z, j1 + j4], Travel::Joints);
        }
        let Some([j1, j2, j3, _]) = course.joints() else {
            let what = message!("it turns the tool at the arm's position");
            return Err(self.unknown_place(what));
        };
        self.joints([j1, j2, j3, j4])
    }

    fn joints(&mut self, joints: [f64; 4]) -> Result<(), Diagnostic> {
        let to = poses(self.block, joints)?;
        self.machine.course.bend(to.map(f64::from));
        let by = Travel::Joints;
        self.push(Action::Joints { to, by });
        Ok(())
    }

    /// Moves to joint angles. J4 stays.
    fn bend(&mut self) -> Result<(), Diagnostic> {
        let j1 = self.number(&["Joint1"], 0.0)?;
        let j2 = self.number(&["Joint2"], 0.0)?;
        let j3 = self.number(&["Joint3"], 0.0)?;
        let j4 = self.machine.course.j4().unwrap_or_else(|| {
            let what = message!("it keeps joint 4, which no earlier block has set: 0 is used");
            self.note("j4", what);
            0.0
        });
        self.joints([j1, j2, j3, j4])
    }

    /// Moves the rail. The arm keeps its pose.
    fn slide(&mut self) -> Result<(), Diagnostic> {
        let l = self.single(&["L"], 0.0)?;
        let course = &self.machine.course;
        let (ptp_mode, numbers) = match (course.at, course.r, course.joints()) {
            (Some([x, y, z]), Some(r), _) => (PtpMode::MovjXyz, [x, y, z, r]),
            (_, _, Some(joints)) => (PtpMode::MovjAngle, joints),
            _ => {
                let what = message!("it moves the rail at the arm's position");
                return Err(self.unknown_place(what));
            }
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

    fn wait(&mut self) -> Result<(), Diagnostic> {
        let seconds = self.number(&["time"], 0.5)?;
        let milliseconds = (seconds * 1000.0).round();
        if !(0.0..=f64::from(u32::MAX)).contains(&milliseconds) {
            let most = f64::from(u32::MAX) / 1000.0;
            let message = message!(
                "it waits for {seconds} s, it must be 0 to {most} s",
                seconds,
                most
            );
            return Err(self.block.diagnostic(message));
        }
        if milliseconds > 0.0 {
            self.push(Action::Wait(milliseconds as u32));
        }
        Ok(())
    }
}

/// Converts a number to f32; `name` is that of its field, if it has one.
fn fit(block: &Block, name: Option<&str>, number: f64) -> Result<f32, Diagnostic> {
    let single = number as f32;
    if single.is_finite() {
        Ok(single)
    } else {
        let kind = &block.kind;
        Err(block.diagnostic(match name {
            Some(name) => message!(
                "{name} of {kind} is {number}, out of range",
                name,
                kind,
                number
            ),
            None => message!("a number of {kind} is {number}, out of range", kind, number),
        }))
    }
}

fn poses(block: &Block, numbers: [f64; 4]) -> Result<[f32; 4], Diagnostic> {
    let mut pose = [0.0; 4];
    for (number, single) in numbers.into_iter().zip(&mut pose) {
        *single = fit(block, None, number)?;
    }
    Ok(pose)
}
