//! A place as cells: solid where the middle of a cell is in a wall, with a rim of solid cells around it.

/// The truth, which robots do not know.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    columns: usize,
    rows: usize,
    solid: Vec<bool>,
    reachable: usize,
}

impl Ground {
    /// Cells by what is solid at a column and a row; those at the rim are. `from` is a cell from which all others count
    /// as reachable.
    pub(crate) fn new(
        (columns, rows): (usize, usize),
        is_solid: impl Fn(usize, usize) -> bool,
        from: impl Fn(&Self) -> Option<usize>,
    ) -> Self {
        let rim = |column, row| column == 0 || row == 0 || column + 1 == columns || row + 1 == rows;
        let cells = (0..columns * rows).map(|cell| (cell % columns, cell / columns));
        let solid = cells.map(|(column, row)| rim(column, row) || is_solid(column, row)).collect();
        let mut ground = Self { columns, rows, solid, reachable: 0 };
        ground.reachable = from(&ground).map_or(0, |start| ground.reach(start));
        ground
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn is_solid(&self, cell: usize) -> bool {
        self.solid[cell]
    }

    pub(crate) fn reachable_count(&self) -> usize {
        self.reachable
    }

    /// How many cells can be reached, by steps that cut no corner.
    fn reach(&self, start: usize) -> usize {
        let mut board = drover_core::map::Board::new(self.columns, self.rows);
        for (cell, solid) in self.solid.iter().enumerate() {
            let known = if *solid { drover_core::map::Known::Occupied } else { drover_core::map::Known::Free };
            board.learn(cell, known);
        }
        let mut field = drover_core::map::Field::default();
        field.spread(&board, start, drover_core::map::Unknowns::Solid);
        field.reached().len()
    }
}
