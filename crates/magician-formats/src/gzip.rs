//! Files packed with gzip (`.svgz`).

use magician_host::message;
use std::borrow::Cow;
use std::io::Read;

use flate2::read::MultiGzDecoder;

use crate::Diagnostic;
use crate::formats::content::GZIP_MAGIC;

/// Unpacks a gzip file of at most `largest` bytes. Other bytes are returned as they are.
pub(crate) fn unpack(bytes: &[u8], largest: usize) -> Result<Cow<'_, [u8]>, Diagnostic> {
    if !bytes.starts_with(&GZIP_MAGIC) {
        return Ok(bytes.into());
    }
    let mut unpacked = Vec::new();
    MultiGzDecoder::new(bytes)
        // Reading one byte above the limit shows that the file exceeds it, whatever its full size.
        .take(largest as u64 + 1)
        .read_to_end(&mut unpacked)
        .map_err(|error| {
            Diagnostic::of_file(message!(
                "it is compressed (gzip) and damaged: {error}",
                error = error.to_string()
            ))
        })?;
    if unpacked.len() > largest {
        let message = message!(
            "uncompressed it has more than {largest} bytes, the limit",
            largest
        );
        return Err(Diagnostic::of_file(message));
    }
    Ok(unpacked.into())
}
