//! What a robot that explores knows when it decides, and what a method of choosing is.

use super::classic::Classic;
use super::immune::Immune;
use super::sweep::Sweep;
use crate::map::{Board, Field, Known, Sight, Unknowns};
use drover_config::Explore;

/// Another robot, or oneself, as one knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mate {
    /// The cell on which it stands.
    pub at: usize,
    /// The cell to which it goes, if that is known.
    pub target: Option<usize>,
}

/// What a robot knows.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Its map, as far as it may go there.
    pub board: &'a Board,
    /// What cannot be looked through: the same map for a robot of one cell; for a body the one without its size.
    pub walls: &'a Board,
    /// Who first saw each cell, by rank; meaningless for unknown cells.
    pub finders: &'a [u16],
    /// All robots by rank; none for those it has never heard of, or that are dead.
    pub mates: &'a [Option<Mate>],
    /// Its own rank among them.
    pub own: usize,
    /// What a robot sees from where it stands.
    pub sight: &'a Sight,
    /// Steps since the start.
    pub step: u32,
}

impl View<'_> {
    /// Where it stands.
    #[must_use]
    pub fn at(&self) -> usize {
        self.mates[self.own].map_or(0, |mate| mate.at)
    }

    /// The others that it knows of, by rank.
    pub fn others(&self) -> impl Iterator<Item = (usize, Mate)> + '_ {
        let all = self.mates.iter().enumerate().filter(|(rank, _)| *rank != self.own);
        all.filter_map(|(rank, mate)| Some((rank, (*mate)?)))
    }

    /// How many robots it knows of, itself among them.
    #[must_use]
    pub fn team(&self) -> usize {
        self.mates.iter().flatten().count()
    }

    /// Every cell of the square around a cell, whether seen from there or not.
    pub fn square(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        self.board.square(cell, self.sight.reach())
    }

    /// Whether a cell cannot be looked through.
    #[must_use]
    pub fn blocks(&self, cell: usize) -> bool {
        self.walls.at(cell) == Known::Occupied
    }

    /// Unknown and occupied cells of the square around a cell.
    #[must_use]
    pub fn counts(&self, cell: usize) -> [usize; 2] {
        let known = || self.square(cell).map(|other| self.board.at(other));
        let unknown = known().filter(|known| *known == Known::Unknown).count();
        [unknown, known().filter(|known| *known == Known::Occupied).count()]
    }
}

/// A way of choosing where to go.
pub(super) trait Choose {
    /// Whether one who goes to a target chooses anew, though it is not there yet and it is still worth going to.
    fn reconsiders(&self, view: &View<'_>) -> bool;

    /// The cell to go to, any that the field reaches; none if there is nothing left. `field`: steps from where the
    /// robot stands, unknown cells taken for solid ([`Choose::unknowns`] says otherwise).
    fn choose(&mut self, view: &View<'_>, field: &Field) -> Option<usize>;

    /// Whether a target still is worth going to.
    fn still_good(&self, view: &View<'_>, target: usize) -> bool {
        view.board.is_frontier(target)
    }

    /// The field that it has made itself, which counts then; none if it works on the one that it is given.
    fn ways(&self) -> Option<&Field> {
        None
    }

    /// How ways lead through what is unknown.
    fn unknowns(&self) -> Unknowns {
        Unknowns::Solid
    }
}

/// The chooser of a method.
#[derive(Clone, Debug)]
pub(super) enum Chooser {
    Sweep(Box<Sweep>),
    Immune(Box<Immune>),
    Classic(Box<Classic>),
}

impl Chooser {
    pub(super) fn new(params: &Explore) -> Self {
        use drover_config::ExploreMethod as Method;
        match params.method {
            Method::Sweep => Self::Sweep(Box::new(Sweep::new(params))),
            Method::Inea | Method::Basic => Self::Immune(Box::new(Immune::new(params))),
            Method::Greedy
            | Method::Nearest
            | Method::Burgard
            | Method::Hungarian
            | Method::MinPos
            | Method::Market => Self::Classic(Box::new(Classic::new(params))),
        }
    }

    pub(super) fn get(&self) -> &dyn Choose {
        match self {
            Self::Sweep(chooser) => chooser.as_ref(),
            Self::Immune(chooser) => chooser.as_ref(),
            Self::Classic(chooser) => chooser.as_ref(),
        }
    }

    pub(super) fn get_mut(&mut self) -> &mut dyn Choose {
        match self {
            Self::Sweep(chooser) => chooser.as_mut(),
            Self::Immune(chooser) => chooser.as_mut(),
            Self::Classic(chooser) => chooser.as_mut(),
        }
    }
}
