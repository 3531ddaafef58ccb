//! The top error: which stage or file failed, and what to do next.

use crate::io::IoError;
use crate::render::RenderError;
use crate::settings::SettingsError;
use crate::stages::{ErrorKind, StageError};
use crate::template::TemplateError;

/// Anything that ends a run. The message names the stage, or the file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A stage (or a maker such as `simulate`) could not do its work.
    #[error("{stage}: {source}")]
    Stage {
        /// Name of the stage.
        stage: &'static str,
        /// Whether its observer cancelled it.
        cancelled: bool,
        /// The stage's own error; [`Error::stage_error`] gives it back in its type.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A parameter that cannot be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A file that cannot be read, understood or written.
    #[error(transparent)]
    File(#[from] IoError),
    /// A template that cannot be used.
    #[error(transparent)]
    Template(#[from] TemplateError),
    /// A picture that cannot be drawn.
    #[error("render: {0}")]
    Render(#[from] RenderError),
    /// Something else the input lacks.
    #[error("{0}")]
    Input(String),
}

impl<E: StageError> From<E> for Error {
    fn from(error: E) -> Self {
        match error.kind() {
            ErrorKind::Settings(settings) => Self::Settings(settings),
            kind => Self::Stage {
                stage: E::STAGE,
                cancelled: kind == ErrorKind::Cancelled,
                source: Box::new(error),
            },
        }
    }
}

impl Error {
    /// The error of one stage in its own type, for example `error.stage_error::<DetectError>()`.
    pub fn stage_error<E: StageError>(&self) -> Option<&E> {
        match self {
            Self::Stage { source, .. } => source.downcast_ref(),
            _ => None,
        }
    }

    /// Whether the call is wrong, not the input.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Settings(_))
    }

    /// Name of the stage that failed, or `"file"`, `"parameters"`, `"template"`, `"render"`,
    /// `"input"`.
    pub fn stage(&self) -> &'static str {
        match self {
            Self::Stage { stage, .. } => stage,
            Self::File(_) => "file",
            Self::Settings(_) => "parameters",
            Self::Template(_) => "template",
            Self::Render(_) => "render",
            Self::Input(_) => "input",
        }
    }

    /// Whether the observer cancelled the run.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Stage { cancelled: true, .. })
    }

    /// What to try next, beyond what the message says.
    pub fn hint(&self) -> Option<&'static str> {
        match self.stage() {
            "parameters" => Some("`facerecon params` lists every parameter with its meaning"),
            "detect" | "correspond" | "filter" => {
                Some("`facerecon check CAPTURE` says what the photographs lack")
            }
            "register" | "deform" | "surface" => {
                Some("`--keep-stages` writes what each stage made, to see where it goes wrong")
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::{Cancelled, Observer};
    use crate::stages::correspond::CorrespondError;
    use crate::stages::register::RegisterError;

    struct Stop;
    impl Observer for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }

    #[test]
    fn a_message_names_its_stage_once() {
        let own: Error = CorrespondError::NoDots { photo: "left" }.into();
        assert!(
            own.to_string().starts_with("correspond: no dots were found in the left photo"),
            "{own}"
        );
        assert!(own.stage_error::<CorrespondError>().is_some());
        assert!(own.stage_error::<RegisterError>().is_none());
        let bare: Error = RegisterError::Degenerate.into();
        assert!(bare.to_string().starts_with("register: the measured points"), "{bare}");
    }

    #[test]
    fn a_cancelled_stage_and_a_wrong_parameter_are_told_apart() {
        let stopped: Result<(), RegisterError> = Stop.check().map_err(Into::into);
        let stopped: Error = stopped.unwrap_err().into();
        assert!(stopped.is_cancelled() && !stopped.is_usage());
        assert_eq!(stopped.to_string(), format!("register: {Cancelled}"));
        let wrong: Error =
            RegisterError::from(SettingsError::Malformed("register.x".into())).into();
        assert!(wrong.is_usage() && !wrong.is_cancelled());
    }
}
