//! Continuous path (document 1.11).

use magician_protocol::commands::*;

use crate::dispatch::{not_simulated, stored};

stored!(
    CpParams in cp,
    CpCommonParams in cp_common,
    CpRHeadHoldEnable in cp_hold_rotation,
);
not_simulated!(CpCmd, CpLeCmd);
