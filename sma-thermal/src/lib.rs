//! Heat balance of a shape-memory-alloy rod heated by its own resistance
