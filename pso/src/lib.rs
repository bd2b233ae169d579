//! Particle swarm optimizer: ask/tell, reproducible, resumable
