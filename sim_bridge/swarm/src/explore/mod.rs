//! Exploration on cells: the paper's robots and ground, and what any exploration is measured by.

mod apart;
mod cells;
mod figures;
mod ground;
mod survey;
mod swarm;

#[cfg(test)]
mod tests;

pub use figures::ExploreFigures;
pub use survey::SurveyFigures;
pub(crate) use survey::Surveying;
pub use swarm::CellSwarm;
