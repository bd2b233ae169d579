//! Recordings of an actuator: CSV in, checked samples out
