//! Encrypted connections.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use magician_station::client::{ClientError, StationClient, Trust};
use magician_station::http::{Admission, Tls, TlsError};
use serde_json::json;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::Instant;

use crate::bench::HttpStation;

/// Creates a self-signed certificate of this machine and its key, as files.
fn certificate(folder: &Path, name: &str) -> (PathBuf, PathBuf) {
    let names = vec!["127.0.0.1".to_owned(), "localhost".to_owned()];
    let made = rcgen::generate_simple_self_signed(names).unwrap();
    let at = |what: &str| folder.join(format!("{name}.{what}.pem"));
    fs::write(at("cert"), made.cert.pem()).unwrap();
    fs::write(at("key"), made.signing_key.serialize_pem()).unwrap();
    (at("cert"), at("key"))
}

async fn encrypted(folder: &Path) -> (HttpStation, Trust) {
    let (certificate, key) = certificate(folder, "own");
    let tls = Tls::from_files(&certificate, &key).unwrap();
    let bench = HttpStation::made(Admission::default(), Some(tls)).await;
    (bench, Trust::File(certificate))
}

#[tokio::test]
async fn encrypted_client_moves_the_arm() {
    let folder = TempDir::new().unwrap();
    let (bench, trust) = encrypted(folder.path()).await;
    for host in ["127.0.0.1", "localhost"] {
        let address = format!("https://{host}:{}", bench.address.port());
        let client = StationClient::connect_trusting(&address, "Anna", None, &trust)
            .await
            .unwrap();
        assert_eq!(client.hello()["role"], json!("teacher"));
        client.call("lease.acquire", json!({})).await.unwrap();
        let moved = client.call("arm.move", json!({"to": [220, 0, 50, 0]}));
        assert_eq!(moved.await.unwrap()["x"], json!(220.0));
        let held = client.call("lease.acquire", json!({})).await.unwrap();
        let release = json!({"lease": held["lease"]});
        client.call("lease.release", release).await.unwrap();
    }
}

#[tokio::test]
async fn untrusted_certificates_and_plain_text_are_refused() {
    let folder = TempDir::new().unwrap();
    let (bench, trust) = encrypted(folder.path()).await;
    let (other, _) = certificate(folder.path(), "other");
    let address = format!("https://{}", bench.address);
    let connect = async |address: &str, trust: &Trust| {
        let client = StationClient::connect_trusting(address, "Anna", None, trust).await;
        client.unwrap_err()
    };
    let untrusted = connect(&address, &Trust::File(other)).await;
    assert!(
        matches!(&untrusted, ClientError::Untrusted(_)),
        "{untrusted}"
    );
    let missing = connect(&address, &Trust::File(folder.path().join("none"))).await;
    assert!(matches!(&missing, ClientError::Untrusted(_)), "{missing}");
    let clear = connect(&format!("http://{}", bench.address), &trust).await;
    assert!(matches!(&clear, ClientError::Unreachable(_)), "{clear}");
    let plain = HttpStation::new().await;
    let secure = connect(&format!("https://{}", plain.address), &trust).await;
    assert!(secure.to_string().contains("does not encrypt"), "{secure}");
    // Other clients are not affected.
    let good = StationClient::connect_trusting(&address, "Anna", None, &trust).await;
    assert!(good.is_ok());
}

#[tokio::test]
async fn stalled_handshakes_block_no_client() {
    let folder = TempDir::new().unwrap();
    let (bench, trust) = encrypted(folder.path()).await;
    let mut stalled = Vec::new();
    for at in 0..400 {
        let mut stream = TcpStream::connect(bench.address).await.unwrap();
        // The header of a TLS record without its content.
        if at % 2 == 0 {
            stream
                .write_all(&[0x16, 0x03, 0x01, 0x02, 0x00])
                .await
                .unwrap();
        }
        stalled.push(stream);
    }
    let address = format!("https://{}", bench.address);
    let client = StationClient::connect_trusting(&address, "Anna", None, &trust)
        .await
        .unwrap();
    client.call("arm.stop", json!({})).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn stalled_handshake_is_closed_after_5_s() {
    let folder = TempDir::new().unwrap();
    let (bench, _) = encrypted(folder.path()).await;
    let mut stream = TcpStream::connect(bench.address).await.unwrap();
    let began = Instant::now();
    let mut rest = Vec::new();
    let _ = stream.read_to_end(&mut rest).await;
    let lasted = began.elapsed();
    assert!(lasted >= Duration::from_secs(5), "{lasted:?}");
    assert!(lasted < Duration::from_secs(6), "{lasted:?}");
}

#[test]
fn mismatched_certificate_and_key_are_distinguished() {
    let folder = TempDir::new().unwrap();
    let (own, own_key) = certificate(folder.path(), "own");
    let (_, other_key) = certificate(folder.path(), "other");
    let nowhere = folder.path().join("nowhere.pem");
    let error = |certificate: &Path, key: &Path| Tls::from_files(certificate, key).unwrap_err();
    assert!(matches!(error(&nowhere, &own_key), TlsError::Read(path, _) if path == nowhere));
    assert!(matches!(error(&own, &nowhere), TlsError::Read(path, _) if path == nowhere));
    assert!(matches!(error(&own_key, &own_key), TlsError::Content(path, _) if path == own_key));
    assert!(matches!(error(&own, &own), TlsError::Content(path, _) if path == own));
    assert!(matches!(error(&own, &other_key), TlsError::NoPair(..)));
}
