//! Why a command failed, and its exit code.

use facerecon_core::Error;

/// Why a command failed.
pub(crate) enum Failure {
    /// The input could not be read or reconstructed: exit code 1.
    Input(Error),
    /// Wrong usage of the command: exit code 2.
    Usage(String),
}

impl Failure {
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::Usage(message.into())
    }

    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Input(error) if error.is_usage() => 2,
            Self::Input(_) => 1,
            Self::Usage(_) => 2,
        }
    }
}

impl<E: Into<Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
