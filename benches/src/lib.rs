//! Benchmarks only; see docs/performance.md.
