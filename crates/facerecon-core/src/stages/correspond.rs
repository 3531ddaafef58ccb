//! Stage correspond.
