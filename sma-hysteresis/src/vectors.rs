/// Runs plain loops compiled for the widest vectors the machine has, if there is a way to ask which these are. Without
/// fused multiply-add in the source the bits are equal on all of them.
///
/// Mark the closure and what it calls `#[inline(always)]`, or it stays compiled for the narrowest.
#[cfg(feature = "std")]
#[inline(always)]
pub(crate) fn widest_vectors<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs plain loops as compiled, because without `std` the machine's vectors cannot be asked for.
#[cfg(not(feature = "std"))]
#[inline(always)]
pub(crate) fn widest_vectors<R>(work: impl FnOnce() -> R) -> R {
    work()
}
