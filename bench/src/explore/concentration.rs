//! The paper's figure 5: how the mean concentration of antibodies grows, with the T cell, without it and in the network
//! that the paper compares with, on the same populations.

use drover_config::{Explore, ExploreMethod, Suppression};
use drover_core::explore::mean_concentrations;
use serde::Serialize;

/// One network.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExploreConcentration {
    /// Which.
    pub row: &'static str,
    /// The mean concentration over all populations, at the start and after each generation.
    pub mean: Vec<f64>,
}

/// The networks.
pub(super) fn networks() -> [(&'static str, Explore); 4] {
    let usual = Explore::usual;
    let basic = |suppression| Explore { suppression, ..usual(ExploreMethod::Basic) };
    [
        ("T cell (eq. 6, 8)", usual(ExploreMethod::Inea)),
        ("no T cell (eq. 6 without c)", Explore { t_cell_rate: 0.0, ..usual(ExploreMethod::Inea) }),
        ("eq. 4, repaired", basic(Suppression::Repaired)),
        ("eq. 4, as printed", basic(Suppression::Printed)),
    ]
}

/// What each does with populations of affinities and stimulations.
pub(super) fn concentrations<'p>(
    populations: impl Iterator<Item = &'p Vec<[f64; 2]>> + Clone,
) -> Vec<ExploreConcentration> {
    let of = |(row, params): (&'static str, Explore)| {
        let mut mean = Vec::new();
        let mut count = 0.0;
        for population in populations.clone() {
            let one = mean_concentrations(&params, population);
            mean.resize(one.len(), 0.0);
            mean.iter_mut().zip(one).for_each(|(sum, value)| *sum += value);
            count += 1.0;
        }
        mean.iter_mut().for_each(|sum| *sum /= count);
        ExploreConcentration { row, mean }
    };
    networks().into_iter().map(of).collect()
}
