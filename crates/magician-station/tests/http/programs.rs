//! Library of programs over HTTP: atomic uploads, roles, and names.

use std::fs;

use magician_station::http::Admission;
use magician_station::{LibraryQuotas, MAX_PROGRAM_SIZE, Role};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::bench::{Answer, HttpStation};

async fn request(
    bench: &HttpStation,
    method: &str,
    name: &str,
    headers: &str,
    body: &str,
) -> Answer {
    let length = body.len();
    let line = format!("{method} /api/v1/programs/{name} HTTP/1.1\n");
    let head = format!(
        "{line}host: {{host}}\nconnection: close\ncontent-length: {length}\n{headers}\n{body}"
    );
    bench.raw(&head).await
}

fn files(bench: &HttpStation) -> Vec<String> {
    let folder = bench.folder.path().join("programs");
    let items = fs::read_dir(folder).into_iter().flatten();
    let names = items.map(|item| item.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

#[tokio::test]
async fn program_is_uploaded_downloaded_and_deleted() {
    let bench = HttpStation::new().await;
    let name = "house%202.svg";
    assert_eq!(request(&bench, "GET", name, "", "").await.status, 404);
    assert_eq!(request(&bench, "PUT", name, "", "<svg/>").await.status, 201);
    assert_eq!(
        request(&bench, "PUT", name, "", "<svg />").await.status,
        200
    );
    let given = request(&bench, "GET", name, "", "").await;
    assert_eq!((given.status, given.body.as_str()), (200, "<svg />"));
    assert_eq!(given.header("content-length"), Some("7"));
    assert_eq!(
        given.header("content-type"),
        Some("application/octet-stream")
    );
    assert_eq!(given.header("x-content-type-options"), Some("nosniff"));
    let head = request(&bench, "HEAD", name, "", "").await;
    assert_eq!((head.status, head.body.as_str()), (200, ""));
    assert_eq!(files(&bench), ["house 2.svg"]);
    let mut anna = bench.join("Anna").await;
    let list = anna.call("program.list", json!({})).await.unwrap();
    assert_eq!(list["programs"][0]["name"], json!("house 2.svg"));
    assert_eq!(list["programs"][0]["format"], json!("svg"));
    let info = anna.call("server.info", json!({})).await.unwrap();
    assert!(info["programs"].as_str().unwrap().ends_with("programs"));
    assert_eq!(request(&bench, "DELETE", name, "", "").await.status, 204);
    assert_eq!(request(&bench, "DELETE", name, "", "").await.status, 404);
    let wrong = request(&bench, "PATCH", name, "", "").await;
    assert_eq!(wrong.status, 405);
    assert_eq!(wrong.header("allow"), Some("PUT, GET, DELETE"));
    assert!(files(&bench).is_empty());
}

#[tokio::test]
async fn library_limits_programs_and_bytes() {
    let bench = HttpStation::new().await;
    let most = LibraryQuotas::default().all;
    let folder = bench.folder.path().join("programs");
    fs::create_dir_all(&folder).unwrap();
    for number in 1..most.programs {
        fs::write(folder.join(number.to_string()), "x").unwrap();
    }
    let mut anna = bench.join("Anna").await;
    let put = |name: &str| json!({"name": name, "text": "xx"});
    assert_eq!(request(&bench, "PUT", "last", "", "xx").await.status, 201);
    let refused = request(&bench, "PUT", "more", "", "xx").await;
    assert_eq!(refused.status, 413, "{}", refused.body);
    assert!(refused.body.contains("1000 programs"), "{}", refused.body);
    let refused = anna.call("program.put", put("more")).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("invalid-input"), "{refused}");
    // Replacing needs no further place, and removing frees one.
    assert_eq!(
        request(&bench, "PUT", "last", "", "longer").await.status,
        200
    );
    assert_eq!(request(&bench, "DELETE", "1", "", "").await.status, 204);
    assert_eq!(request(&bench, "PUT", "more", "", "xx").await.status, 201);
    // Sparse files take no disk but count with their length.
    let large = fs::File::create(folder.join("2")).unwrap();
    large.set_len(most.bytes).unwrap();
    assert_eq!(
        request(&bench, "PUT", "last", "", "much longer")
            .await
            .status,
        413
    );
    assert_eq!(
        request(&bench, "PUT", "last", "", "short").await.status,
        200
    );
    let refused = anna.call("program.put", put("3")).await.unwrap_err();
    assert_eq!(refused["data"]["kind"], json!("invalid-input"), "{refused}");
    assert_eq!(files(&bench).len(), most.programs);
}

/// Students' programs leave room for a teacher. A refusal is sent before the bytes.
#[tokio::test]
async fn students_are_limited_to_their_quota() {
    let bench = HttpStation::new().await;
    let quotas = LibraryQuotas::default();
    let folder = bench.folder.path().join("programs");
    fs::create_dir_all(&folder).unwrap();
    // Seventeen sparse files, as one student had stored them.
    let piece = 60 << 20;
    for number in 0..quotas.students.bytes / piece {
        let file = fs::File::create(folder.join(format!("of student {number}"))).unwrap();
        file.set_len(piece).unwrap();
    }
    let token = bench.token(Role::Student);
    let student = format!("authorization: Bearer {token}\n");
    let mib = |count: u64| count << 20;
    // The body is never sent: the answer depends on the declared length alone.
    let announce = async |headers: &str, length: u64| {
        let head = format!(
            "PUT /api/v1/programs/more HTTP/1.1\nhost: {{host}}\nconnection: close\nexpect: 100-continue\n\
             content-length: {length}\n{headers}\n"
        );
        bench.raw(&head).await
    };
    let refused = announce(&student, mib(60)).await;
    assert_eq!(refused.status, 413, "{}", refused.body);
    let told = "students may fill 750 of the 1000 programs and 768 of the 1024 MiB of the library, and 12 with 720.0 MiB \
        are used";
    assert!(refused.body.starts_with(told), "{}", refused.body);
    let refused = announce("", mib(65)).await;
    assert_eq!(refused.status, 413, "{}", refused.body);
    assert!(refused.body.contains("64 MiB at most"), "{}", refused.body);
    // A client that sends everything before it reads gets the same answer.
    let much = "x".repeat(50 << 20);
    let refused = request(&bench, "PUT", "more", &student, &much).await;
    assert_eq!(refused.status, 413, "{}", refused.body);
    // Without a length the upload is refused as soon as it is too large.
    let chunk = "10000\n".to_owned() + &"x".repeat(1 << 16) + "\n";
    let head = format!(
        "PUT /api/v1/programs/more HTTP/1.1\nhost: {{host}}\nconnection: close\n{student}transfer-encoding: chunked\n\n"
    );
    let refused = bench.raw(&(head + &chunk.repeat(16 * 50) + "0\n\n")).await;
    assert_eq!(refused.status, 413, "{}", refused.body);
    assert!(!folder.join("more").exists());
    assert_eq!(
        request(&bench, "PUT", "little", &student, "x").await.status,
        201
    );
    // Teachers may use the last quarter.
    assert_eq!(request(&bench, "PUT", "more", "", &much).await.status, 201);
    let refused = bench.socket(&[]).await;
    let mut page = refused.unwrap();
    let hello = json!({"client": {"name": "page"}, "token": token});
    page.call("session.hello", hello).await.unwrap();
    let put = json!({"name": "mine", "text": "x"});
    let refused = page.call("program.put", put.clone()).await.unwrap_err();
    let data = &refused["data"];
    assert_eq!(data["kind"], json!("invalid-input"), "{refused}");
    assert_eq!(data["quota"], json!({"programs": 750, "bytes": mib(768)}));
    assert_eq!(data["used"]["programs"], json!(14));
    assert!(
        bench
            .join("Anna")
            .await
            .call("program.put", put)
            .await
            .is_ok()
    );
}

#[tokio::test]
async fn program_names_cannot_escape_the_folder() {
    let bench = HttpStation::new().await;
    let secret = bench.folder.path().join("secret");
    fs::write(&secret, "secret").unwrap();
    let long = "x".repeat(81);
    for name in [
        "",
        ".",
        "..",
        ".hidden",
        ".part-1-0",
        "%2e%2e",
        "..%2fsecret",
        "%2e%2e%2fsecret",
        "..%5csecret",
        "a%2fb",
        "a%00",
        "a%0a",
        "%20a",
        "a%20",
        "%c3%a4.svg",
        "%ff",
        "%zz",
        "%2",
        "%",
        "a+b",
        "a%25",
        "a:b",
        &long,
    ] {
        for method in ["GET", "PUT", "DELETE"] {
            let answer = request(&bench, method, name, "", "").await;
            assert_eq!(answer.status, 400, "{method} {name:?}");
        }
    }
    for path in [
        "../secret",
        "../../secret",
        "a/b",
        "a/",
        "%2e%2e/secret",
        "./../../secret",
    ] {
        for method in ["GET", "PUT", "DELETE"] {
            let answer = request(&bench, method, path, "", "").await;
            assert!([400, 404].contains(&answer.status), "{method} {path}");
        }
    }
    assert_eq!(fs::read(&secret).unwrap(), b"secret");
    assert!(files(&bench).is_empty());
    let longest = "x".repeat(80);
    assert_eq!(request(&bench, "PUT", &longest, "", "").await.status, 201);
}

#[tokio::test]
async fn library_methods_require_their_role() {
    let bench = HttpStation::new().await;
    // (method, viewer, student, teacher), with the program already stored.
    for (method, expected) in [
        ("GET", [200, 200, 200]),
        ("PUT", [403, 200, 200]),
        ("DELETE", [403, 204, 204]),
    ] {
        let roles = [Role::Viewer, Role::Student, Role::Teacher];
        for (role, expected) in roles.into_iter().zip(expected) {
            request(&bench, "PUT", "a", "", "x").await;
            let token = bench.token(role);
            let headers = format!("x-forwarded-for: 1.2.3.4\nauthorization: Bearer {token}\n");
            let answer = request(&bench, method, "a", &headers, "").await;
            assert_eq!(answer.status, expected, "{method} {}", role.name());
        }
        request(&bench, "PUT", "a", "", "x").await;
        let none = request(&bench, method, "a", "x-forwarded-for: 1.2.3.4\n", "").await;
        assert_eq!(none.status, 401);
        assert_eq!(none.header("www-authenticate"), Some("Bearer"));
        let wrong = request(&bench, method, "a", "authorization: Bearer no\n", "").await;
        assert_eq!(wrong.status, 401);
    }
    let bench = HttpStation::read_only().await;
    assert_eq!(request(&bench, "PUT", "a", "", "x").await.status, 403);
    assert_eq!(request(&bench, "GET", "a", "", "").await.status, 404);
    let origin = "https://lessons.example";
    let admission = Admission {
        origins: vec![origin.to_owned()],
        ..Admission::default()
    };
    let bench = HttpStation::with(admission).await;
    let foreign = request(&bench, "PUT", "a", "origin: https://evil.example\n", "x").await;
    assert_eq!(foreign.status, 403);
    let named = request(&bench, "PUT", "a", &format!("origin: {origin}\n"), "x").await;
    assert_eq!(named.status, 201);
    assert_eq!(named.header("access-control-allow-origin"), Some(origin));
}

/// Sends the head of a PUT and this many bytes in pieces. Returns the answer, if any.
async fn push(bench: &HttpStation, head: &str, bytes: u64, chunked: bool) -> String {
    let mut stream = TcpStream::connect(bench.address).await.unwrap();
    let host = bench.address;
    let head = format!(
        "PUT /api/v1/programs/big HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n{head}\r\n"
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    let (mut from, mut to) = stream.split();
    let send = async move {
        let piece = vec![b'x'; 1 << 20];
        let mut left = bytes;
        while left > 0 {
            let count = left.min(piece.len() as u64);
            left -= count;
            let mut whole = Vec::new();
            if chunked {
                whole.extend_from_slice(format!("{count:x}\r\n").as_bytes());
            }
            whole.extend_from_slice(&piece[..count as usize]);
            if chunked {
                whole.extend_from_slice(b"\r\n");
            }
            // The station may have closed the connection.
            if to.write_all(&whole).await.is_err() {
                return;
            }
        }
        if chunked {
            let _ = to.write_all(b"0\r\n\r\n").await;
        } else {
            let _ = to.shutdown().await;
        }
    };
    let mut answer = Vec::new();
    let read = from.read_to_end(&mut answer);
    let _ = tokio::join!(send, read);
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn upload_above_64_mib_or_incomplete_is_refused() {
    let bench = HttpStation::new().await;
    assert_eq!(request(&bench, "PUT", "big", "", "old").await.status, 201);
    let length = |length: u64| format!("content-length: {length}\r\n");
    // A declared length that is too large is refused without the body.
    let answer = push(&bench, &length(MAX_PROGRAM_SIZE + 1), 0, false).await;
    assert!(answer.starts_with("HTTP/1.1 413"), "{answer}");
    // Without a declared length.
    let chunked = "transfer-encoding: chunked\r\n";
    let answer = push(&bench, chunked, MAX_PROGRAM_SIZE + 1, true).await;
    assert!(
        answer.is_empty() || answer.starts_with("HTTP/1.1 413"),
        "{answer}"
    );
    // The client disconnects half way.
    push(&bench, &length(1000), 500, false).await;
    assert_eq!(request(&bench, "GET", "big", "", "").await.body, "old");
    while files(&bench) != ["big"] {
        tokio::task::yield_now().await;
    }
    let answer = push(&bench, chunked, MAX_PROGRAM_SIZE, true).await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    let kept = bench.folder.path().join("programs/big");
    assert_eq!(fs::metadata(kept).unwrap().len(), MAX_PROGRAM_SIZE);
    let given = request(&bench, "GET", "big", "", "").await;
    assert_eq!(given.body.len() as u64, MAX_PROGRAM_SIZE);
}
