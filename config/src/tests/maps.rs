//! Grid maps: read as map_server reads them, and refused with words.

use super::shipped;
use crate::{GridMap, Problem, UnknownCells, World, check_file, load_swarm, load_world};
use proptest::prelude::*;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Words between the signs that YAML gives a meaning.
const YAML_LIKE: &str = "([a-z_]{1,6}|: |- |\\[|\\]|\\{|\\}|, |&a|\\*a|!!|\n|  |[0-9.e-]{1,4}|\\.nan|'|\"|\\||>){0,60}";

/// A folder with a world that names a map.
struct Folder(tempfile::TempDir);

const YAML: &str = "image: map.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\noccupied_thresh: 0.65\n\
                    free_thresh: 0.196\nnegate: 0\n";

impl Folder {
    fn new(yaml: &str, image: &[u8]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        std::fs::create_dir_all(folder.path("maps")).expect("made");
        std::fs::write(folder.path("maps/map.yaml"), yaml).expect("written");
        std::fs::write(folder.path("maps/map.pgm"), image).expect("written");
        std::fs::write(folder.path("world.toml"), "name = \"w\"\nmap = \"maps/map.yaml\"\n").expect("written");
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn world(&self) -> World {
        load_world(&self.path("world.toml")).unwrap_or_else(|problems| panic!("{problems}"))
    }

    /// The one problem.
    fn refused(&self) -> Problem {
        let problems = check_file(&self.path("world.toml")).expect_err("refused").0;
        let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("one problem, not {all:#?}"));
        problem
    }
}

fn map(yaml: &str, image: &[u8]) -> GridMap {
    let world = Folder::new(yaml, image).world();
    GridMap::clone(&world.map.expect("a map"))
}

/// Solid cells from the south-west on.
fn solid(yaml: &str, image: &[u8]) -> String {
    map(yaml, image).solid.iter().map(|solid| if *solid { '#' } else { '.' }).collect()
}

#[test]
fn a_map_is_read_as_map_server_reads_it() {
    let map = map(YAML, b"P2\n# by hand\n3 2\n255\n0 254 205\n254 254 100\n");
    assert_eq!((map.width, map.height, map.unknown), (3, 2, UnknownCells::Solid));
    assert_eq!((map.resolution_m, map.origin_m, map.origin_yaw_rad), (0.5, [-1.0, 2.0], 0.0));
    // The southern row comes first; 205 is just not free above 0.196, 100 neither free nor occupied.
    assert_eq!(map.solid, [false, false, true, true, false, true]);
}

#[test]
fn thresholds_negation_and_modes_are_map_servers() {
    // p of 89 is 0.651, of 90 0.647; of 204 0.2, of 206 0.192.
    let image = b"P5 4 1 255\n\x59\x5a\xcc\xce";
    assert_eq!(solid(YAML, image), "###.");
    let free = "name = \"w\"\nmap = { file = \"maps/map.yaml\", unknown = \"free\" }\n";
    let folder = Folder::new(YAML, image);
    std::fs::write(folder.path("world.toml"), free).expect("written");
    assert_eq!(folder.world().map.expect("a map").solid, [true, false, false, false]);
    assert_eq!(solid(&YAML.replace("negate: 0", "negate: 1"), b"P5 3 1 255\n\x00\xff\xa6"), ".##");
    assert_eq!(solid(&format!("{YAML}mode: scale\n"), image), "#...");
    assert_eq!(solid(&format!("{YAML}mode: trinary\nauthor: {{ name: x }}\n"), image), "###.");
    // 15 grey levels are stretched to 255.
    assert_eq!(solid(YAML, b"P2 3 1 15 0 15 7"), "#.#");
}

#[test]
fn opacity_counts_as_a_colour_in_trinary_and_alone_in_scale() {
    let image = image::RgbaImage::from_vec(3, 1, vec![0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 0]);
    let mut png = std::io::Cursor::new(Vec::new());
    image.expect("three pixels").write_to(&mut png, image::ImageFormat::Png).expect("written");
    // Opaque black is (0 + 0 + 0 + 255) / 4: occupied above 0.65; clear white is 0.25: unknown.
    assert_eq!(solid(YAML, png.get_ref()), "#.#");
    assert_eq!(solid(&format!("{YAML}mode: scale\n"), png.get_ref()), "#.#");
}

#[test]
fn a_swarm_in_a_map_is_written_so_that_it_can_be_read_from_anywhere() {
    let swarm = load_swarm(&shipped("swarms/cafe.toml"), &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("resolved.toml");
    std::fs::write(&path, swarm.to_toml()).expect("written");
    assert_eq!(load_swarm(&path, &[]).map_err(|problems| problems.to_string()), Ok(swarm));
}

#[test]
fn a_wrong_yaml_is_refused_where_it_is_wrong() {
    let cases = [
        ("resolution: 0.5", "resolution: .nan", "resolution", "NaN", "0.001..=100"),
        ("resolution: 0.5", "resolution: -0.5", "resolution", "-0.5", "0.001..=100"),
        ("resolution: 0.5", "resolution: 0", "resolution", "0", "0.001..=100"),
        ("resolution: 0.5", "resolution: half", "resolution", "\"half\"", "0.001..=100"),
        ("resolution: 0.5", "#", "resolution", "nothing", "0.001..=100"),
        ("origin: [-1.0, 2.0, 0.0]", "origin: [1, 2]", "origin", "[1, 2]", "[x, y, yaw]"),
        ("origin: [-1.0, 2.0, 0.0]", "origin: [.inf, 2, 0]", "origin", "[inf, 2, 0]", "within 10000 m"),
        ("negate: 0", "negate: 2", "negate", "2", "0 or 1"),
        ("negate: 0", "negate: 0\nmode: raw", "mode", "\"raw\"", "trinary or scale"),
        ("free_thresh: 0.196", "free_thresh: 0.7", "free_thresh", "0.7", "at most occupied_thresh"),
        ("image: map.pgm", "image: none.pgm", "image", "no readable file", "a readable file"),
        ("image: map.pgm", "image: .", "image", "no file", "a regular file"),
        ("image: map.pgm", "image: map.yaml", "image", "another format", "PGM (P2 or P5) or PNG"),
    ];
    for (old, new, key, found, allowed) in cases {
        let folder = Folder::new(&YAML.replace(old, new), b"P5 1 1 255\n\x00");
        let problem = folder.refused();
        assert!(problem.file.ends_with("map.yaml") && problem.line.is_some(), "{problem}");
        assert_eq!(problem.key, key, "{problem}");
        assert!(problem.found.contains(found) && problem.expected.contains(allowed), "{problem}");
        assert!(!problem.advice.is_empty());
    }
    for yaml in ["", "[1, 2]", "image: [", "a: b: c", "image: x\nimage: y\n", "&a [*a]", "\t"] {
        let problem = Folder::new(yaml, b"P5 1 1 255\n\x00");
        assert!(check_file(&problem.path("world.toml")).is_err());
    }
}

#[test]
fn a_wrong_image_is_refused_with_the_reason() {
    let cases: [(&[u8], &str); 7] = [
        (b"P5 2 2 255\n\x00\x00", "broken image"),
        (b"P2 2 2 255\n0 0 0", "broken image"),
        (b"P5 0 2 255\n", "0 x 2 cells"),
        (b"P5 100000 100000 255\n", "100000 x 100000 cells"),
        (b"P5 1 1 65535\n\x00\x00", "L16 pixels"),
        (b"P6 1 1 255\n\x00\x00\x00", "another format"),
        (b"", "no readable file"),
    ];
    for (image, found) in cases {
        let problem = Folder::new(YAML, image).refused();
        assert!(problem.found.contains(found), "{problem}");
        assert_eq!(problem.key, "image");
    }
    let world = Folder::new(&YAML.replace("0.5", "100"), format!("P2 300 1 255 {}", "0 ".repeat(300)).as_bytes());
    assert!(world.refused().found.contains("makes a map of 30000 m x 100 m"));
}

#[test]
fn a_map_of_ten_gigabytes_is_refused_at_once() {
    let folder = Folder::new(YAML, b"P5 100000 100000 255\n");
    let image = std::fs::OpenOptions::new().write(true).open(folder.path("maps/map.pgm")).expect("written");
    image.set_len(10_000_000_000).expect("a sparse file");
    let yaml = std::fs::File::create(folder.path("maps/huge.yaml")).expect("made");
    yaml.set_len(10_000_000_000).expect("a sparse file");
    #[expect(clippy::disallowed_methods, reason = "the test is about how long it takes")]
    let start = Instant::now();
    let problem = folder.refused();
    assert!(problem.found.contains("a file of 10000000000 bytes"), "{problem}");
    assert!(problem.advice.contains("crop the map"), "{problem}");
    std::fs::write(folder.path("world.toml"), "name = \"w\"\nmap.file = \"maps/huge.yaml\"\n").expect("written");
    let problem = folder.refused();
    assert_eq!((problem.key.as_str(), problem.line), ("map.file", Some(2)), "{problem}");
    assert!(problem.found.contains("10000000000 bytes") && problem.expected.contains("65536"), "{problem}");
    assert!(start.elapsed() < Duration::from_secs(1));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_yaml_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut yaml = YAML.as_bytes().to_vec();
        yaml.extend(&bytes);
        for yaml in [yaml, bytes] {
            let folder = Folder::new("", b"P5 1 1 255\n\x00");
            std::fs::write(folder.path("maps/map.yaml"), yaml).expect("written");
            let _ = check_file(&folder.path("world.toml")).map_err(|problems| problems.to_string());
        }
    }

    #[test]
    fn yaml_like_text_never_panics(text in YAML_LIKE) {
        let folder = Folder::new(&text, b"P5 1 1 255\n\x00");
        let _ = check_file(&folder.path("world.toml")).map_err(|problems| problems.to_string());
    }

    #[test]
    fn arbitrary_images_never_panic(
        head in prop::sample::select(vec!["", "P2 ", "P5 ", "P5 2 2 255\n", "P2 4 4 9\n", "\u{89}PNG\r\n\u{1a}\n"]),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let image: Vec<u8> = head.chars().map(|sign| sign as u8).chain(bytes).collect();
        let _ = check_file(&Folder::new(YAML, &image).path("world.toml")).map_err(|problems| problems.to_string());
    }

    #[test]
    fn a_changed_png_never_panics(at in 0_usize..80, byte in any::<u8>(), end in 8_usize..80) {
        let mut png = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(3, 2).write_to(&mut png, image::ImageFormat::Png).expect("written");
        let mut png = png.into_inner();
        let length = png.len();
        png[at % length] = byte;
        png.truncate(end);
        let _ = check_file(&Folder::new(YAML, &png).path("world.toml")).map_err(|problems| problems.to_string());
    }
}
