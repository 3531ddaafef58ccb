//! Reading whole files with a limit, text in unknown encodings, and near misses of names.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::IoError;

/// Reads a file of at most `limit_mb` megabytes, however long it claims to be.
pub(crate) fn read_bytes(
    path: &Path,
    what: &'static str,
    limit_mb: u64,
) -> Result<Vec<u8>, IoError> {
    let fail = |source| IoError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(fail)?;
    if file.metadata().map_err(fail)?.is_dir() {
        let source = std::io::Error::other(format!("it is a folder; a {what} is wanted"));
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

/// Reads a short text file.
pub fn read_text(path: &Path, what: &'static str) -> Result<String, IoError> {
    read_bytes(path, what, 1).map(|bytes| decode_text(&bytes))
}

/// Text that is UTF-8 (with or without a byte order mark) or else Latin-1.
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

/// The known name nearest to `name`, when it can be a slip of the pen.
pub(crate) fn nearest_name<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let best = known.into_iter().map(|k| (edit_distance(name, k), k)).min()?;
    (best.0 <= 1 + best.1.len() / 3).then_some(best.1)
}

fn edit_distance(a: &str, b: &str) -> usize {
    // Names longer than this are no slips, and the table stays small.
    let a: Vec<char> = a.chars().take(64).flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().take(64).flat_map(char::to_lowercase).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_and_strangers_are_not() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(nearest_name("nose_tp", ["chin", "nose_tip"]), Some("nose_tip"));
        assert_eq!(nearest_name("elbow", ["chin", "nose_tip"]), None);
    }

    #[test]
    fn text_is_utf8_or_latin1() {
        assert_eq!(decode_text("\u{feff}é".as_bytes()), "é");
        assert_eq!(decode_text(b"caf\xe9"), "café");
        assert_eq!(line_of("a\nb\nc", 4), 3);
    }

    #[test]
    fn endless_and_missing_files_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("long");
        std::fs::write(&path, vec![0u8; (1 << 20) + 1]).unwrap();
        assert!(matches!(read_bytes(&path, "file", 1), Err(IoError::TooLong { .. })));
        assert_eq!(read_bytes(&path, "file", 2).unwrap().len(), (1 << 20) + 1);
        assert!(read_bytes(dir.path(), "photo", 1).unwrap_err().to_string().contains("folder"));
        assert!(matches!(read_bytes(&dir.path().join("no"), "x", 1), Err(IoError::Read { .. })));
    }
}
