//! Files of a page: sent compressed as they are stored, with an entity tag so that unchanged files
//! are not sent again.

use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;

use axum::body::Body;
use axum::http::header::{
    ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, ETAG, IF_NONE_MATCH, VARY,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use flate2::read::GzDecoder;
use sha2::{Digest, Sha256};

/// File of a page.
#[derive(Clone, Copy, Debug)]
pub struct PageFile {
    /// Path in the URL.
    pub path: &'static str,
    /// MIME type.
    pub kind: &'static str,
    /// Content, compressed with gzip.
    pub gzip: &'static [u8],
}

impl PageFile {
    /// Returns the uncompressed content.
    ///
    /// # Errors
    /// If [`gzip`](Self::gzip) is not valid gzip data.
    pub fn unpacked(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        GzDecoder::new(self.gzip).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// All files of a page. Empty if no page is served.
#[derive(Clone, Default)]
pub struct Pages(Arc<Vec<(PageFile, String)>>);

impl fmt::Debug for Pages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let paths = self.0.iter().map(|(file, _)| file.path);
        f.debug_list().entries(paths).finish()
    }
}

impl Pages {
    /// Creates the set and computes the entity tags.
    pub fn new(files: impl IntoIterator<Item = PageFile>) -> Self {
        let tagged = files.into_iter().map(|file| {
            // 12 bytes of the digest suffice to distinguish versions of a file.
            let digest = Sha256::digest(file.gzip);
            let digest = digest[..12].iter().map(|byte| format!("{byte:02x}"));
            (file, digest.collect())
        });
        Self(Arc::new(tagged.collect()))
    }

    /// Returns the response for a path. `None` if there is no such file.
    pub(super) fn answer(&self, path: &str, headers: &HeaderMap) -> Option<Response> {
        let (file, digest) = self.0.iter().find(|(file, _)| file.path == path)?;
        let zipped = takes_gzip(headers);
        // Compressed and uncompressed bytes need different strong tags (RFC 9110, 8.8.3).
        let tag = format!("\"{digest}{}\"", if zipped { "-gz" } else { "" });
        let known = headers
            .get_all(IF_NONE_MATCH)
            .iter()
            .filter_map(|tags| tags.to_str().ok());
        let mut known = known.flat_map(|tags| tags.split(','));
        // `If-None-Match` compares weakly (RFC 9110, 13.1.2).
        let mut response = if known.any(|known| known.trim().trim_start_matches("W/") == tag) {
            StatusCode::NOT_MODIFIED.into_response()
        } else if zipped {
            let gzip = [(CONTENT_ENCODING, "gzip"), (CONTENT_TYPE, file.kind)];
            (gzip, Body::from(file.gzip)).into_response()
        } else {
            // Rare: every browser accepts gzip. So nothing is cached uncompressed.
            match file.unpacked() {
                Ok(bytes) => ([(CONTENT_TYPE, file.kind)], Body::from(bytes)).into_response(),
                Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
            }
        };
        let response_headers = response.headers_mut();
        // File names are the same in every version, so the browser must revalidate; that costs one
        // short answer.
        response_headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
        // A shared cache must not give compressed bytes to a client that cannot read them.
        response_headers.insert(VARY, HeaderValue::from_static("Accept-Encoding"));
        if let Ok(tag) = HeaderValue::from_str(&tag) {
            response_headers.insert(ETAG, tag);
        }
        if path == "/" {
            // Tells the page that it was loaded from its station.
            response_headers.insert("x-magician-api", HeaderValue::from_static("1"));
        }
        Some(response)
    }
}

/// True if the client accepts gzip.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let wanted = headers.get_all(ACCEPT_ENCODING).iter();
    let wanted = wanted.filter_map(|wanted| wanted.to_str().ok());
    let mut wanted = wanted.flat_map(|wanted| wanted.split(','));
    wanted.any(|coding| {
        let (name, weight) = coding.split_once(';').unwrap_or((coding, "q=1"));
        let weight = weight.trim().trim_start_matches("q=").parse::<f32>();
        name.trim().eq_ignore_ascii_case("gzip") && weight.is_ok_and(|weight| weight > 0.0)
    })
}
