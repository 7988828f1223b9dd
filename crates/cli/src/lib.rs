//! The parts of the program `mapgen`, for benchmarks and tests; see `mapgen --help` for its use.

pub mod cell;
