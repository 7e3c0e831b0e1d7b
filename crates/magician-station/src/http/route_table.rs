//! Table of all routes with their requirements.

use crate::Role;

/// Requirement of a route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteNeeds {
    /// No requirement.
    Nothing,
    /// The first message on the socket decides.
    Hello,
    /// Requirement of the called method.
    Method,
    /// A pairing code.
    Code,
    /// A role.
    Role(Role),
}

/// Route of the HTTP interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Route {
    /// HTTP method. HEAD is handled like GET.
    pub method: &'static str,
    /// Path. `{name}` stands for any last segment.
    pub path: &'static str,
    /// Requirement.
    pub needs: RouteNeeds,
    /// What the route does, for the documentation.
    pub about: &'static str,
}

/// All routes.
pub static ROUTES: &[Route] = &[
    Route {
        method: "GET",
        path: "/",
        needs: RouteNeeds::Nothing,
        about: "the studio, a web page; 404 if none is served",
    },
    Route {
        method: "GET",
        path: "/assets/{name}",
        needs: RouteNeeds::Nothing,
        about: "scripts, styles and pictures of the studio, gzip-compressed if the browser accepts it",
    },
    Route {
        method: "GET",
        path: "/manifest.webmanifest",
        needs: RouteNeeds::Nothing,
        about: "web app manifest",
    },
    Route {
        method: "GET",
        path: "/healthz",
        needs: RouteNeeds::Nothing,
        about: "health check: versions of station and API",
    },
    Route {
        method: "GET",
        path: "/api/v1/ws",
        needs: RouteNeeds::Hello,
        about: "WebSocket for JSON-RPC; subprotocol `magician.v1` if offered",
    },
    Route {
        method: "POST",
        path: "/api/v1/rpc",
        needs: RouteNeeds::Method,
        about: "one JSON-RPC request; a method that needs the lease takes it for the call if it is free",
    },
    Route {
        method: "GET",
        path: "/api/v1/openrpc.json",
        needs: RouteNeeds::Nothing,
        about: "description of the API, as OpenRPC",
    },
    Route {
        method: "POST",
        path: "/api/v1/pair",
        needs: RouteNeeds::Code,
        about: "exchanges a six-digit code for a token",
    },
    Route {
        method: "GET",
        path: "/api/v1/recordings/{name}",
        needs: RouteNeeds::Role(Role::Viewer),
        about: "recording, MCAP",
    },
    Route {
        method: "PUT",
        path: "/api/v1/programs/{name}",
        needs: RouteNeeds::Role(Role::Student),
        about: "stores a program of at most 64 MiB: 201 if new, 200 if replaced",
    },
    Route {
        method: "GET",
        path: "/api/v1/programs/{name}",
        needs: RouteNeeds::Role(Role::Viewer),
        about: "content of a program",
    },
    Route {
        method: "DELETE",
        path: "/api/v1/programs/{name}",
        needs: RouteNeeds::Role(Role::Student),
        about: "deletes a program",
    },
    #[cfg(feature = "class")]
    Route {
        method: "GET",
        path: "/api/v1/class/results.html",
        needs: RouteNeeds::Role(Role::Teacher),
        about: "results of the class, as one page",
    },
    Route {
        method: "GET",
        path: "/api/v1/link",
        needs: RouteNeeds::Role(Role::Viewer),
        about: "calls of programs for DobotLink, by program; 404 if none are served",
    },
];

impl Route {
    /// True if the path belongs to this route.
    pub(super) fn is_of(&self, path: &str) -> bool {
        match self.path.strip_suffix("{name}") {
            Some(folder) => path
                .strip_prefix(folder)
                .is_some_and(|name| !name.contains('/')),
            None => self.path == path,
        }
    }
}
