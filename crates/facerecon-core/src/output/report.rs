//! The report of a run: one HTML file that needs no network, with pictures, plots and the numbers
//! in words.

mod html;
pub mod marks;
mod page;
pub mod plots;
mod steps;
mod words;

pub use html::html;
pub use words::summary;
