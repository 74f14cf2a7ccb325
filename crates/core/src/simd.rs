//! Compiles loops for several sets of vector instructions, and chooses that of the machine at run time.

/// Runs `work` with the widest vector instructions of this machine. Functions called inside must be
/// `#[inline(always)]`, and so must the closure; otherwise they are compiled for the baseline machine. The same holds
/// for closures with loops that are passed to functions such as `Option::map_or`.
///
/// Results are the same on every machine, for floating-point numbers too: no operations are fused.
#[inline(always)]
pub fn dispatch<T>(work: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(work)
}
