//! Identify, tune and diagnose shape-memory-alloy actuators
