//! The immune network: which of a population of candidates has the greatest stimulus in the end (eq. 4, 6 to 8).
//!
//! An antibody i has an affinity g_i and a stimulation m_i (eq. 14 gives it one index). Each generation, from the state
//! of the one before, S = s = 1/2 at first:
//!
//! ```text
//! improved (eq. 6)  S_i += (alpha m_i mean(s) + beta g_i - c_i - k) s_i       c_i = delta (1 - g_i) S_i   (eq. 8)
//! basic    (eq. 4)  S_i += (alpha m_i mean(s) - alpha mean(m s) + beta g_i - k) s_i
//! printed  (eq. 4)  the two sums are the same and cancel
//!          (eq. 7)  s_i = 1 / (1 + exp(1/2 - S_i))
//! ```
//!
//! The winner has the greatest S, not the greatest s, which is 1 for many. With eq. 8 the best affinity, 1 after
//! normalising, is never held back and grows without limit; every other one tends to
//! S* = (alpha m mean(s) + beta g - k) / (delta (1 - g)). So the winner is known without a generation
//! ([`closed_form`]).

use drover_config::{Explore, ExploreMethod, Suppression};

/// At first.
const START: f64 = 0.5;
/// Keeps the closed form finite at g = 1; chosen so that it names the winner of 40 generations.
const CLOSED_FLOOR: f64 = 0.05;

/// One candidate in the network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Antibody {
    pub(super) affinity: f64,
    pub(super) stimulation: f64,
}

/// What holds antibodies back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Restraint {
    /// The T cell (eq. 8).
    TCell,
    /// Each other (eq. 4).
    Others(Suppression),
}

impl Restraint {
    /// What the method has.
    pub(super) fn of(params: &Explore) -> Self {
        match params.method {
            ExploreMethod::Basic => Self::Others(params.suppression),
            _ => Self::TCell,
        }
    }
}

/// The parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Network {
    generations: u32,
    stimulation_rate: f64,
    antigen_rate: f64,
    death_rate: f64,
    t_cell_rate: f64,
    restraint: Restraint,
}

impl Network {
    pub(super) fn new(params: &Explore, restraint: Restraint) -> Self {
        Self {
            generations: params.generations,
            stimulation_rate: params.stimulation_rate,
            antigen_rate: params.antigen_rate,
            death_rate: params.death_rate,
            t_cell_rate: params.t_cell_rate,
            restraint,
        }
    }

    /// Which of them wins; the first of several.
    pub(super) fn winner(&self, antibodies: &[Antibody]) -> Option<usize> {
        let mut stimulus = vec![START; antibodies.len()];
        let mut concentration = vec![START; antibodies.len()];
        for _ in 0..self.generations {
            self.generation(antibodies, &mut stimulus, &mut concentration);
        }
        greatest(stimulus.into_iter())
    }

    fn generation(&self, antibodies: &[Antibody], stimulus: &mut [f64], concentration: &mut [f64]) {
        let count = antibodies.len().max(1) as f64;
        let mean = concentration.iter().sum::<f64>() / count;
        let pairs = || antibodies.iter().zip(concentration.iter());
        let mean_of_others = pairs().map(|(body, share)| body.stimulation * share).sum::<f64>() / count;
        for ((body, stimulus), concentration) in antibodies.iter().zip(stimulus).zip(concentration) {
            let held = match self.restraint {
                Restraint::TCell => self.t_cell_rate * (1.0 - body.affinity) * *stimulus,
                Restraint::Others(Suppression::Repaired) => self.stimulation_rate * mean_of_others,
                Restraint::Others(Suppression::Printed) => self.stimulation_rate * body.stimulation * mean,
            };
            let stimulated = self.stimulation_rate * body.stimulation * mean;
            let rate = stimulated + self.antigen_rate * body.affinity - held - self.death_rate;
            *stimulus += rate * *concentration;
            *concentration = 1.0 / (1.0 + libm::exp(START - *stimulus));
        }
    }
}

/// The mean concentration of a population at the start and after every generation: the paper's figure 5. Each antibody
/// is an affinity over the best one, 0 to 1, and a stimulation (eq. 14). `t_cell_rate = 0` leaves the T cell out.
#[must_use]
pub fn mean_concentrations(params: &Explore, antibodies: &[[f64; 2]]) -> Vec<f64> {
    let bodies = antibodies.iter().map(|[affinity, stimulation]| (*affinity, *stimulation));
    let bodies: Vec<Antibody> = bodies.map(|(affinity, stimulation)| Antibody { affinity, stimulation }).collect();
    let network = Network::new(params, Restraint::of(params));
    let mut stimulus = vec![START; bodies.len()];
    let mut concentration = vec![START; bodies.len()];
    let mut means = vec![START];
    for _ in 0..params.generations {
        network.generation(&bodies, &mut stimulus, &mut concentration);
        means.push(concentration.iter().sum::<f64>() / concentration.len().max(1) as f64);
    }
    means
}

/// The winner of the improved network without a generation, for affinities over the best.
pub(super) fn closed_form(antibodies: &[Antibody]) -> Option<usize> {
    greatest(antibodies.iter().map(|body| body.stimulation / (1.0 - body.affinity + CLOSED_FLOOR)))
}

fn greatest(values: impl Iterator<Item = f64>) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (index, value) in values.enumerate() {
        if best.is_none_or(|(_, best)| value > best) {
            best = Some((index, value));
        }
    }
    best.map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A share from 0 to 1, one after the other.
    fn shares(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// A hundred antibodies as they come in a run: few are near the best affinity, m is between 1.2 and 10.6.
    fn population(seed: u64) -> Vec<Antibody> {
        let mut share = shares(seed);
        let mut bodies: Vec<Antibody> =
            (0..100).map(|_| Antibody { affinity: share(), stimulation: 1.2 + 9.4 * share() }).collect();
        let best = bodies.iter().map(|body| body.affinity).fold(0.0, f64::max);
        bodies.iter_mut().for_each(|body| body.affinity /= best);
        bodies
    }

    #[test]
    fn forty_generations_choose_an_affinity_near_the_best_and_the_closed_form_mostly_the_same() {
        let network = Network::new(&Explore::usual(ExploreMethod::Inea), Restraint::TCell);
        let mut same = 0;
        for seed in 0..300 {
            let bodies = population(seed);
            let winner = network.winner(&bodies).unwrap();
            assert!(bodies[winner].affinity > 0.9, "seed {seed}: {:?}", bodies[winner]);
            same += usize::from(closed_form(&bodies) == Some(winner));
        }
        assert!(same >= 270, "{same} of 300");
    }

    #[test]
    fn suppression_as_printed_leaves_the_affinity_alone() {
        let printed = Restraint::Others(Suppression::Printed);
        let network = Network::new(&Explore::usual(ExploreMethod::Basic), printed);
        for seed in 0..50 {
            let bodies = population(seed);
            let best = greatest(bodies.iter().map(|body| body.affinity));
            assert_eq!(network.winner(&bodies), best, "seed {seed}");
        }
    }

    #[test]
    fn concentrations_rise_faster_with_the_improved_equation_than_with_the_printed_one() {
        let bodies: Vec<[f64; 2]> = population(7).iter().map(|body| [body.affinity, body.stimulation]).collect();
        let improved = mean_concentrations(&Explore::usual(ExploreMethod::Inea), &bodies);
        let printed = Explore { suppression: Suppression::Printed, ..Explore::usual(ExploreMethod::Basic) };
        let printed = mean_concentrations(&printed, &bodies);
        assert_eq!((improved.len(), printed.len()), (41, 41));
        assert!((improved[0] - START).abs() < 1e-12 && improved[10] > 0.75, "{improved:?}");
        assert!(printed.iter().zip(&improved).skip(1).all(|(printed, improved)| printed < improved), "{printed:?}");
    }

    #[test]
    fn nobody_wins_among_none() {
        let network = Network::new(&Explore::usual(ExploreMethod::Inea), Restraint::TCell);
        assert_eq!((network.winner(&[]), closed_form(&[])), (None, None));
    }
}
