//! The files of a page that a station serves: compressed, as they are stored, and again only where they have changed.

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

/// A file of a page.
#[derive(Clone, Copy, Debug)]
pub struct PageFile {
    /// Its path.
    pub path: &'static str,
    /// Its type.
    pub kind: &'static str,
    /// What it holds, compressed by gzip.
    pub gzip: &'static [u8],
}

impl PageFile {
    /// What it holds.
    ///
    /// # Errors
    ///
    /// Where [`gzip`](Self::gzip) is not what its name says.
    pub fn unpacked(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        GzDecoder::new(self.gzip).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// All files of a page; none where no page is served.
#[derive(Clone, Default)]
pub struct Pages(Arc<Vec<(PageFile, String)>>);

impl fmt::Debug for Pages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let paths = self.0.iter().map(|(file, _)| file.path);
        f.debug_list().entries(paths).finish()
    }
}

impl Pages {
    /// These files.
    pub fn new(files: impl IntoIterator<Item = PageFile>) -> Self {
        let tagged = files.into_iter().map(|file| {
            let digest = Sha256::digest(file.gzip);
            let digest = digest[..12].iter().map(|byte| format!("{byte:02x}"));
            (file, digest.collect())
        });
        Self(Arc::new(tagged.collect()))
    }

    /// The file at a path, as a request with these headers wants it; none where there is no such file.
    pub(super) fn answer(&self, path: &str, headers: &HeaderMap) -> Option<Response> {
        let (file, digest) = self.0.iter().find(|(file, _)| file.path == path)?;
        let zipped = takes_gzip(headers);
        let tag = format!("\"{digest}{}\"", if zipped { "-gz" } else { "" });
        let known = headers
            .get_all(IF_NONE_MATCH)
            .iter()
            .filter_map(|tags| tags.to_str().ok());
        let mut known = known.flat_map(|tags| tags.split(','));
        let mut response = if known.any(|known| known.trim().trim_start_matches("W/") == tag) {
            StatusCode::NOT_MODIFIED.into_response()
        } else if zipped {
            let gzip = [(CONTENT_ENCODING, "gzip"), (CONTENT_TYPE, file.kind)];
            (gzip, Body::from(file.gzip)).into_response()
        } else {
            // Hardly any client wants it so: it is unpacked for each that does.
            match file.unpacked() {
                Ok(bytes) => ([(CONTENT_TYPE, file.kind)], Body::from(bytes)).into_response(),
                Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
            }
        };
        let said = response.headers_mut();
        // The names are the same in every version: they are asked for again, and answered in one line.
        said.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
        said.insert(VARY, HeaderValue::from_static("Accept-Encoding"));
        if let Ok(tag) = HeaderValue::from_str(&tag) {
            said.insert(ETAG, tag);
        }
        if path == "/" {
            // So the page knows that the station is where it came from.
            said.insert("x-magician-api", HeaderValue::from_static("1"));
        }
        Some(response)
    }
}

/// Whether gzip is named and not refused.
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
