//! A map as ROS' map_server and Nav2 read it: a YAML file beside a PGM image (Nav2, `nav2_map_server`, trinary mode).
//!
//! Dark is occupied. The image's first row is the northernmost; the origin in the YAML is the south-west corner of the
//! south-west cell, in metres of the world frame.

use super::{Board, Known, Lattice};

/// What map_saver writes for occupied, free and unknown, and what map_server reads back as these with the thresholds
/// below: (255 - value) / 255 is 1, 0.004 and 0.196.
const OCCUPIED: u8 = 0;
const FREE: u8 = 254;
const UNKNOWN: u8 = 205;

/// The two files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapImage {
    /// The YAML file.
    pub yaml: String,
    /// The image.
    pub pgm: Vec<u8>,
}

impl MapImage {
    /// What is known of a lattice's cells; `image` is the name of the image's file.
    #[must_use]
    pub fn new(lattice: &Lattice, board: &Board, image: &str) -> Self {
        let low_w = lattice.low_w();
        // Debug writes a decimal point into every number: map_server's YAML reader takes 0 for an integer.
        let yaml = format!(
            "image: {image}\nmode: trinary\nresolution: {:?}\norigin: [{:?}, {:?}, 0.0]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n",
            lattice.cell_m(),
            low_w.x,
            low_w.y
        );
        let (columns, rows) = (lattice.columns(), lattice.rows());
        let mut pgm = format!("P5\n{columns} {rows}\n255\n").into_bytes();
        let value = |cell: usize| match board.at(cell) {
            Known::Occupied => OCCUPIED,
            Known::Free => FREE,
            Known::Unknown => UNKNOWN,
        };
        for row in (0..rows).rev() {
            pgm.extend((row * columns..(row + 1) * columns).map(value));
        }
        Self { yaml, pgm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_config::{UnknownCells, load_world};
    use drover_contract::Vec2;

    #[test]
    fn what_is_written_is_read_back_as_a_world() {
        let lattice = Lattice::over(Vec2::new(-1.0, 2.0), Vec2::new(0.5, 3.0), 0.5);
        let mut board = Board::new(3, 2);
        [(0, Known::Occupied), (1, Known::Free), (4, Known::Occupied), (5, Known::Free)].into_iter().for_each(
            |(cell, known)| {
                board.learn(cell, known);
            },
        );
        let image = MapImage::new(&lattice, &board, "map.pgm");
        let folder = std::env::temp_dir().join(format!("drover-map-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for such files");
        std::fs::write(folder.join("map.yaml"), &image.yaml).expect("written");
        std::fs::write(folder.join("map.pgm"), &image.pgm).expect("written");
        let read = |unknown: &str| {
            let text = format!("name = \"w\"\nmap = {{ file = \"map.yaml\", unknown = \"{unknown}\" }}\n");
            std::fs::write(folder.join("world.toml"), text).expect("written");
            let world = load_world(&folder.join("world.toml")).unwrap_or_else(|problems| panic!("{problems}"));
            world.map.expect("a map")
        };
        let map = read("free");
        assert_eq!((map.width, map.height, map.resolution_m, map.origin_m), (3, 2, 0.5, [-1.0, 2.0]));
        assert_eq!(map.solid, [true, false, false, false, true, false], "the south-west cell first");
        let map = read("solid");
        assert_eq!(map.unknown, UnknownCells::Solid);
        assert_eq!(map.solid, [true, false, true, true, true, false], "what nobody knows is no floor");
        let _ = std::fs::remove_dir_all(&folder);
    }
}
