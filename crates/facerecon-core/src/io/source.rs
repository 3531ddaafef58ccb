//! Reading files up to a size limit, text in unknown encodings, and files named by other files.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::IoError;

/// Longest text file that [`read_text`] reads, MB; parameter files have a few kB.
const MAX_TEXT_MB: u64 = 1;

/// Reads a file of at most `limit_mb` megabytes. At most that many are read, also from a file whose
/// length the system does not know. `what` names the kind of file in errors.
pub(crate) fn read_bytes(
    path: &Path,
    what: &'static str,
    limit_mb: u64,
) -> Result<Vec<u8>, IoError> {
    let fail = |source| IoError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(fail)?;
    if file.metadata().map_err(fail)?.is_dir() {
        let source = std::io::Error::other(format!("it is a folder; a {what} is expected"));
        return Err(fail(source));
    }
    let limit = limit_mb << 20;
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit {
        return Err(IoError::TooLong { path: path.to_owned(), what, limit_mb });
    }
    Ok(bytes)
}

/// Reads a text file of at most 1 MB; `what` names the kind of file in errors.
///
/// # Errors
/// [`IoError::Read`] or [`IoError::TooLong`].
pub fn read_text(path: &Path, what: &'static str) -> Result<String, IoError> {
    read_bytes(path, what, MAX_TEXT_MB).map(|bytes| decode_text(&bytes))
}

/// Text in UTF-8 (with or without a byte order mark), or else in Latin-1.
pub(crate) fn decode_text(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// The line, counted from 1, of a byte offset.
pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    let end = offset.min(text.len());
    text.as_bytes().get(..end).map_or(1, |head| 1 + head.iter().filter(|&&b| b == b'\n').count())
}

/// A file that another file in `folder` names: by the path as written, or by its file name alone,
/// since many programs write paths of the author's machine.
pub(super) fn find_beside(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or_default();
    [name.as_str(), last]
        .iter()
        .filter(|n| !n.is_empty())
        .map(|n| folder.join(n))
        .find(|p| p.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_utf8_or_latin1() {
        assert_eq!(decode_text("\u{feff}é".as_bytes()), "é");
        assert_eq!(decode_text(b"caf\xe9"), "café");
        assert_eq!(line_of("a\nb\nc", 4), 3);
    }

    #[test]
    fn long_and_missing_files_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("long");
        std::fs::write(&path, vec![0u8; (1 << 20) + 1]).unwrap();
        assert!(matches!(read_bytes(&path, "file", 1), Err(IoError::TooLong { .. })));
        assert_eq!(read_bytes(&path, "file", 2).unwrap().len(), (1 << 20) + 1);
        assert!(read_bytes(dir.path(), "photo", 1).unwrap_err().to_string().contains("folder"));
        assert!(matches!(read_bytes(&dir.path().join("no"), "x", 1), Err(IoError::Read { .. })));
    }
}
