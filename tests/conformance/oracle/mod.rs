//! What the stages should give: float64, from the formulas, sharing nothing with the core but the types of its inputs.

pub mod geometry;
pub mod ground;
pub mod image;
pub mod numbers;
