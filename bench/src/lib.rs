//! The measured comparisons behind drover bench.
