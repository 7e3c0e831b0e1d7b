//! Arcs and circles (document 1.12).

use magician_protocol::commands::*;

use crate::dispatch::{not_simulated, stored};

stored!(ArcParams in arc, ArcCommonParams in arc_common);
not_simulated!(ArcCmd, CircleCmd);
