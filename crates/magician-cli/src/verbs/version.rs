use serde::Serialize;

use crate::context::Context;
use crate::failure::Failure;

/// Issue of the vendor's document that the command table follows.
const PROTOCOL: &str = "V1.1.3";

#[derive(Serialize)]
struct Version {
    name: &'static str,
    version: &'static str,
    protocol: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<&'static str>,
}

/// Prints the version.
pub(crate) fn run(context: &mut Context) -> Result<(), Failure> {
    let version = Version {
        name: "magician",
        version: env!("CARGO_PKG_VERSION"),
        protocol: PROTOCOL,
        commit: option_env!("MAGICIAN_COMMIT"),
    };
    context.show(&version, |out| {
        out.line(format_args!("{} {}", version.name, version.version))
    })
}
