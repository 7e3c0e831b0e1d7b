//! What hosts have set and the flash does not keep: each parameter set of the protocol as it came, bit for bit.

use magician_protocol::commands::*;
use magician_protocol::{Flag, Handedness, TeachTrigger};

use crate::convert::tool_to_wire;
use crate::{ArmInstant, Profile};

/// Ids.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ids([u64; 4]);

impl Ids {
    pub(crate) fn add(&mut self, id: u8) {
        self.0[usize::from(id / 64)] |= 1 << (id % 64);
    }

    pub(crate) fn contains(&self, id: u8) -> bool {
        self.0[usize::from(id / 64)] & (1 << (id % 64)) != 0
    }
}

/// The parameter sets. They start as the profile says and change only when a host sets them.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// What has been set or done since power-up.
    pub(crate) told: Ids,
    pub(crate) with_rail: SetDeviceWithL,
    /// `None` until a host sets it: then it is the home joints of the profile.
    pub(crate) home: Option<HomeParams>,
    pub(crate) auto_leveling: SetAutoLeveling,
    pub(crate) teach_mode: HhtTrigMode,
    pub(crate) teach_enabled: HhtTrigOutputEnabled,
    pub(crate) orientation: ArmOrientation,
    pub(crate) bias: EndEffectorParams,
    pub(crate) jog_joint: JogJointParams,
    pub(crate) jog_coordinate: JogCoordinateParams,
    pub(crate) jog_common: JogCommonParams,
    pub(crate) jog_rail: JogLParams,
    pub(crate) ptp_joint: PtpJointParams,
    pub(crate) ptp_coordinate: PtpCoordinateParams,
    pub(crate) ptp_jump: PtpJumpParams,
    pub(crate) ptp_jump2: PtpJump2Params,
    pub(crate) ptp_common: PtpCommonParams,
    pub(crate) ptp_rail: PtpLParams,
    pub(crate) cp: CpParams,
    pub(crate) cp_common: CpCommonParams,
    pub(crate) cp_hold_rotation: CpRHeadHoldEnable,
    pub(crate) arc: ArcParams,
    pub(crate) arc_common: ArcCommonParams,
    pub(crate) wifi_config: WifiConfigMode,
    /// Since when the Wi-Fi module has been looking for its network, if not since power-up.
    pub(crate) wifi_begun: ArmInstant,
    pub(crate) firmware_mode: FirmwareMode,
    pub(crate) lost_step: LostStepParams,
    pub(crate) uart4: Uart4PeripheralsEnabled,
    pub(crate) pulse_mode: PulseMode,
}

impl Settings {
    pub(crate) fn new(profile: &Profile) -> Self {
        let crate::profile::Defaults {
            jog,
            ptp,
            cp,
            arc,
            lost_step,
            wifi: _,
        } = &profile.defaults;
        Self {
            told: Ids::default(),
            with_rail: SetDeviceWithL {
                with_l: Flag::OFF,
                version: None,
            },
            home: None,
            auto_leveling: SetAutoLeveling {
                is_auto_leveling: Flag::OFF,
                accuracy: 0.0,
            },
            teach_mode: HhtTrigMode {
                mode: TeachTrigger::OnRelease,
            },
            teach_enabled: HhtTrigOutputEnabled {
                is_enabled: Flag::OFF,
            },
            orientation: ArmOrientation {
                orientation: Handedness::Left,
            },
            bias: tool_to_wire(profile.power_up.tool),
            jog_joint: JogJointParams {
                velocity: jog.joint_velocity,
                acceleration: jog.joint_acceleration,
            },
            jog_coordinate: JogCoordinateParams {
                velocity: jog.coordinate_velocity,
                acceleration: jog.coordinate_acceleration,
            },
            jog_common: JogCommonParams {
                velocity_ratio: jog.velocity_ratio,
                acceleration_ratio: jog.acceleration_ratio,
            },
            jog_rail: JogLParams {
                velocity: jog.rail_velocity,
                acceleration: jog.rail_acceleration,
            },
            ptp_joint: PtpJointParams {
                velocity: ptp.joint_velocity,
                acceleration: ptp.joint_acceleration,
            },
            ptp_coordinate: PtpCoordinateParams {
                xyz_velocity: ptp.linear_velocity,
                r_velocity: ptp.rotation_velocity,
                xyz_acceleration: ptp.linear_acceleration,
                r_acceleration: ptp.rotation_acceleration,
            },
            ptp_jump: PtpJumpParams {
                jump_height: ptp.jump_height,
                z_limit: ptp.z_limit,
            },
            ptp_jump2: PtpJump2Params {
                start_jump_height: ptp.jump_height,
                end_jump_height: ptp.jump_height,
                z_limit: ptp.z_limit,
            },
            ptp_common: PtpCommonParams {
                velocity_ratio: ptp.velocity_ratio,
                acceleration_ratio: ptp.acceleration_ratio,
            },
            ptp_rail: PtpLParams {
                velocity: ptp.rail_velocity,
                acceleration: ptp.rail_acceleration,
            },
            cp: CpParams {
                plan_acc: cp.plan_acceleration,
                junction_vel: cp.junction_velocity,
                acc_or_period: cp.acceleration,
                real_time_track: Flag::from(cp.real_time_track),
            },
            cp_common: CpCommonParams {
                velocity_ratio: cp.velocity_ratio,
                acceleration_ratio: cp.acceleration_ratio,
            },
            cp_hold_rotation: CpRHeadHoldEnable {
                enable: Flag::from(cp.hold_rotation),
            },
            arc: ArcParams {
                xyz_velocity: arc.linear_velocity,
                r_velocity: arc.rotation_velocity,
                xyz_acceleration: arc.linear_acceleration,
                r_acceleration: arc.rotation_acceleration,
            },
            arc_common: ArcCommonParams {
                velocity_ratio: arc.velocity_ratio,
                acceleration_ratio: arc.acceleration_ratio,
            },
            wifi_config: WifiConfigMode { enable: Flag::OFF },
            wifi_begun: ArmInstant::ZERO,
            firmware_mode: FirmwareMode { mode: 0, ctl: 0 },
            lost_step: LostStepParams {
                value: lost_step.threshold,
            },
            uart4: Uart4PeripheralsEnabled {
                is_enabled: Flag::OFF,
            },
            pulse_mode: PulseMode {
                j1: 0.0,
                j2: 0.0,
                j3: 0.0,
                j4: 0.0,
                e1: 0.0,
                e2: 0.0,
            },
        }
    }
}
