//! Captures: a folder with `capture.toml` and the photos it names, read and written.

mod marks;
mod new_file;
mod reader;
mod text;
mod types;
mod write;

use std::path::Path;

use super::error::IoError;
use super::source::{decode_text, read_bytes};
pub use new_file::new_capture_toml;
use reader::Reader;
use text::CaptureText;
use types::FILE_NAME;
pub use types::{CaptureFiles, LoadedCapture};
pub use write::write_capture;

/// Longest capture file, MB: a filled-in one has a few kB.
const MAX_FILE_MB: u64 = 1;

/// Reads a capture folder, or its `capture.toml`.
///
/// # Errors
/// [`IoError`] with the file, what was found and what to do.
///
/// ```
/// use facerecon_core::data::{Capture, Pattern, PatternKind, Photo, Rgb};
/// use facerecon_core::io::{read_capture, write_capture};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let folder = tempfile::tempdir()?;
/// let photo = |level| Photo::from_rgb(Rgb::filled(64, 48, [level; 3]));
/// let capture = Capture {
///     left: photo(10),
///     right: photo(20),
///     plain: None,
///     extra: Vec::new(),
///     pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
///     rig: None,
///     seeds: None,
///     landmarks: Default::default(),
/// };
/// write_capture(folder.path(), &capture)?;
/// let loaded = read_capture(folder.path())?;
/// assert_eq!(loaded.capture, capture);
/// assert!(loaded.warnings.is_empty());
/// # Ok(())
/// # }
/// ```
pub fn read_capture(path: &Path) -> Result<LoadedCapture, IoError> {
    read_capture_with(Some(path), &CaptureFiles::default())
}

/// Reads a capture of which some values are given on the command line, or all (`path` is `None`).
///
/// # Errors
/// As [`read_capture`].
pub fn read_capture_with(
    path: Option<&Path>,
    given: &CaptureFiles,
) -> Result<LoadedCapture, IoError> {
    let Some(path) = path else {
        return Reader::new(None, given, Vec::new()).read(CaptureText::default());
    };
    let file = if path.is_dir() { path.join(FILE_NAME) } else { path.to_owned() };
    if path.is_dir() && !file.exists() {
        let message = format!(
            "the folder contains no {FILE_NAME}; `facerecon new {}` writes one to fill in",
            path.display()
        );
        return Err(IoError::malformed(path, message));
    }
    let bytes = read_bytes(&file, "capture file", MAX_FILE_MB)?;
    let (text, warnings) = text::parse(&decode_text(&bytes)).map_err(|e| e.in_file(&file))?;
    Reader::new(Some(file), given, warnings).read(text)
}

#[cfg(test)]
mod tests;
