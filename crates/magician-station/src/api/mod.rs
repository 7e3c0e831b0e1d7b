//! The API as data: messages, errors, and the tables that describe it.
//!
//! Methods, notifications, events, types, errors and the binary frame are each one table. The
//! station checks requests against the tables; the OpenRPC document, the pages of the book, the
//! types of other languages and the tests are generated from them. So a description cannot differ
//! from what the station does.

#[cfg(feature = "class")]
mod class;
mod error;
mod errors;
mod events;
mod examples;
mod fields;
mod ids;
mod link;
mod message;
mod method;
mod methods;
mod notifications;
mod openrpc;
mod param;
mod schemas;
mod shape;
mod types;
mod wire;

pub(crate) use error::Danger;
pub use error::RpcError;
pub use errors::{ERRORS, ErrorRow};
pub use events::{ArmEvent, EVENTS, EventRow};
pub use examples::{Example, ExampleCall, NotificationExample};
pub(crate) use fields::encode;
pub use ids::{ERROR_IDS, IdKind, IdPlace, each_id};
pub use message::{BadMessage, Message, MessageId, answer, answer_due, notification};
pub use method::{Method, Needs, Role};
pub use notifications::{NOTIFICATIONS, Notice, Notification};
pub use openrpc::openrpc;
pub use param::{Kind, Param, Params};
pub use shape::{Member, Shape, Type};
pub(crate) use types::JOB_STATES;
pub use types::TYPES;
pub use wire::{CLOSE_CODES, FEATURES, FRAME_FLAGS, FRAME_PARTS, Feature, FeatureRow, FramePart};

/// All methods, in documentation order.
#[cfg(not(feature = "class"))]
pub static METHODS: &[Method] = methods::STATION;

/// All methods, in documentation order.
#[cfg(feature = "class")]
pub static METHODS: &[Method] = &ALL;

#[cfg(feature = "class")]
static ALL: [Method; methods::STATION.len() + class::CLASS.len()] = {
    let mut all = [methods::STATION[0]; methods::STATION.len() + class::CLASS.len()];
    let mut at = 0;
    while at < all.len() {
        all[at] = if at < methods::STATION.len() {
            methods::STATION[at]
        } else {
            class::CLASS[at - methods::STATION.len()]
        };
        at += 1;
    }
    all
};
