//! Classification of commands that light the laser, shared by all front ends.

use magician_protocol::commands::{ClearAlarmsState, ClearAllAlarmsState, QueuedCmdStartExec};
use magician_protocol::{Frame, PoList, Row, Set, Writable};

/// EIO address of the laser's supply (model section 13).
pub const LASER_SUPPLY: u8 = 2;
/// EIO address of the laser's modulation (model section 13).
pub const LASER_POWER: u8 = 4;

/// True if a command may light the laser.
///
/// These are `SetEndEffectorLaser` enabled and on, `CpLeCmd` with a power above 0, and commands
/// that raise one of the laser's pins: `IoPwm` on EIO 4, `IoDo` on EIO 2 or 4, `PtpPoCmd` and
/// `PtpPoWithLCmd` that switch these on. `laser_pins` is false for an arm whose pins drive
/// something else than a laser.
///
/// ```
/// use magician_host::{burns, build};
///
/// assert!(burns(&build::laser(true), true));
/// assert!(!burns(&build::laser(false), true));
/// assert!(burns(&build::output(4, true), true) && !burns(&build::output(4, true), false));
/// ```
#[must_use]
pub fn burns(command: &Set, laser_pins: bool) -> bool {
    match command {
        Set::SetEndEffectorLaser(laser) => laser.enable_ctrl.is_on() && laser.on.is_on(),
        // NaN counts as a power: how firmware treats it is unknown.
        Set::CpLeCmd(segment) => is_above_zero(segment.velocity_or_power),
        command => laser_pins && raises_laser_pin(command),
    }
}

/// True if a command switches one of the laser's pins on.
pub fn raises_laser_pin(command: &Set) -> bool {
    let is_laser = |address: u16| {
        [LASER_SUPPLY, LASER_POWER]
            .map(u16::from)
            .contains(&address)
    };
    let raised = |outputs: &PoList| {
        let mut outputs = outputs.as_slice().iter();
        outputs.any(|output| is_laser(output.address) && output.level != 0)
    };
    match command {
        Set::IoDo(output) => is_laser(output.address.into()) && output.level.is_on(),
        // Of the two pins only EIO 4 has PWM; the supply has only levels.
        Set::IoPwm(output) => output.address == LASER_POWER && is_above_zero(output.duty_cycle),
        Set::PtpPoCmd(command) => raised(&command.po),
        Set::PtpPoWithLCmd(command) => raised(&command.po),
        _ => false,
    }
}

fn is_above_zero(share: f32) -> bool {
    share.is_nan() || share > 0.0
}

/// True if a frame may light the laser (see [`burns`]). A frame that could burn and cannot be
/// decoded counts as burning.
pub fn frame_burns(frame: &Frame<'_>, laser_pins: bool) -> bool {
    let row = Row::with_id(frame.id());
    // Reads never burn, and unknown ids have no known effect.
    if !acts(frame) || !row.is_some_and(|row| row.may_burn) {
        return false;
    }
    let command = Set::decode(frame.id(), frame.params());
    // Undecodable parameters: assume the worst.
    command.map_or(true, |command| burns(&command, laser_pins))
}

/// True if a frame may start a stopped queue. The waiting commands of all programs then run.
pub fn frame_releases_queue(frame: &Frame<'_>) -> bool {
    // Clearing the alarms releases a queue that an alarm holds.
    let releases = [
        QueuedCmdStartExec::ROW.id,
        ClearAlarmsState::ROW.id,
        ClearAllAlarmsState::ROW.id,
    ];
    acts(frame) && releases.contains(&frame.id())
}

fn acts(frame: &Frame<'_>) -> bool {
    frame.ctrl().write() || frame.ctrl().queued()
}

#[cfg(test)]
mod tests {
    use magician_protocol::commands::{
        CpLeCmd, IoDo, IoPwm, PtpCmd, PtpPoCmd, PtpPoWithLCmd, QueuedCmdStopExec,
        SetEndEffectorLaser,
    };
    use magician_protocol::{CpMode, Ctrl, Flag, FrameBuf, PoCmd, PtpMode};

    use super::*;
    use crate::build;

    /// [`frame_burns`] does not decode a command whose row says that it cannot burn, so the rows
    /// must be right.
    #[test]
    fn table_marks_commands_that_may_burn() {
        use magician_protocol::commands::TABLE;
        let may: Vec<u8> = TABLE
            .iter()
            .filter(|row| row.may_burn)
            .map(|row| row.id)
            .collect();
        let burning = [
            SetEndEffectorLaser::ROW.id,
            PtpPoCmd::ROW.id,
            PtpPoWithLCmd::ROW.id,
            CpLeCmd::ROW.id,
            IoDo::ROW.id,
            IoPwm::ROW.id,
        ];
        assert_eq!(may, burning);
    }

    fn path(power: f32) -> Set {
        Set::CpLeCmd(CpLeCmd {
            cp_mode: CpMode::Absolute,
            x: 200.0,
            y: 0.0,
            z: 0.0,
            velocity_or_power: power,
        })
    }

    fn laser(enable: u8, on: u8) -> Set {
        Set::SetEndEffectorLaser(SetEndEffectorLaser {
            enable_ctrl: Flag(enable),
            on: Flag(on),
        })
    }

    fn level(address: u8, level: u8) -> Set {
        let level = Flag(level);
        Set::IoDo(IoDo { address, level })
    }

    fn pulses(address: u8, duty_cycle: f32) -> Set {
        let frequency = 1000.0;
        Set::IoPwm(IoPwm {
            address,
            frequency,
            duty_cycle,
        })
    }

    fn on_the_way(outputs: &[(u16, u8)]) -> [Set; 2] {
        let output = |(address, level): &(u16, u8)| PoCmd {
            ratio: 50,
            address: *address,
            level: *level,
        };
        let outputs: Vec<_> = outputs.iter().map(output).collect();
        let po = PoList::new(&outputs).unwrap();
        let (ptp_mode, x, y, z, r, l) = (PtpMode::MovlXyz, 220.0, 0.0, 0.0, 0.0, 100.0);
        [
            Set::PtpPoCmd(PtpPoCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
                po,
            }),
            Set::PtpPoWithLCmd(PtpPoWithLCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
                l,
                po,
            }),
        ]
    }

    /// Commands of each class, and whether each burns with and without a laser on the pins.
    fn table() -> Vec<(Set, bool, bool)> {
        let mut table = vec![
            (laser(1, 1), true, true),
            (laser(200, 7), true, true),
            (laser(0, 1), false, false),
            (laser(1, 0), false, false),
            (laser(0, 0), false, false),
            (path(0.01), true, true),
            (path(100.0), true, true),
            (path(f32::NAN), true, true),
            (path(0.0), false, false),
            (path(-0.0), false, false),
            (path(-5.0), false, false),
            (build::path_to(200.0, 0.0, 0.0), false, false),
            (level(2, 1), true, false),
            (level(4, 1), true, false),
            (level(4, 255), true, false),
            (level(2, 0), false, false),
            (level(4, 0), false, false),
            (level(3, 1), false, false),
            (level(16, 1), false, false),
            (pulses(4, 0.5), true, false),
            (pulses(4, f32::NAN), true, false),
            (pulses(4, 0.0), false, false),
            (pulses(2, 50.0), false, false),
            (pulses(6, 50.0), false, false),
            (build::suction(true), false, false),
            (build::grip(), false, false),
            (build::home(), false, false),
        ];
        for (outputs, burns) in [
            (&[(2, 1)][..], true),
            (&[(4, 9)], true),
            (&[(1, 1), (17, 1), (4, 1)], true),
            (&[(2, 0), (4, 0)], false),
            (&[(1, 1), (260, 1)], false),
            (&[], false),
        ] {
            let both = on_the_way(outputs);
            table.extend(both.map(|command| (command, burns, false)));
        }
        table
    }

    #[test]
    fn command_burns_if_it_lights_laser_or_raises_laser_pin() {
        for (command, with_pins, without) in table() {
            assert_eq!(burns(&command, true), with_pins, "{command:?}");
            assert_eq!(burns(&command, false), without, "{command:?}");
        }
    }

    #[test]
    fn frame_burns_like_its_command_immediate_or_queued() {
        for (command, with_pins, without) in table() {
            for ctrl in [Ctrl::SET, Ctrl::QUEUED] {
                let frame = FrameBuf::set(&command, ctrl).unwrap();
                assert_eq!(frame_burns(&frame.frame(), true), with_pins, "{command:?}");
                assert_eq!(frame_burns(&frame.frame(), false), without, "{command:?}");
            }
            let read = FrameBuf::new(command.row().id, Ctrl::GET, &[]).unwrap();
            assert!(!frame_burns(&read.frame(), true), "a read of {command:?}");
        }
    }

    #[test]
    fn undecodable_command_that_may_burn_burns() {
        for (command, ..) in table() {
            let id = command.row().id;
            let frame = FrameBuf::new(id, Ctrl::SET, &[1]).unwrap();
            let may = command.row().may_burn;
            assert_eq!(frame_burns(&frame.frame(), true), may, "{id}");
        }
        let other = FrameBuf::new(PtpCmd::ROW.id, Ctrl::SET, &[1]).unwrap();
        assert!(!frame_burns(&other.frame(), true));
    }

    #[test]
    fn start_and_clear_alarms_release_queue() {
        let releases = |id, ctrl| {
            let frame = FrameBuf::new(id, ctrl, &[]).unwrap();
            frame_releases_queue(&frame.frame())
        };
        assert!(releases(QueuedCmdStartExec::ROW.id, Ctrl::SET));
        assert!(releases(ClearAlarmsState::ROW.id, Ctrl::SET));
        assert!(releases(ClearAllAlarmsState::ROW.id, Ctrl::SET));
        assert!(!releases(ClearAlarmsState::ROW.id, Ctrl::GET));
        assert!(!releases(QueuedCmdStopExec::ROW.id, Ctrl::SET));
    }
}
