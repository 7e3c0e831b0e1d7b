//! Handlers of the routes of a station.
//!
//! Every request passes `admit_request` first, which admits it, and every response gets the same
//! security headers there. A handler then checks role and place. Each JSON-RPC request by POST has
//! a session of its own.

use std::sync::{Arc, LazyLock};

use axum::Router;
use axum::body::{Bytes, HttpBody};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{FromRequestParts, Request};
use axum::http::header::{ALLOW, CONTENT_TYPE, RETRY_AFTER, UPGRADE, VARY, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::response::{IntoResponse, Response};
use magician::admission::Origin;
use serde_json::{Value, json};
use tokio::sync::watch;

use super::options::HttpOptions;
use super::pacing::{Lane, URGENT_LENGTH, is_always_obeyed};
use super::places::Place;
use super::programs;
use super::route_table::{ROUTES, Route, RouteNeeds};
use super::security::{Admitted, ConnectionEnds, HttpRefusal};
use super::server::ApiServer;
use super::tokens::{TOKENS_UNAVAILABLE, run_blocking};
use super::{recordings, socket};
use crate::READ_BUFFER;
use crate::Role;
use crate::station::{Grant, Peer};

/// Largest body of a request, bytes.
const MAX_BODY_SIZE: usize = 1024 * 1024;
/// Hint in a refusal of an anonymous client of this machine.
const CLASS_HINT: &str = ": while a class is set, a teacher on this machine authenticates with the PIN, as `Authorization: Bearer PIN`";

/// OpenRPC document of the API, rendered once: 100 kB.
static OPENRPC: LazyLock<Bytes> = LazyLock::new(|| crate::api::openrpc().to_string().into());

/// Context of a request.
#[derive(Clone)]
struct RequestContext<S> {
    station: S,
    options: Arc<HttpOptions>,
    /// Address of the client, for the journal.
    address: String,
    ends: ConnectionEnds,
    over: watch::Receiver<bool>,
    place: Place,
}

/// Creates the service of one connection. `name` is the name in the client's certificate, if it has
/// shown one.
pub(super) fn router(
    station: impl ApiServer,
    options: Arc<HttpOptions>,
    name: Option<String>,
    (ends, over, place): (ConnectionEnds, watch::Receiver<bool>, Place),
) -> Router {
    let peer = ends.peer;
    let context = RequestContext {
        station,
        options,
        address: name.map_or_else(|| peer.to_string(), |name| format!("{peer} {name}")),
        ends,
        over,
        place,
    };
    // A single fallback instead of axum's routes: no path bypasses the checks in `admit_request`.
    Router::new().fallback(move |request: Request| admit_request(context.clone(), request))
}

/// Admits a request, finds its route, and adds the security headers to every response.
async fn admit_request<S: ApiServer>(context: RequestContext<S>, request: Request) -> Response {
    // The head is complete, so the connection no longer counts as silent, which would be evicted
    // first.
    context.place.note_head();
    context.place.pacer().turn(lane(&request)).await;
    let (parts, body) = request.into_parts();
    let admitted = context.options.admission.admit(&parts, context.ends);
    let foreign = admitted
        .as_ref()
        .ok()
        .and_then(|admitted| admitted.foreign_origin.clone());
    let mut response = match admitted {
        Err(refused) => refusal(&refused),
        Ok(_) if parts.method == Method::OPTIONS => preflight(foreign.is_some()),
        Ok(admitted) => {
            let request = Request::from_parts(parts, body);
            answer(&context, request, &admitted).await
        }
    };
    let headers = response.headers_mut();
    for (name, value) in SECURITY_HEADERS {
        headers.insert(
            HeaderName::from_static(name),
            HeaderValue::from_static(value),
        );
    }
    if let Some(origin) = foreign
        && let Ok(origin) = HeaderValue::from_str(&origin)
    {
        headers.insert("access-control-allow-origin", origin);
        headers.insert(VARY, HeaderValue::from_static("Origin"));
    }
    context.place.hold_until_sent(response)
}

/// Returns the lane of a request whose body has not been read.
fn lane(request: &Request) -> Lane {
    let may_be_urgent = request.method() == Method::POST
        && request.uri().path() == "/api/v1/rpc"
        && { request.body().size_hint().exact() }
            .is_some_and(|length| length <= URGENT_LENGTH as u64);
    if may_be_urgent {
        Lane::Urgent
    } else {
        Lane::Ordinary
    }
}

/// Security headers of every response.
const SECURITY_HEADERS: [(&str, &str); 5] = [
    (
        "content-security-policy",
        // The studio compiles WebAssembly, shows pictures from memory and sets inline styles;
        // nothing else is allowed.
        "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self' ws: wss:; \
         img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
];

fn preflight(allowed: bool) -> Response {
    if !allowed {
        return text(
            StatusCode::METHOD_NOT_ALLOWED,
            "the method is not allowed here",
        );
    }
    let mut response = StatusCode::NO_CONTENT.into_response();
    let headers = response.headers_mut();
    let methods = HeaderValue::from_static("GET, PUT, POST, DELETE");
    headers.insert("access-control-allow-methods", methods);
    let names = HeaderValue::from_static("authorization, content-type");
    headers.insert("access-control-allow-headers", names);
    response
}

async fn answer<S: ApiServer>(
    context: &RequestContext<S>,
    request: Request,
    admitted: &Admitted,
) -> Response {
    let path = request.uri().path();
    let method = match request.method() {
        &Method::HEAD => "GET",
        method => method.as_str(),
    };
    let candidates = ROUTES.iter().filter(|route| route.is_of(path));
    let candidates: Vec<_> = candidates.collect();
    let Some(route) = candidates.iter().find(|route| route.method == method) else {
        if candidates.is_empty() {
            return text(StatusCode::NOT_FOUND, "there is nothing at this address");
        }
        let allowed: Vec<_> = candidates.iter().map(|route| route.method).collect();
        let mut response = text(
            StatusCode::METHOD_NOT_ALLOWED,
            "the method is not allowed here",
        );
        if let Ok(allowed) = HeaderValue::from_str(&allowed.join(", ")) {
            response.headers_mut().insert(ALLOW, allowed);
        }
        return response;
    };
    // For HEAD axum drops the body after its length was set.
    match (route.method, route.path) {
        ("GET", "/healthz") => {
            let version = &context.options.version;
            object(
                StatusCode::OK,
                &json!({"ok": true, "version": version, "api": 1}),
            )
        }
        ("GET", "/" | "/assets/{name}" | "/manifest.webmanifest") => {
            let page = context.options.pages.answer(path, request.headers());
            page.unwrap_or_else(|| text(StatusCode::NOT_FOUND, "there is nothing at this address"))
        }
        ("GET", "/api/v1/openrpc.json") => {
            ([(CONTENT_TYPE, "application/json")], OPENRPC.clone()).into_response()
        }
        ("GET", "/api/v1/ws") => upgrade(context, request, admitted).await,
        ("POST", "/api/v1/rpc") => rpc(context, request, admitted).await,
        ("GET", "/api/v1/recordings/{name}") => recording(context, path, admitted, route).await,
        (_, "/api/v1/programs/{name}") => program(context, request, admitted, route).await,
        #[cfg(feature = "class")]
        ("GET", "/api/v1/class/results.html") => results(context, admitted, route).await,
        ("GET", "/api/v1/link") => link(context, admitted, route).await,
        // The last route of the table.
        _ => pair(context, request).await,
    }
}

/// Returns the results of the class as a page.
#[cfg(feature = "class")]
async fn results<S: ApiServer>(
    context: &RequestContext<S>,
    admitted: &Admitted,
    route: &Route,
) -> Response {
    const RESULTS_REQUEST: &str = r#"{"jsonrpc":"2.0","id":1,"method":"class.results"}"#;
    let grant = match role_for(context, admitted, route).await {
        Ok(_) => grant_for(context, admitted).await,
        Err(refused) => Err(refused),
    };
    let peer = match grant.and_then(|grant| peer(context, admitted, grant)) {
        Ok(peer) => peer,
        Err(refused) => return refusal(&refused),
    };
    let token = admitted.token.clone();
    // Calls the API method, so that the page needs the same rights and has the same content.
    let answer = context.station.call(peer, token, RESULTS_REQUEST).await;
    let page = crate::engine::run_blocking(move || {
        let answer: Value = serde_json::from_str(&answer.unwrap_or_default()).unwrap_or_default();
        match answer.get("result") {
            Some(results) => Ok(crate::class::results_page(results)),
            None => Err(answer["error"]["message"]
                .as_str()
                .unwrap_or("no answer")
                .to_owned()),
        }
    });
    match page.await {
        Ok(Ok(page)) => ([(CONTENT_TYPE, "text/html; charset=utf-8")], page).into_response(),
        Ok(Err(why)) => text(StatusCode::BAD_GATEWAY, &why),
        Err(_) => text(StatusCode::INTERNAL_SERVER_ERROR, "no page can be made"),
    }
}

/// Serves a recording.
async fn recording<S: ApiServer>(
    context: &RequestContext<S>,
    path: &str,
    admitted: &Admitted,
    route: &Route,
) -> Response {
    if let Err(refused) = role_for(context, admitted, route).await {
        return refusal(&refused);
    }
    let name = path.rsplit('/').next().unwrap_or_default().to_owned();
    let store = context.station.recordings();
    match crate::engine::run_blocking(move || store.read(&name)).await {
        Ok(Ok((file, length))) => recordings::answer(file, length),
        _ => text(StatusCode::NOT_FOUND, "there is no such recording"),
    }
}

/// Serves a program of the library.
async fn program<S: ApiServer>(
    context: &RequestContext<S>,
    request: Request,
    admitted: &Admitted,
    route: &Route,
) -> Response {
    let role = match role_for(context, admitted, route).await {
        Ok(role) => role,
        Err(refused) => return refusal(&refused),
    };
    let Some(name) = programs::name_in(request.uri().path()) else {
        let why = "a program has a name of 1 to 80 letters, digits, points, blanks, _ and -, with \
            no point first and no blank first or last";
        return text(StatusCode::BAD_REQUEST, why);
    };
    let store = context.station.programs();
    match route.method {
        "PUT" => programs::put(store, &context.options.uploads, name, role, request).await,
        "DELETE" => programs::delete(store, name).await,
        _ => programs::get(store, name).await,
    }
}

/// Returns the role of a request, if it suffices for the route.
async fn role_for<S: ApiServer>(
    context: &RequestContext<S>,
    admitted: &Admitted,
    route: &Route,
) -> Result<Role, HttpRefusal> {
    let RouteNeeds::Role(needs) = route.needs else {
        return Ok(Role::Viewer);
    };
    let grant = grant_for(context, admitted).await?;
    let role = match grant {
        Some(grant) => grant.role,
        // No token is needed on this machine.
        None if admitted.loopback => context.station.anonymous_role(),
        None => return Err(needs_token()),
    };
    let role = if context.station.is_read_only() {
        Role::Viewer
    } else {
        role
    };
    if role < needs {
        let mut why = format!("this is for the role {}, not {}", needs.name(), role.name());
        if admitted.loopback && admitted.token.is_none() {
            why.push_str(CLASS_HINT);
        }
        return Err(HttpRefusal::new(StatusCode::FORBIDDEN, why));
    }
    // Identified: the connection is no longer evicted as a stranger.
    context.place.begin();
    Ok(role)
}

/// Returns the rights of a token, or of the teacher's PIN in its place. `None` without either: then
/// the origin decides.
async fn grant_for<S: ApiServer>(
    context: &RequestContext<S>,
    admitted: &Admitted,
) -> Result<Option<Grant>, HttpRefusal> {
    let Some(token) = &admitted.token else {
        return Ok(None);
    };
    #[cfg(feature = "class")]
    if crate::class::is_pin(token) {
        let peer = peer(context, admitted, None)?;
        let tried = context.station.try_pin(token, &peer);
        tried.map_err(|error| pin_refused(&error))?;
        let (role, token) = (Role::Teacher, None);
        return Ok(Some(Grant { role, token }));
    }
    match context
        .options
        .tokens
        .granted_at(token.clone(), admitted.loopback)
        .await
    {
        Ok(Some(grant)) => Ok(Some(grant)),
        Ok(None) => Err(HttpRefusal::new(
            StatusCode::UNAUTHORIZED,
            "the token is not good",
        )),
        Err(_) => Err(HttpRefusal::new(
            StatusCode::SERVICE_UNAVAILABLE,
            TOKENS_UNAVAILABLE,
        )),
    }
}

#[cfg(feature = "class")]
fn pin_refused(error: &crate::api::RpcError) -> HttpRefusal {
    let status = match error.code {
        crate::api::RpcError::TOO_MANY => StatusCode::TOO_MANY_REQUESTS,
        // A wrong PIN, or no class.
        _ => StatusCode::UNAUTHORIZED,
    };
    HttpRefusal::new(status, error.message.clone())
}

fn needs_token() -> HttpRefusal {
    let why = "a token is needed from this address";
    HttpRefusal::new(StatusCode::UNAUTHORIZED, why)
}

fn peer<S>(
    context: &RequestContext<S>,
    admitted: &Admitted,
    grant: Option<Grant>,
) -> Result<Peer, HttpRefusal> {
    let mut peer = Peer::elsewhere(grant, context.address.clone())
        .map_err(|error| HttpRefusal::new(StatusCode::INTERNAL_SERVER_ERROR, error.to_string()))?;
    if admitted.loopback {
        // Only `security` knows what is local, so the address alone does not decide.
        peer.origin = Origin::Loopback;
    }
    Ok(peer)
}

async fn upgrade<S: ApiServer>(
    context: &RequestContext<S>,
    request: Request,
    admitted: &Admitted,
) -> Response {
    let (mut parts, _) = request.into_parts();
    // Without this header it is a person who opened the address in a browser.
    if !parts.headers.contains_key(UPGRADE) {
        let mut response = text(StatusCode::UPGRADE_REQUIRED, "this is for a WebSocket");
        response
            .headers_mut()
            .insert(UPGRADE, HeaderValue::from_static("websocket"));
        return response;
    }
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(rejection) => return rejection.into_response(),
    };
    #[cfg(feature = "class")]
    if admitted.token.as_deref().is_some_and(crate::class::is_pin) {
        let why = "a socket says the PIN in `session.hello`";
        return refusal(&HttpRefusal::new(StatusCode::UNAUTHORIZED, why));
    }
    let granted = grant_for(context, admitted).await;
    let peer = match granted.and_then(|grant| peer(context, admitted, grant)) {
        Ok(peer) => peer,
        Err(refused) => return refusal(&refused),
    };
    let upgrade = upgrade
        .protocols(["magician.v1"])
        // A message slightly above the limit is still read, so that the close code can name the
        // reason.
        .max_message_size(2 * MAX_BODY_SIZE)
        .max_frame_size(2 * MAX_BODY_SIZE)
        // Unbuffered, because the station replaces a waiting state by a newer one, which it cannot
        // do in a buffer.
        .write_buffer_size(0)
        .read_buffer_size(READ_BUFFER);
    let Some(client) = context.station.admit(peer, admitted.token.clone()).await else {
        // Browsers let a page read the code of a close, but not the reason of a failed upgrade.
        return upgrade.on_upgrade(socket::reject);
    };
    let (tokens, over) = (context.options.tokens.clone(), context.over.clone());
    let (loopback, keep_alives) = (admitted.loopback, context.options.keep_alives);
    let pacer = context.place.pacer().clone();
    upgrade.on_upgrade(move |socket| {
        socket::carry(socket, client, (tokens, loopback), keep_alives, over, pacer)
    })
}

/// Returns the report on the calls that programs written for DobotLink have made.
async fn link<S: ApiServer>(
    context: &RequestContext<S>,
    admitted: &Admitted,
    route: &Route,
) -> Response {
    if let Err(refused) = role_for(context, admitted, route).await {
        return refusal(&refused);
    }
    match &context.options.link {
        Some(link) => object(StatusCode::OK, &(link.0)()),
        None => text(
            StatusCode::NOT_FOUND,
            "no programs for DobotLink are served: --link",
        ),
    }
}

async fn rpc<S: ApiServer>(
    context: &RequestContext<S>,
    request: Request,
    admitted: &Admitted,
) -> Response {
    if !is_json(request.headers()) {
        let why = "a request is `application/json`";
        return text(StatusCode::UNSUPPORTED_MEDIA_TYPE, why);
    }
    let peer = match grant_for(context, admitted).await {
        Ok(None) if !admitted.loopback => Err(needs_token()),
        Ok(grant) => peer(context, admitted, grant),
        Err(refused) => Err(refused),
    };
    let peer = match peer {
        Ok(peer) => peer,
        Err(refused) => return refusal(&refused),
    };
    // The connection stays evictable until the body is complete, so that slow bodies cannot keep
    // the connection of a stop out.
    context.place.begin();
    let text = match body(request).await {
        Ok(text) => text,
        Err(refused) => return refusal(&refused),
    };
    if Lane::of(&text) == Lane::Ordinary {
        context.place.pacer().turn(Lane::Ordinary).await;
    }
    // Stops are carried out even if all places for requests are taken.
    if context.place.claim().is_err() && !is_always_obeyed(&text) {
        let why = "the station has as many requests as it takes";
        return self::text(StatusCode::SERVICE_UNAVAILABLE, why);
    }
    let Some(answer) = context
        .station
        .call(peer, admitted.token.clone(), &text)
        .await
    else {
        return StatusCode::NO_CONTENT.into_response();
    };
    ([(CONTENT_TYPE, "application/json")], answer).into_response()
}

async fn pair<S: ApiServer>(context: &RequestContext<S>, request: Request) -> Response {
    // Counted before anything else, so that malformed tries count too.
    if let Err(wait) = context.options.tries.count() {
        let mut response = text(StatusCode::TOO_MANY_REQUESTS, "five tries a minute: wait");
        // Rounded up, so that the next try is not early.
        let seconds = HeaderValue::from(wait.as_secs() + 1);
        response.headers_mut().insert(RETRY_AFTER, seconds);
        return response;
    }
    if !is_json(request.headers()) {
        let why = "a request is `application/json`";
        return text(StatusCode::UNSUPPORTED_MEDIA_TYPE, why);
    }
    let body_text = match body(request).await {
        Ok(text) => text,
        Err(refused) => return refusal(&refused),
    };
    let fields: Value = serde_json::from_str(&body_text).unwrap_or_default();
    let code = fields["code"].as_str().unwrap_or_default();
    let name = fields["name"].as_str().unwrap_or_default();
    let is_allowed = |letter: char| letter.is_ascii_alphanumeric() || "._- ".contains(letter);
    // The name of the token comes from a stranger and is shown to teachers.
    let name: String = name
        .chars()
        .filter(|letter| is_allowed(*letter))
        .take(32)
        .collect();
    let (code, name) = (code.to_owned(), name.trim().to_owned());
    let redeemed = run_blocking(&context.options.tokens, move |tokens| {
        tokens.redeem(&code, &name)
    });
    match redeemed.await {
        Some(Ok(Some((token, role)))) => object(
            StatusCode::OK,
            &json!({"token": token, "role": role.name()}),
        ),
        Some(Ok(None)) => refusal(&HttpRefusal::new(
            StatusCode::UNAUTHORIZED,
            "the code is not good",
        )),
        failed => {
            if let Some(Err(error)) = failed {
                tracing::warn!(%error, "no token can be made");
            }
            text(StatusCode::INTERNAL_SERVER_ERROR, "no token can be made")
        }
    }
}

fn is_json(headers: &HeaderMap) -> bool {
    let kind = headers
        .get(CONTENT_TYPE)
        .and_then(|kind| kind.to_str().ok());
    let kind = kind
        .and_then(|kind| kind.split(';').next())
        .unwrap_or_default();
    kind.trim().eq_ignore_ascii_case("application/json")
}

/// Reads the body as text, up to its limit.
async fn body(request: Request) -> Result<String, HttpRefusal> {
    let bytes = axum::body::to_bytes(request.into_body(), MAX_BODY_SIZE).await;
    let too_large =
        |_| HttpRefusal::new(StatusCode::PAYLOAD_TOO_LARGE, "a request is 1 MiB at most");
    let bytes = bytes.map_err(too_large)?;
    let no_text = |_| HttpRefusal::new(StatusCode::BAD_REQUEST, "the body is no UTF-8");
    String::from_utf8(bytes.into()).map_err(no_text)
}

fn refusal(refused: &HttpRefusal) -> Response {
    let mut response = text(refused.status, &refused.why);
    if refused.status == StatusCode::UNAUTHORIZED {
        let bearer = HeaderValue::from_static("Bearer");
        // Required with 401 (RFC 9110, 11.6.1).
        response.headers_mut().insert(WWW_AUTHENTICATE, bearer);
    }
    response
}

pub(super) fn text(status: StatusCode, why: &str) -> Response {
    let why = format!("{}\n", magician_protocol::visible(why));
    (status, [(CONTENT_TYPE, "text/plain; charset=utf-8")], why).into_response()
}

fn object(status: StatusCode, value: &Value) -> Response {
    (
        status,
        [(CONTENT_TYPE, "application/json")],
        value.to_string(),
    )
        .into_response()
}
