//! Atomic writing: a file is replaced completely or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::IoError;

/// Writes `bytes` to `path`: first to a hidden temporary file in the same folder, which then
/// replaces `path`. A reader never sees a partial file, and an interrupted run leaves the old one.
/// Missing folders are created; the file is readable by all users (mode 0644).
///
/// # Errors
/// [`IoError::Write`] with the system's error.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    try_write(path, bytes).map_err(|source| IoError::Write { path: path.to_owned(), source })
}

fn try_write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if path.file_name().is_none() || path.is_dir() {
        return Err(std::io::Error::other("it is a folder; a file name is expected"));
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    std::fs::create_dir_all(&folder)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".facerecon-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o644));
    }
    let mut file = builder.tempfile_in(&folder)?;
    file.write_all(bytes)?;
    #[cfg(unix)]
    {
        // The process's umask may have removed permissions when the file was created.
        use std::os::unix::fs::PermissionsExt;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_and_no_temporary_file_remains() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b/out.txt");
        write(&path, b"first").unwrap();
        write(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o644);
        }
    }

    #[test]
    fn a_folder_of_that_name_is_an_error_that_names_it() {
        let dir = tempfile::tempdir().unwrap();
        let error = write(dir.path(), b"x").unwrap_err();
        assert!(error.to_string().contains(&dir.path().display().to_string()), "{error}");
        std::fs::write(dir.path().join("f"), b"").unwrap();
        assert!(write(&dir.path().join("f/x"), b"x").is_err());
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
