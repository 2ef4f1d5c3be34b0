//! Grid maps in the format of ROS' map_server: a YAML file beside an image.
//!
//! The YAML says how a pixel becomes free, occupied or unknown, as map_server 1.17 and nav2 read it: with `v` the mean
//! of a pixel's channels, `p = (255 - v) / 255` (`v / 255` if `negate`); occupied if `p > occupied_thresh`, free if
//! `p < free_thresh`, else unknown. Here an occupied cell is solid, and an unknown one is what `world.map.unknown`
//! says.

mod header;
mod pixels;

use crate::reader::{FILE, Table};
use crate::report::Words;
use crate::source::{Source, read_text_up_to};
use crate::{GridMap, UnknownCells};
use header::Header;
use std::path::{Path, PathBuf};

/// Greatest YAML file, bytes: a real one has about 150.
const YAML_BYTES_MAX: u64 = 1 << 16;

/// Reads `world.map`: `file` and `unknown`, and the files that stand behind them.
pub(crate) fn read(table: &mut Table<'_>) -> Option<GridMap> {
    let file = table.text("file", &FILE, None);
    let unknown = table.choice("unknown", &["solid", "free"]).map(|index| match index {
        0 => UnknownCells::Solid,
        _ => UnknownCells::Free,
    });
    let (file, unknown) = (file?, unknown?);
    let (source, header) = read_header(table, &file)?;
    let (report, at) = table.report_at("file");
    let Some(name) = absolute(&report.source(at.source).folder.join(&file)) else {
        let words =
            Words::new(format!("{file:?}"), "a path in UTF-8", "rename the folder: recordings must name the map");
        table.problem("file", words);
        return None;
    };
    let path = report.source(source).folder.join(&header.image);
    let pixels = match pixels::read(&path, &header) {
        Ok(pixels) => pixels,
        Err(words) => {
            header.problem(report, source, "image", words);
            return None;
        }
    };
    let solid = match unknown {
        UnknownCells::Solid => pixels.cells.iter().map(|cell| *cell != pixels::Cell::Free).collect(),
        UnknownCells::Free => pixels.cells.iter().map(|cell| *cell == pixels::Cell::Occupied).collect(),
    };
    let size_m = [pixels.width, pixels.height].map(|cells| cells as f64 * header.resolution_m);
    if size_m.iter().any(|side_m| *side_m > SIDE_M_MAX) {
        let found = format!("{}, which makes a map of {} m x {} m", header.resolution_m, size_m[0], size_m[1]);
        let words = Words::new(found, format!("at most {SIDE_M_MAX} m to each side"), "write metres per cell");
        header.problem(report, source, "resolution", words);
        return None;
    }
    Some(GridMap {
        file: name,
        unknown,
        resolution_m: header.resolution_m,
        origin_m: header.origin_m,
        origin_yaw_rad: header.origin_yaw_rad,
        width: pixels.width,
        height: pixels.height,
        solid,
    })
}

/// Longest side of a map, metres: as far as coordinates go.
const SIDE_M_MAX: f64 = 2.0 * crate::reader::COORDINATE_M_MAX;

/// The YAML file's source and what it says.
fn read_header(table: &mut Table<'_>, file: &str) -> Option<(usize, Header)> {
    let (report, at) = table.report_at("file");
    let path = report.source(at.source).folder.join(file);
    match read_text_up_to(&path, YAML_BYTES_MAX) {
        Ok(text) => {
            let source = report.add(Source::file(&path, text));
            Some((source, Header::read(report, source)?))
        }
        Err(error) => {
            let found = format!("{file:?}, which is {}", error.found);
            let advice = "name the map's YAML file, which names the image";
            let words = Words::new(found, error.expected, format!("{advice} ({})", path.display()));
            table.problem("file", words);
            None
        }
    }
}

/// The path from the root, so that a recording can be read from any folder.
fn absolute(path: &Path) -> Option<String> {
    let whole: PathBuf = std::fs::canonicalize(path).or_else(|_| std::path::absolute(path)).ok()?;
    whole.into_os_string().into_string().ok()
}
