//! Files of a page: served as stored, revalidated, and nothing beyond them.

use magician_station::http::{PageFile, Pages};

use crate::bench::HttpStation;

const FILES: [PageFile; 2] = [
    PageFile {
        path: "/",
        kind: "text/html; charset=utf-8",
        // "<!doctype html>"
        gzip: b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\x03\xb3QL\xc9O.\xa9,HU\xc8(\xc9\xcd\xb1\x03\x00H\xec\xb9\x87\x0f\x00\x00\x00",
    },
    PageFile {
        path: "/assets/app.js",
        kind: "text/javascript; charset=utf-8",
        // "export {}"
        gzip: b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\x03K\xad(\xc8/*Q\xa8\xae\x05\x00\xfcX\xff'\x09\x00\x00\x00",
    },
];

#[tokio::test]
async fn page_is_served_with_stored_bytes() {
    let bench = HttpStation::paged(Pages::new(FILES)).await;
    let page = bench.get("/", "").await;
    assert_eq!((page.status, page.body.as_str()), (200, "<!doctype html>"));
    assert_eq!(
        page.header("content-type"),
        Some("text/html; charset=utf-8")
    );
    assert_eq!(page.header("x-magician-api"), Some("1"));
    assert_eq!(page.header("cache-control"), Some("no-cache"));
    let head = bench
        .raw("HEAD / HTTP/1.1\nhost: {host}\nconnection: close\n\n")
        .await;
    assert_eq!(
        (head.header("x-magician-api"), head.body.as_str()),
        (Some("1"), "")
    );
    let script = bench.get("/assets/app.js", "").await;
    assert_eq!(script.body, "export {}");
    assert_eq!(script.header("x-magician-api"), None);
    assert_eq!(bench.get("/assets/other.js", "").await.status, 404);
    assert_eq!(bench.get("/manifest.webmanifest", "").await.status, 404);
    assert_eq!(bench.get("/assets/../app.js", "").await.status, 404);
}

#[tokio::test]
async fn gzip_is_sent_only_if_accepted() {
    let bench = HttpStation::paged(Pages::new(FILES)).await;
    let packed = String::from_utf8_lossy(FILES[1].gzip);
    for (wanted, body, coding) in [
        ("gzip, deflate, br", &*packed, Some("gzip")),
        ("br;q=1, gzip;q=0.5", &*packed, Some("gzip")),
        ("gzip;q=0", "export {}", None),
        ("br", "export {}", None),
    ] {
        let headers = format!("accept-encoding: {wanted}\n");
        let answer = bench.get("/assets/app.js", &headers).await;
        assert_eq!(
            (answer.body.as_str(), answer.header("content-encoding")),
            (body, coding)
        );
        assert_eq!(answer.header("vary"), Some("Accept-Encoding"));
    }
}

#[tokio::test]
async fn matching_etag_gets_not_modified() {
    let bench = HttpStation::paged(Pages::new(FILES)).await;
    let first = bench.get("/assets/app.js", "").await;
    let tag = first.header("etag").unwrap();
    let known = format!("if-none-match: \"other\", {tag}\n");
    let again = bench.get("/assets/app.js", &known).await;
    assert_eq!((again.status, again.body.as_str()), (304, ""));
    assert_eq!(again.header("etag"), Some(tag));
    // The same file in another encoding has another tag.
    let zipped = format!("{known}accept-encoding: gzip\n");
    assert_eq!(bench.get("/assets/app.js", &zipped).await.status, 200);
    assert_eq!(
        bench
            .get("/assets/app.js", "if-none-match: \"other\"\n")
            .await
            .status,
        200
    );
}
