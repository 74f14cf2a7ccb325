//! Work that several threads may share.
//!
//! With the feature `parallel` these are rayon's own traits and functions. Without it they are the same names
//! on one thread: each piece of work runs where it stands, in order. Both give the same results, because no
//! code of this crate lets the number of threads or the order of pieces decide a value
//! (`tests/same_bytes.rs`).

#[cfg(feature = "parallel")]
pub(crate) use rayon::{current_num_threads, current_thread_index, join, prelude, scope};

#[cfg(not(feature = "parallel"))]
pub(crate) use serial::{current_num_threads, current_thread_index, join, prelude, scope};

#[cfg(not(feature = "parallel"))]
mod serial;
