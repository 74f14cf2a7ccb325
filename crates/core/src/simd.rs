//! Loops compiled for each set of vector instructions; the one that the machine has is chosen at run time.

/// Runs `work` with the widest vector instructions of this machine. What is called inside has to be
/// `#[inline(always)]`, the closure itself too, or it is compiled for the baseline machine; so is a
/// closure with a loop that is handed to the likes of `Option::map_or`.
///
/// Results are the same on every machine, for floating-point numbers too: no operations are fused.
#[inline(always)]
pub fn dispatch<T>(work: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(work)
}
