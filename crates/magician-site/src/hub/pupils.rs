//! Pupils sign in at all stations of a site, of which one has to know them.

use magician::ErrorKind;
use magician_station::CloseCode;
use magician_station::api::{Method, Role, RpcError};
use serde_json::{Map, Value, json};

use super::requests::Call;
use super::socket::{Wants, Way};
use super::{Hub, HubAct, SocketId};

impl Hub {
    /// A pupil signs in: at all stations, of which one has to know the pupil.
    pub(super) fn sign_in(&mut self, call: Call) -> Result<Option<Value>, RpcError> {
        let (now, socket) = (call.now, call.socket);
        let hello = Method::named("session.hello").map_or(&[][..], |method| method.params);
        magician_station::api::Params::check(hello, call.params.clone())?;
        let Some(open) = self.sockets.get_mut(&socket) else {
            return Ok(None);
        };
        if open.session.is_some() || open.signing.is_some() {
            return Err(RpcError::request("`session.hello` came already"));
        }
        if self.stations.is_empty() {
            let why = "no station of the site can be reached: try again";
            return Err(RpcError::arm(ErrorKind::Port, why));
        }
        open.pupil = call.params.get("pupil").cloned();
        open.signing = Some((call, None));
        open.ways.clear();
        for station in self.stations.keys().copied().collect::<Vec<_>>() {
            let _ = self.line_to(now, socket, station);
        }
        Ok(None)
    }

    /// The session of a pupil whose page comes back.
    pub(super) fn comes_back(
        &self,
        hello: &Map<String, Value>,
        pupil: Option<&Value>,
    ) -> Option<String> {
        let secret = hello.get("resume")?.as_str()?;
        let name = pupil?.get("name")?.as_str()?.to_lowercase();
        let is = |person: &super::Person| {
            let known = person.pupil.as_ref().map(|known| known.to_lowercase());
            person.secret == secret && known.as_ref() == Some(&name)
        };
        let mut people = self.people.iter();
        let (session, _) = people.find(|(_, person)| is(person))?;
        Some(session.clone())
    }

    /// A station has let the pupil in: so does the hub's own.
    pub(super) fn pupil_is_in(&mut self, socket: SocketId) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        let Some((mut call, _)) = open.signing.take() else {
            return;
        };
        let pupil = open.pupil.clone();
        let name = pupil.as_ref().and_then(|pupil| pupil["name"].as_str());
        let name = name.unwrap_or_default().to_owned();
        if self.comes_back(&call.params, pupil.as_ref()).is_none() {
            call.params.remove("resume");
        }
        call.params.remove("pupil");
        call.params.insert("token".to_owned(), json!("pupil"));
        if let Some(client) = call.params.get_mut("client")
            && client.is_object()
        {
            client["name"] = json!(name);
        }
        self.acts.push_back(HubAct::Vouch(socket));
        // Lines are opened meanwhile, and may be: home says no more than what the session is called.
        if let Some(open) = self.sockets.get_mut(&socket) {
            open.role = Role::Student;
        }
        self.ask_home(&call, Wants::Hello(name, None));
    }

    /// A line of a pupil was not opened, or is lost: if all stations refuse the pupil, so does the hub.
    pub(super) fn pupil_is_refused(&mut self, socket: SocketId, why: RpcError) {
        let Some(open) = self.sockets.get_mut(&socket) else {
            return;
        };
        if open.pupil.is_none() {
            return;
        }
        let refuses =
            |why: &RpcError| [RpcError::FORBIDDEN, RpcError::TOO_MANY].contains(&why.code);
        let hopes = |way: &Way| matches!(way, Way::Line(_));
        if let Some((_, worst)) = &mut open.signing {
            // What a person can do something about.
            if worst.as_ref().is_none_or(|worst| !refuses(worst)) {
                *worst = Some(why);
            }
            if open.ways.values().any(hopes) {
                return;
            }
            let Some((call, why)) = open.signing.take() else {
                return;
            };
            let why =
                why.unwrap_or_else(|| RpcError::new(RpcError::INTERNAL, "no station has answered"));
            let (refused, id) = (refuses(&why), call.id.clone());
            open.pupil = None;
            open.ways.clear();
            self.respond(socket, id.as_ref(), &Err(why));
            if refused {
                self.home_closes(socket, CloseCode::TOKEN);
            }
        } else if open.session.is_some()
            && open.ways.values().all(|way| matches!(way, Way::Closed(_)))
        {
            // The code is not good any more.
            self.home_closes(socket, CloseCode::REVOKED);
        }
    }

    /// The sessions that a client has at stations are its own.
    pub(super) fn has_sessions(&mut self, socket: SocketId) {
        let session = { self.sockets.get(&socket) }.and_then(|open| open.session.clone());
        let Some(session) = session else {
            return;
        };
        let lines = self.lines.values().filter(|line| line.socket == socket);
        for line in lines {
            let Some((secret, there)) = &line.session else {
                continue;
            };
            self.names.is_own(line.slot, there, &session);
            if let Some(person) = self.people.get_mut(&session) {
                let at = (secret.clone(), there.clone());
                person.at.insert(line.station, at);
            }
        }
    }
}
