//! Hysteresis of a shape-memory alloy: limiting loop, proximity function, reversal memory
