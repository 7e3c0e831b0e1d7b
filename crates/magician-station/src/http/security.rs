//! Admission of requests: host names, origins, loopback, tokens.
//!
//! A browser on this machine may be made to send requests to the station by any web page it visits.
//! Three checks prevent that: the `Host` must be one of the station's names (against DNS
//! rebinding), an `Origin` must be the station's own or allowed by name (against cross-site
//! requests), and a token is taken from a header alone. A request counts as local only if both ends
//! of its connection and its host name are loopback and no proxy has forwarded it.

use std::net::{IpAddr, SocketAddr};

use axum::http::header::{AUTHORIZATION, FORWARDED, HOST, ORIGIN};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, StatusCode};

// A proxy on this machine makes remote clients look local; these headers give it away.
static FORWARDED_FOR: HeaderName = HeaderName::from_static("x-forwarded-for");

/// Host names of the machine itself.
const LOOPBACK: [&str; 3] = ["localhost", "127.0.0.1", "[::1]"];

/// Both ends of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConnectionEnds {
    /// Local address.
    pub local: SocketAddr,
    /// Address of the client.
    pub peer: SocketAddr,
    /// True if the connection is encrypted.
    pub tls: bool,
}

/// Hosts and origins admitted besides the station's own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Admission {
    /// Further host names: `HOST` for any port, or `HOST:PORT`.
    pub hosts: Vec<String>,
    /// Further origins: `https://example.org`.
    pub origins: Vec<String>,
    /// True if clients of this machine need a token as well. Used when clients show a certificate,
    /// which proves the machine, not the user.
    pub tokens_always: bool,
}

/// Admitted request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Admitted {
    /// Bearer token, if the request has one.
    pub(crate) token: Option<String>,
    /// True if the request comes from this machine, so that it needs no token.
    pub(crate) loopback: bool,
    /// Origin that is allowed by name and has to be repeated in the answer.
    pub(crate) foreign_origin: Option<String>,
}

/// Refusal of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct HttpRefusal {
    pub(crate) status: StatusCode,
    /// Reason, sent to the client.
    pub(crate) why: String,
}

impl HttpRefusal {
    pub(super) fn new(status: StatusCode, why: impl Into<String>) -> Self {
        Self {
            status,
            why: why.into(),
        }
    }

    fn forbidden(why: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, why)
    }
}

impl Admission {
    /// Admits or refuses a request.
    pub(crate) fn admit(
        &self,
        parts: &Parts,
        ends: ConnectionEnds,
    ) -> Result<Admitted, HttpRefusal> {
        // An absolute target would make the `Host` header irrelevant.
        if parts.uri.scheme().is_some() || !parts.uri.path().starts_with('/') {
            return Err(HttpRefusal::forbidden(
                "the target of a request must be a path",
            ));
        }
        let query = parts.uri.query().unwrap_or_default();
        // URLs end up in logs and in the histories of browsers.
        if query
            .split('&')
            .any(|pair| pair.split('=').next() == Some("token"))
        {
            let why =
                "a token does not belong into an address: send it as `Authorization: Bearer TOKEN`";
            return Err(HttpRefusal::new(StatusCode::BAD_REQUEST, why));
        }
        // Several headers could be read differently by a proxy and by the station.
        let host = match texts(&parts.headers, &HOST).as_slice() {
            [Some(host)] => host.to_ascii_lowercase(),
            _ => {
                let why = "a request has one `Host` header";
                return Err(HttpRefusal::new(StatusCode::BAD_REQUEST, why));
            }
        };
        if !self.is_own(&host, ends) {
            return Err(HttpRefusal::forbidden(format!(
                "the host name {host:?} is not one of this station: --allow-host {host} allows it"
            )));
        }
        let foreign_origin = self.origin(&parts.headers, ends)?;
        let forwarded = [&FORWARDED, &FORWARDED_FOR];
        let forwarded = forwarded
            .iter()
            .any(|name| parts.headers.contains_key(*name));
        let named = split(&host).is_some_and(|(name, _)| LOOPBACK.contains(&name.as_str()));
        let near = is_loopback(ends.local) && is_loopback(ends.peer);
        let loopback = !self.tokens_always && near && named && !forwarded;
        Ok(Admitted {
            token: token(&parts.headers)?,
            loopback,
            foreign_origin,
        })
    }

    /// Checks the `Origin` header. Returns an origin that is allowed by name.
    fn origin(
        &self,
        headers: &HeaderMap,
        ends: ConnectionEnds,
    ) -> Result<Option<String>, HttpRefusal> {
        let origin = match texts(headers, &ORIGIN).as_slice() {
            [] => return Ok(None),
            [Some(origin)] => origin.to_ascii_lowercase(),
            _ => {
                return Err(HttpRefusal::forbidden(
                    "a request has at most one `Origin` header",
                ));
            }
        };
        if { self.origins.iter() }.any(|allowed| allowed.eq_ignore_ascii_case(&origin))
            // `null` is sent by sandboxed frames and files, whichever site they belong to.
            && origin != "null"
        {
            return Ok(Some(origin));
        }
        let host = { origin.strip_prefix("http://") }.or_else(|| origin.strip_prefix("https://"));
        if host.is_some_and(|host| self.is_own(host, ends)) {
            return Ok(None);
        }
        let why = format!(
            "a page of {origin:?} may not use this station: --allow-origin {origin} allows it"
        );
        Err(HttpRefusal::forbidden(why))
    }

    /// True if a lower-case host name is one of the station's at this local address.
    fn is_own(&self, host: &str, ends: ConnectionEnds) -> bool {
        let Some((name, port)) = split(host) else {
            return false;
        };
        let here = match ends.local.ip().to_canonical() {
            IpAddr::V4(address) => address.to_string(),
            IpAddr::V6(address) => format!("[{address}]"),
        };
        let own = LOOPBACK.contains(&name.as_str()) || name == here;
        let at = ends.local.port();
        let at_port = match port {
            Some(port) => port == at,
            // A host without a port means the scheme's default port.
            None => at == 80 || (ends.tls && at == 443),
        };
        own && at_port
            || self.hosts.iter().any(|allowed| {
                let allowed = split(&allowed.to_ascii_lowercase());
                allowed.is_some_and(|(allowed, only)| {
                    allowed == name && (only.is_none() || only == port)
                })
            })
    }
}

/// Returns the token of `Authorization: Bearer TOKEN`.
fn token(headers: &HeaderMap) -> Result<Option<String>, HttpRefusal> {
    let unauthorized = |why| HttpRefusal::new(StatusCode::UNAUTHORIZED, why);
    match texts(headers, &AUTHORIZATION).as_slice() {
        [] => Ok(None),
        [Some(text)] => match text.split_once(' ') {
            Some((scheme, token)) if scheme.eq_ignore_ascii_case("bearer") => {
                Ok(Some(token.trim().to_owned()))
            }
            _ => Err(unauthorized("`Authorization` must be `Bearer TOKEN`")),
        },
        _ => Err(unauthorized(
            "a request has at most one `Authorization` header",
        )),
    }
}

/// Returns all values of a header. `None` stands for a value that cannot be read as text.
fn texts(headers: &HeaderMap, name: &HeaderName) -> Vec<Option<String>> {
    let values = headers.get_all(name).iter();
    values
        .map(|value| value.to_str().ok().map(str::to_owned))
        .collect()
}

/// Splits a host into name and port: `[::1]:80`, `localhost`. `None` if the authority contains
/// anything else.
fn split(host: &str) -> Option<(String, Option<u16>)> {
    let authority: Authority = host.parse().ok()?;
    let name = authority.host();
    let port = authority.port_u16();
    // The parser accepts more than host and port, such as user information, which is refused.
    let same = match port {
        Some(port) => host == format!("{name}:{port}"),
        None => host == name,
    };
    same.then(|| (name.to_owned(), port))
}

fn is_loopback(address: SocketAddr) -> bool {
    // Canonical, because a dual-stack listener reports IPv4 peers as `::ffff:a.b.c.d`.
    address.ip().to_canonical().is_loopback()
}

#[cfg(test)]
mod tests {
    use axum::http::Request;

    use super::*;

    const HERE: &str = "127.0.0.1:8910";

    fn ends(local: &str, peer: &str) -> ConnectionEnds {
        ConnectionEnds {
            local: local.parse().unwrap(),
            peer: peer.parse().unwrap(),
            tls: false,
        }
    }

    fn admit(
        admission: &Admission,
        ends: ConnectionEnds,
        target: &str,
        headers: &[(&str, &str)],
    ) -> Result<Admitted, u16> {
        let mut request = Request::builder().uri(target);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let (parts, ()) = request.body(()).unwrap().into_parts();
        admission
            .admit(&parts, ends)
            .map_err(|refused| refused.status.as_u16())
    }

    #[test]
    fn only_local_host_names_are_admitted() {
        let admission = Admission::default();
        let local = ends(HERE, "127.0.0.1:50000");
        for (hosts, outcome) in [
            (vec!["localhost:8910"], None),
            (vec!["LocalHost:8910"], None),
            (vec!["127.0.0.1:8910"], None),
            (vec!["[::1]:8910"], None),
            (vec![], Some(400)),
            (vec!["localhost:8910", "localhost:8910"], Some(400)),
            (vec!["localhost"], Some(403)),
            (vec!["localhost:8911"], Some(403)),
            (vec!["localhost.:8910"], Some(403)),
            (vec!["127.0.0.2:8910"], Some(403)),
            (vec!["evil.example:8910"], Some(403)),
            (vec!["localhost:8910.evil.example"], Some(403)),
            (vec!["localhost:08910"], Some(403)),
            (vec!["localhost:"], Some(403)),
            (vec!["me@localhost:8910"], Some(403)),
            (vec!["::1"], Some(403)),
            (vec![""], Some(403)),
        ] {
            let headers: Vec<_> = hosts.iter().map(|host| ("host", *host)).collect();
            let admitted = admit(&admission, local, "/", &headers);
            assert_eq!(admitted.clone().err(), outcome, "{hosts:?}");
            assert!(admitted.is_err() || admitted.unwrap().loopback, "{hosts:?}");
        }
        let port_80 = ends("127.0.0.1:80", "127.0.0.1:50000");
        assert!(admit(&admission, port_80, "/", &[("host", "localhost")]).is_ok());
        assert_eq!(
            admit(&admission, local, "/", &[("host", "localhost:80")]),
            Err(403)
        );
        // A dual-stack listener reports IPv4 addresses in this form.
        let mapped = ends("[::ffff:192.168.1.5]:8910", "[::ffff:192.168.1.9]:50000");
        let host = [("host", "192.168.1.5:8910")];
        assert!(!admit(&admission, mapped, "/", &host).unwrap().loopback);
        let lan = ends("192.168.1.5:8910", "192.168.1.9:50000");
        let admitted = admit(&admission, lan, "/", &[("host", "192.168.1.5:8910")]).unwrap();
        assert!(!admitted.loopback);
        assert_eq!(
            admit(&admission, lan, "/", &[("host", "192.168.1.6:8910")]),
            Err(403)
        );
    }

    #[test]
    fn host_without_port_uses_the_default_port() {
        let admission = Admission::default();
        for (port, tls, taken) in [
            (80, false, true),
            (443, true, true),
            (443, false, false),
            (8910, true, false),
        ] {
            let mut ends = ends(&format!("127.0.0.1:{port}"), "127.0.0.1:50000");
            ends.tls = tls;
            let admitted = admit(&admission, ends, "/", &[("host", "localhost")]);
            assert_eq!(admitted.is_ok(), taken, "{port} {tls}");
        }
    }

    #[test]
    fn loopback_requires_local_ends_and_no_proxy() {
        let admission = Admission {
            hosts: vec!["arm.example".into()],
            ..Admission::default()
        };
        let local = ends(HERE, "127.0.0.1:50000");
        let loopback =
            |headers: &[(&str, &str)]| admit(&admission, local, "/", headers).unwrap().loopback;
        assert!(loopback(&[("host", "localhost:8910")]));
        assert!(!loopback(&[
            ("host", "localhost:8910"),
            ("x-forwarded-for", "1.2.3.4")
        ]));
        assert!(!loopback(&[
            ("host", "localhost:8910"),
            ("forwarded", "for=1.2.3.4")
        ]));
        assert!(!loopback(&[("host", "arm.example")]));
        let strict = Admission {
            tokens_always: true,
            ..Admission::default()
        };
        for host in ["localhost:8910", "127.0.0.1:8910", "[::1]:8910"] {
            let admitted = admit(&strict, local, "/", &[("host", host)]).unwrap();
            assert!(!admitted.loopback, "{host}");
        }
        let far = ends(HERE, "192.168.1.9:50000");
        assert!(
            !admit(&admission, far, "/", &[("host", "localhost:8910")])
                .unwrap()
                .loopback
        );
    }

    #[test]
    fn only_own_or_listed_origins_are_admitted() {
        let admission = Admission {
            hosts: vec!["arm.example:443".into()],
            origins: vec!["https://lessons.example".into(), "null".into()],
            ..Admission::default()
        };
        let local = ends(HERE, "127.0.0.1:50000");
        for (origin, outcome) in [
            ("http://localhost:8910", Ok(None)),
            ("https://127.0.0.1:8910", Ok(None)),
            ("https://arm.example:443", Ok(None)),
            (
                "https://lessons.example",
                Ok(Some("https://lessons.example".to_owned())),
            ),
            ("https://lessons.example.evil", Err(403)),
            ("http://evil.example", Err(403)),
            ("null", Err(403)),
            ("file://", Err(403)),
            ("ftp://localhost:8910", Err(403)),
        ] {
            let headers = [("host", "localhost:8910"), ("origin", origin)];
            let admitted = admit(&admission, local, "/", &headers);
            assert_eq!(
                admitted.map(|admitted| admitted.foreign_origin),
                outcome,
                "{origin}"
            );
        }
        let two = [
            ("host", "localhost:8910"),
            ("origin", "http://localhost:8910"),
            ("origin", "http://localhost:8910"),
        ];
        assert_eq!(admit(&admission, local, "/", &two), Err(403));
    }

    #[test]
    fn token_is_accepted_in_a_header_only() {
        let admission = Admission::default();
        let local = ends(HERE, "127.0.0.1:50000");
        let host = ("host", "localhost:8910");
        assert_eq!(
            admit(&admission, local, "/api/v1/ws?token=abc", &[host]),
            Err(400)
        );
        assert_eq!(
            admit(&admission, local, "/?a=b&token=abc", &[host]),
            Err(400)
        );
        let admitted = admit(
            &admission,
            local,
            "/",
            &[host, ("authorization", "bearer abc")],
        );
        assert_eq!(admitted.unwrap().token.as_deref(), Some("abc"));
        assert_eq!(
            admit(
                &admission,
                local,
                "/",
                &[host, ("authorization", "Basic abc")]
            ),
            Err(401)
        );
        assert_eq!(
            admit(&admission, local, "http://localhost:8910/", &[host]),
            Err(403)
        );
    }
}
