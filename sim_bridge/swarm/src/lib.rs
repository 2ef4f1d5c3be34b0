//! A whole swarm in one place: robots, world and what lies between, in real or virtual time.
