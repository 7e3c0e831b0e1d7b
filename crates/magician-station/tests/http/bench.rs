//! Station listening at a free port, and clients for HTTP and WebSocket.

use std::net::SocketAddr;
use std::sync::Arc;

use futures_util::{SinkExt, StreamExt};
use magician::{Arm, Options, SimSpeed, VirtualArm, sim::Controller};
use magician_station::http::{
    Admission, HttpOptions, Listener, Pages, ProgramFolder, RecordingFolder, Tls, TokenStore,
};
use magician_station::{ArmEntry, Role, RunningStation, StationConfig};
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::{Message, client::IntoClientRequest};

pub(crate) struct HttpStation {
    pub(crate) address: SocketAddr,
    pub(crate) tokens: TokenStore,
    pub(crate) arm: VirtualArm,
    pub(crate) station: RunningStation,
    pub(crate) over: watch::Sender<bool>,
    pub(crate) folder: TempDir,
}

impl HttpStation {
    pub(crate) async fn new() -> Self {
        Self::with(Admission::default()).await
    }

    pub(crate) async fn with(admission: Admission) -> Self {
        Self::made(admission, None).await
    }

    /// Creates a station that limits every session to a viewer.
    pub(crate) async fn read_only() -> Self {
        Self::of(Admission::default(), None, true, Pages::default()).await
    }

    pub(crate) async fn made(admission: Admission, tls: Option<Tls>) -> Self {
        Self::of(admission, tls, false, Pages::default()).await
    }

    /// Creates a station that serves a page.
    pub(crate) async fn paged(pages: Pages) -> Self {
        Self::of(Admission::default(), None, false, pages).await
    }

    async fn of(admission: Admission, tls: Option<Tls>, read_only: bool, pages: Pages) -> Self {
        let folder = TempDir::new().unwrap();
        let tokens = TokenStore::at(folder.path().join("station/tokens.toml"));
        Self::in_folder(admission, tls, read_only, pages, (folder, tokens)).await
    }

    /// Creates a station with these tokens.
    pub(crate) async fn with_tokens(tokens: TokenStore) -> Self {
        let folder = TempDir::new().unwrap();
        let (admission, pages) = (Admission::default(), Pages::default());
        Self::in_folder(admission, None, false, pages, (folder, tokens)).await
    }

    async fn in_folder(
        admission: Admission,
        tls: Option<Tls>,
        read_only: bool,
        pages: Pages,
        (folder, tokens): (TempDir, TokenStore),
    ) -> Self {
        let arm = VirtualArm::new(Controller::default(), SimSpeed::Times(20.0));
        let driver = Arm::simulated(arm.clone(), Options::default())
            .await
            .unwrap();
        let config = StationConfig {
            recordings: Arc::new(RecordingFolder::at(folder.path().join("recordings"))),
            programs: Arc::new(ProgramFolder::at(folder.path().join("programs"))),
            read_only,
            ..StationConfig::new(vec![ArmEntry::simulated("arm")], "0")
        };
        let station = RunningStation::start(config, vec![driver], Box::new(|_| {}));
        let mut listener = Listener::bind(Some("127.0.0.1:0")).await.unwrap();
        if let Some(tls) = tls {
            listener = listener.encrypted(tls);
        }
        let address = listener.addresses()[0];
        let (over, ends) = watch::channel(false);
        let options = HttpOptions {
            admission,
            pages,
            ..HttpOptions::new(tokens.clone(), "0.0.0")
        };
        tokio::spawn(listener.serve(station.clone(), options, ends));
        Self {
            address,
            tokens,
            arm,
            station,
            over,
            folder,
        }
    }

    /// Sends a request, with `{host}` replaced by the station's name, and reads the whole answer.
    pub(crate) async fn raw(&self, request: &str) -> Answer {
        let mut stream = TcpStream::connect(self.address).await.unwrap();
        let host = self.address.to_string();
        let request = request.replace("{host}", &host).replace('\n', "\r\n");
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut bytes = Vec::new();
        // If the station closes before it has read the whole request, the answer is complete as
        // well.
        let _ = stream.read_to_end(&mut bytes).await;
        Answer::of(&String::from_utf8_lossy(&bytes))
    }

    pub(crate) async fn get(&self, path: &str, headers: &str) -> Answer {
        self.raw(&format!(
            "GET {path} HTTP/1.1\nhost: {{host}}\nconnection: close\n{headers}\n"
        ))
        .await
    }

    pub(crate) async fn post(&self, path: &str, headers: &str, body: &str) -> Answer {
        let length = body.len();
        self.raw(&format!(
            "POST {path} HTTP/1.1\nhost: {{host}}\nconnection: close\ncontent-type: application/json\n\
             content-length: {length}\n{headers}\n{body}"
        ))
        .await
    }

    /// Opens a WebSocket with these headers, without a hello.
    pub(crate) async fn socket(&self, headers: &[(&'static str, &str)]) -> Result<Socket, u16> {
        let url = format!("ws://{}/api/v1/ws", self.address);
        let mut request = url.into_client_request().unwrap();
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        let stream = TcpStream::connect(self.address).await.unwrap();
        match tokio_tungstenite::client_async(request, stream).await {
            Ok((socket, _)) => Ok(Socket { socket, next: 0 }),
            Err(tokio_tungstenite::tungstenite::Error::Http(response)) => {
                Err(response.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Opens a session of this machine.
    pub(crate) async fn join(&self, name: &str) -> Socket {
        let mut socket = self.socket(&[]).await.unwrap();
        socket
            .call("session.hello", json!({"client": {"name": name}}))
            .await
            .unwrap();
        socket
    }

    pub(crate) fn token(&self, role: Role) -> String {
        self.tokens.create(None, role).unwrap().1
    }
}

/// HTTP response.
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) headers: Vec<(String, String)>,
    pub(crate) body: String,
}

impl Answer {
    fn of(text: &str) -> Self {
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((text, ""));
        let mut lines = head.lines();
        let status = lines
            .next()
            .and_then(|line| line.split(' ').nth(1)?.parse().ok());
        let headers = lines.filter_map(|line| line.split_once(": "));
        Self {
            status: status.unwrap_or(0),
            headers: headers
                .map(|(name, value)| (name.to_lowercase(), value.to_owned()))
                .collect(),
            body: body.to_owned(),
        }
    }

    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        let header = self.headers.iter().find(|(known, _)| known == name);
        header.map(|(_, value)| value.as_str())
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|_| panic!("{:?}", self.body))
    }
}

/// WebSocket client.
pub(crate) struct Socket {
    pub(crate) socket: WebSocketStream<TcpStream>,
    next: i64,
}

impl Socket {
    pub(crate) async fn send(&mut self, method: &str, params: Value) -> i64 {
        self.next += 1;
        let message =
            json!({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params});
        self.socket
            .send(Message::text(message.to_string()))
            .await
            .unwrap();
        self.next
    }

    pub(crate) async fn call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        let id = self.send(method, params).await;
        self.answer(id).await
    }

    pub(crate) async fn answer(&mut self, id: i64) -> Result<Value, Value> {
        loop {
            let message = match self.socket.next().await {
                Some(Ok(Message::Text(text))) => serde_json::from_str::<Value>(&text).unwrap(),
                Some(Ok(Message::Close(frame))) => panic!("closed: {frame:?}"),
                Some(Ok(_)) => continue,
                other => panic!("{other:?}"),
            };
            if message["id"] == json!(id) {
                return match message.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(message["result"].clone()),
                };
            }
        }
    }

    /// Subscribes until a field of the state has this value. Returns that state.
    pub(crate) async fn until(&mut self, field: &str, value: Value) -> Value {
        let made = self
            .call("arm.subscribe", json!({"rate": 50}))
            .await
            .unwrap();
        let mut state = json!({});
        while state[field] != value {
            let Some(Ok(Message::Text(text))) = self.socket.next().await else {
                continue;
            };
            let message: Value = serde_json::from_str(&text).unwrap();
            let fresh = message["method"] == "arm.state"
                && message["params"]["subscription"] == made["subscription"];
            for (name, value) in message["params"]["state"].as_object().into_iter().flatten() {
                if fresh {
                    state[name] = value.clone();
                }
            }
        }
        let subscription = json!({"subscription": made["subscription"]});
        self.call("arm.unsubscribe", subscription).await.unwrap();
        state
    }

    /// Returns the close code.
    pub(crate) async fn closed(&mut self) -> Option<u16> {
        self.closed_because().await.map(|(code, _)| code)
    }

    /// Returns the close code and the reason.
    pub(crate) async fn closed_because(&mut self) -> Option<(u16, String)> {
        loop {
            match self.socket.next().await {
                Some(Ok(Message::Close(frame))) => {
                    return frame.map(|frame| (frame.code.into(), frame.reason.to_string()));
                }
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return None,
            }
        }
    }
}
