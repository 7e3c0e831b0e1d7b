//! Methods reserved for links: frames that the protocol's table does not know. Other clients do not
//! get them, because nothing about such a frame can be checked.

use super::method::{method, optional_param, required_param};
use super::{Kind, Method, Param, Role};
use crate::control::WorkKind;

const ARM: Param = optional_param("arm", Kind::Text(32), "name of the arm");
const ID: Param = required_param("id", Kind::Integer(0, 255), "id of the command");
const BYTES: Param = required_param("params", Kind::Text(510), "parameters of the frame, as hex");

/// Methods reserved for links.
pub(super) static LINK_METHODS: &[Method] = &[
    method(
        "link.read",
        Role::Viewer,
        &[ARM, ID, BYTES],
        "Reads by a frame that the protocol's table does not have.",
        "{params}: as hex",
    ),
    method(
        "link.write",
        Role::Student,
        &[
            ARM,
            ID,
            BYTES,
            required_param("queued", Kind::Switch, "whether it goes to the queue"),
            required_param("moves", Kind::Switch, "whether it moves the arm"),
        ],
        "Sends a frame that the protocol's table does not have.",
        "{params} or {index}",
    )
    .leased(WorkKind::Queued),
    method(
        "link.start",
        Role::Student,
        &[ARM],
        "Starts the queue of the arm, if nothing waits in it.",
        "null",
    )
    .leased(WorkKind::Setting),
];
