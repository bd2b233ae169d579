//! Wiener model of a shape-memory-alloy actuator: drive, temperature, fraction, displacement
