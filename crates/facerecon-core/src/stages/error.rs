//! What ends a stage, as the pipeline sees it.

use crate::settings::SettingsError;

/// Why a stage ended without a result.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrorKind {
    /// A parameter out of its range.
    Settings(SettingsError),
    /// The observer cancelled the run.
    Cancelled,
    /// The input cannot be processed; the error's message says why.
    Input,
}

/// An error of a stage (or of a maker such as `simulate`). The message does not name the stage:
/// [`crate::pipeline::Error`] adds [`StageError::STAGE`].
pub trait StageError: std::error::Error + Send + Sync + 'static {
    /// Name of the stage, as in parameters, timings and messages.
    const STAGE: &'static str;

    /// Why the stage ended.
    fn kind(&self) -> ErrorKind;
}

/// Implements [`StageError`] for an error enum with the variants `Settings` and `Cancelled`.
macro_rules! stage_error {
    ($error:ty, $stage:literal) => {
        impl $crate::stages::StageError for $error {
            const STAGE: &'static str = $stage;

            #[allow(unreachable_patterns)] // some stages have no further variants
            fn kind(&self) -> $crate::stages::ErrorKind {
                match self {
                    Self::Settings(error) => $crate::stages::ErrorKind::Settings(error.clone()),
                    Self::Cancelled(_) => $crate::stages::ErrorKind::Cancelled,
                    _ => $crate::stages::ErrorKind::Input,
                }
            }
        }
    };
}

pub(crate) use stage_error;
