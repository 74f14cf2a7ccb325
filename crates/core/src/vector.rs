//! Loops compiled for the vector registers that the machine turns out to have.

/// Does `work` with the widest vector instructions of this machine. What is called inside has to be
/// `#[inline(always)]`, the closure itself too, or it is compiled for the least machine all the same; so is a
/// closure with a loop that is handed to the likes of `Option::map_or`.
///
/// Whole numbers come out alike everywhere, and so do floating-point ones: no operations are fused.
#[inline(always)]
pub fn widest<T>(work: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(work)
}
