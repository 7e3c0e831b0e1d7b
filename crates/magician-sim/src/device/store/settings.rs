//! Settings that hosts send and the flash does not keep. Each parameter set is stored bit for bit
//! as it was sent, except that speeds above a ceiling are lowered to it before.

use magician_model::MotionSettings;
use magician_motion::{Pose, Target};
use magician_protocol::commands::{
    ArmOrientation, CpCommonParams, CpRHeadHoldEnable, FirmwareMode, HhtTrigMode,
    HhtTrigOutputEnabled, HomeParams, LostStepParams, PulseMode, SetAutoLeveling,
    Uart4PeripheralsEnabled, WifiConfigMode,
};
use magician_protocol::{Flag, Handedness, TeachTrigger};

use crate::ArmInstant;
use crate::convert::from_wire;
use crate::device::firmware::Firmware;

/// A set of command ids.
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

/// The parameter sets. They start with the values of the profile.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Ids of the commands that were set or carried out since power-up.
    pub(crate) set_ids: Ids,
    /// `None` until a host sets it; homing then ends at the home joints of the profile.
    pub(crate) home: Option<HomeParams>,
    pub(crate) auto_leveling: SetAutoLeveling,
    pub(crate) teach_mode: HhtTrigMode,
    pub(crate) teach_enabled: HhtTrigOutputEnabled,
    pub(crate) orientation: ArmOrientation,
    /// Settings on which motions depend.
    pub(crate) motion: MotionSettings,
    pub(crate) cp_common: CpCommonParams,
    pub(crate) cp_hold_rotation: CpRHeadHoldEnable,
    pub(crate) wifi_config: WifiConfigMode,
    /// Instant at which the Wi-Fi module began to join its network.
    pub(crate) wifi_begun: ArmInstant,
    pub(crate) firmware_mode: FirmwareMode,
    pub(crate) lost_step: LostStepParams,
    pub(crate) uart4: Uart4PeripheralsEnabled,
    pub(crate) pulse_mode: PulseMode,
}

impl Settings {
    pub(crate) fn new(firmware: &Firmware) -> Self {
        let crate::profile::Defaults { cp, lost_step, .. } = &firmware.profile.defaults;
        Self {
            set_ids: Ids::default(),
            home: None,
            auto_leveling: SetAutoLeveling {
                is_auto_leveling: Flag::OFF,
                accuracy: 0.0,
            },
            teach_mode: HhtTrigMode {
                // Mode 0: one point for each release of the key (model section 12).
                mode: TeachTrigger::OnRelease,
            },
            teach_enabled: HhtTrigOutputEnabled {
                is_enabled: Flag::OFF,
            },
            orientation: ArmOrientation {
                orientation: Handedness::Left,
            },
            motion: MotionSettings::at_power_up(&firmware.model),
            cp_common: CpCommonParams {
                velocity_ratio: cp.velocity_ratio,
                acceleration_ratio: cp.acceleration_ratio,
            },
            cp_hold_rotation: CpRHeadHoldEnable {
                enable: Flag::from(cp.hold_rotation),
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

    /// Home point; `None` unless a host has set it.
    pub(crate) fn home_point(&self) -> Option<Target> {
        let HomeParams { x, y, z, r } = self.home?;
        Some(Target::Pose(Pose::from(from_wire([x, y, z, r]))))
    }
}
