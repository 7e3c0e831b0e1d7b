//! Waiting for an input (document 1.14).

use magician_protocol::commands::TrigCmd;

use crate::dispatch::not_simulated;

not_simulated!(TrigCmd);
