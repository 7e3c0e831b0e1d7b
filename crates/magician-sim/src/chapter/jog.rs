//! Jogging (document 1.9).

use magician_protocol::commands::*;

use crate::dispatch::{not_simulated, stored};

stored!(
    JogJointParams in jog_joint,
    JogCoordinateParams in jog_coordinate,
    JogCommonParams in jog_common,
    JogLParams in jog_rail,
);
not_simulated!(JogCmd);
