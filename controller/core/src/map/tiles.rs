//! A value for every cell of a large rectangle, of which only the parts that are used take memory.

/// Cells of a tile's side.
const SIDE: usize = 16;

/// Values by cell, in tiles that come into being when something is put there; elsewhere the value is the default.
#[derive(Clone, Debug)]
pub(super) struct Tiles<T> {
    columns: usize,
    tile_columns: usize,
    tiles: Vec<Option<Box<[T; SIDE * SIDE]>>>,
}

impl<T: Copy + Default> Tiles<T> {
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        let tile_columns = columns.div_ceil(SIDE);
        Self { columns, tile_columns, tiles: vec![None; tile_columns * rows.div_ceil(SIDE)] }
    }

    pub(super) fn get(&self, cell: usize) -> T {
        let (tile, at) = self.place(cell);
        self.tiles.get(tile).and_then(Option::as_ref).map_or_else(T::default, |tile| tile[at])
    }

    pub(super) fn put(&mut self, cell: usize, value: T) {
        let (tile, at) = self.place(cell);
        if let Some(slot) = self.tiles.get_mut(tile) {
            slot.get_or_insert_with(|| Box::new([T::default(); SIDE * SIDE]))[at] = value;
        }
    }

    fn place(&self, cell: usize) -> (usize, usize) {
        let (column, row) = (cell % self.columns, cell / self.columns);
        (row / SIDE * self.tile_columns + column / SIDE, row % SIDE * SIDE + column % SIDE)
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        let used = self.tiles.iter().flatten().count();
        self.tiles.capacity() * size_of::<Option<Box<[T; SIDE * SIDE]>>>() + used * SIDE * SIDE * size_of::<T>()
    }
}

#[cfg(test)]
mod tests {
    use super::Tiles;

    #[test]
    fn only_what_is_used_takes_memory_and_every_cell_has_a_place_of_its_own() {
        let mut tiles: Tiles<u16> = Tiles::new(37, 21);
        let empty = tiles.bytes();
        assert_eq!(tiles.get(400), 0);
        tiles.put(400, 7);
        assert_eq!(tiles.bytes() - empty, 512, "one tile");
        (0..37 * 21).for_each(|cell| tiles.put(cell, cell as u16));
        assert!((0..37 * 21).all(|cell| tiles.get(cell) == cell as u16));
    }
}
