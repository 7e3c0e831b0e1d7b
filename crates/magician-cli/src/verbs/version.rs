//! `--version`: versions of the program, the protocol and the virtual arm's firmware.

use magician_sim::Profile;
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
    firmware_profile: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<&'static str>,
    /// Known flaw of sites in this build.
    #[serde(skip_serializing_if = "Option::is_none")]
    site_flaw: Option<&'static str>,
}

#[cfg(feature = "site")]
const SITE_FLAW: Option<&str> = magician_site::carrier::LINGER_WARNING;
#[cfg(not(feature = "site"))]
const SITE_FLAW: Option<&str> = None;

/// Prints the version.
pub(crate) fn run(context: &mut Context) -> Result<(), Failure> {
    let [major, minor, revision] = Profile::default().identity.version;
    let version = Version {
        name: "magician",
        version: env!("CARGO_PKG_VERSION"),
        protocol: PROTOCOL,
        firmware_profile: format!("magician-{major}.{minor}.{revision}"),
        commit: option_env!("MAGICIAN_COMMIT"),
        site_flaw: SITE_FLAW,
    };
    context.show(&version, |out| {
        out.line(format_args!("{} {}", version.name, version.version))?;
        version.site_flaw.map_or(Ok(()), |flaw| out.line(flaw))
    })
}
