/// Runs plain loops compiled for the widest vectors the machine has: chosen at run time, one binary
/// for all machines. Without fused multiply-add in the source the bits are equal on all of them.
///
/// Mark the closure and what it calls `#[inline(always)]`, or it stays compiled for the narrowest. A function that is
/// `#[inline(never)]` and hands its body over to this one is a call that is compiled for each instruction set, too.
#[inline(always)]
pub fn widest_vectors<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
