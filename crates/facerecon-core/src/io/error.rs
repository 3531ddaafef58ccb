//! Errors of files. Every message names the file, what was found and what to do.

use std::path::{Path, PathBuf};

use crate::camera::RigError;
use crate::data::MeshError;

/// A file that cannot be read, understood or written.
#[derive(Debug, thiserror::Error)]
pub enum IoError {
    /// The system cannot read it.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The system cannot write it.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file above the size limit of its kind.
    #[error(
        "{path} is longer than {limit_mb} MB, the limit for a {what}; check that it is the right file"
    )]
    TooLong {
        /// The file.
        path: PathBuf,
        /// What it should be.
        what: &'static str,
        /// The limit, MB.
        limit_mb: u64,
    },
    /// Content that is malformed or of another kind than expected.
    #[error("{path}{}: {message}", line.map_or(String::new(), |l| format!(", line {l}")))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1, where known.
        line: Option<usize>,
        /// What was found and what to do.
        message: String,
    },
    /// An image above the size limit.
    #[error(
        "{path} is {width}x{height} pixels, but at most {max_side} pixels per side and {max_megapixels} megapixels are read: scale it down"
    )]
    ImageSize {
        /// The file.
        path: PathBuf,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Largest number of columns or rows.
        max_side: u32,
        /// Largest number of pixels, millions.
        max_megapixels: u64,
    },
    /// Photos of one rig whose sizes differ.
    #[error(
        "the photos differ in size: {first} is {}x{}, {second} is {}x{}; all four photos of the pairs must have the same size",
        first_size.0, first_size.1, second_size.0, second_size.1
    )]
    PhotoSizes {
        /// One photo.
        first: PathBuf,
        /// Its width and height.
        first_size: (usize, usize),
        /// The other photo.
        second: PathBuf,
        /// Its width and height.
        second_size: (usize, usize),
    },
    /// A path in a capture file that is outside the capture's folder.
    #[error(
        "{file} names {path}, which is outside the capture's folder; copy it into the folder, or give it on the command line"
    )]
    Outside {
        /// The capture file.
        file: PathBuf,
        /// The path as written.
        path: PathBuf,
    },
    /// A rig that cannot be used.
    #[error("{path}: {source}")]
    Rig {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: RigError,
    },
    /// A mesh that cannot be used.
    #[error("{path}: {source}")]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: MeshError,
    },
    /// A file name extension of no supported format.
    #[error("{path}: unknown file name extension {found:?}; use {expected}")]
    Ending {
        /// The file.
        path: PathBuf,
        /// The extension found.
        found: String,
        /// The supported extensions.
        expected: &'static str,
    },
}

impl IoError {
    /// The file the error is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::Read { path, .. }
            | Self::Write { path, .. }
            | Self::TooLong { path, .. }
            | Self::Malformed { path, .. }
            | Self::ImageSize { path, .. }
            | Self::PhotoSizes { second: path, .. }
            | Self::Outside { path, .. }
            | Self::Rig { path, .. }
            | Self::Mesh { path, .. }
            | Self::Ending { path, .. } => path,
        }
    }

    pub(crate) fn malformed(path: &Path, message: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_owned(), line: None, message: message.into() }
    }
}

/// A fault in the content of a file; [`Fault::in_file`] adds the file's name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{message}", line.map_or(String::new(), |l| format!("line {l}: ")))]
pub struct Fault {
    /// Line, counted from 1, where known.
    pub line: Option<usize>,
    /// What was found and what to do.
    pub message: String,
}

impl Fault {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }

    pub(crate) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }

    /// The error for a file.
    pub fn in_file(self, path: &Path) -> IoError {
        IoError::Malformed { path: path.to_owned(), line: self.line, message: self.message }
    }
}
