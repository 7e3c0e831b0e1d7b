//! The API as text: messages, errors, and the table of methods.

mod error;
mod examples;
mod fields;
mod ids;
mod link;
mod message;
mod method;
mod methods;
mod openrpc;
mod param;

pub(crate) use error::Danger;
pub use error::RpcError;
pub use examples::Example;
pub(crate) use fields::encode;
pub use ids::{ERROR_IDS, IdKind, IdPlace, NOTIFICATIONS, Notification, each_id};
pub use message::{BadMessage, Message, MessageId, answer, notification};
pub use method::{Method, Needs, Role};
pub use methods::METHODS;
pub use openrpc::openrpc;
pub use param::{Kind, Param, Params};
