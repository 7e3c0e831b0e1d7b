//! Methods that a link has beside the others: frames that the protocol's table does not know. No other client has them, for
//! nothing is known of such a frame that could be checked.

use super::method::{may, method, needed};
use super::{Kind, Method, Param, Role};
use crate::control::WorkKind;

const ARM: Param = may("arm", Kind::Text(32), "name of the arm");
const ID: Param = needed("id", Kind::Integer(0, 255), "id of the command");
const BYTES: Param = needed("params", Kind::Text(510), "parameters of the frame, as hex");

/// All of them.
pub(super) static OF_LINKS: &[Method] = &[
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
            needed("queued", Kind::Switch, "whether it goes to the queue"),
            needed("moves", Kind::Switch, "whether it moves the arm"),
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
