//! What a run leaves on disk: result folders, reports, batches.

pub mod batch;
mod number_tables;
mod record;
pub mod report;
mod result_files;

pub use record::{Kept, Record, Recorder};
pub use result_files::{
    STAGES_FOLDER, match_rows, matches_table, registration_json, result_json, write_result,
};
