//! The image half of a map: pixels to cells.

use super::header::{Header, Mode};
use crate::report::Words;
use image::codecs::png::PngDecoder;
use image::codecs::pnm::PnmDecoder;
use image::{ColorType, ImageDecoder};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Greatest image file, bytes.
const IMAGE_BYTES_MAX: u64 = 128 << 20;
/// Most cells: a square kilometre at 12.5 cm.
const CELLS_MAX: u64 = 64_000_000;

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cell {
    Free,
    Occupied,
    Unknown,
}

/// Cells from west to east and from south to north.
#[derive(Debug)]
pub(crate) struct Cells {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cells: Vec<Cell>,
}

/// Reads the image at `path`. Sizes are looked at before anything is read or allocated.
pub(crate) fn read(path: &Path, header: &Header) -> Result<Cells, Words> {
    let shown = format!("{:?}", header.image);
    let refuse =
        |found: String, expected: &str, advice: &str| Words::new(format!("{shown}, {found}"), expected, advice);
    let unreadable = |error: std::io::Error| {
        let advice = format!("check the path and its permissions ({})", path.display());
        refuse(format!("which is no readable file ({error})"), "a readable file", &advice)
    };
    let meta = std::fs::metadata(path).map_err(unreadable)?;
    if !meta.is_file() {
        return Err(refuse("which is no file".to_owned(), "a regular file", "name a PGM or PNG image"));
    }
    if meta.len() > IMAGE_BYTES_MAX {
        let found = format!("a file of {} bytes", meta.len());
        return Err(refuse(
            found,
            &format!("at most {IMAGE_BYTES_MAX} bytes"),
            "crop the map or make its cells coarser",
        ));
    }
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    let mut magic = [0; 2];
    file.read_exact(&mut magic).map_err(unreadable)?;
    file.seek(SeekFrom::Start(0)).map_err(unreadable)?;
    let broken = |error: image::ImageError| {
        let said = crate::tree::shorten(&error.to_string());
        refuse(format!("a broken image ({said})"), "a whole PGM or PNG image", "save the map again")
    };
    match &magic {
        b"P2" | b"P5" => decode(PnmDecoder::new(file).map_err(broken)?, header),
        b"\x89P" => decode(PngDecoder::new(file).map_err(broken)?, header),
        _ => Err(Failure::Refused(("another format".to_owned(), "a PGM (P2 or P5) or PNG image", "convert it"))),
    }
    .map_err(|failure| match failure {
        Failure::Refused((found, expected, advice)) => refuse(found, expected, advice),
        Failure::Broken(error) => broken(error),
    })
}

enum Failure {
    Refused((String, &'static str, &'static str)),
    Broken(image::ImageError),
}

fn decode(decoder: impl ImageDecoder, header: &Header) -> Result<Cells, Failure> {
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    if count == 0 || count > CELLS_MAX {
        let advice = "crop the map or make its cells coarser";
        return Err(Failure::Refused((format!("{width} x {height} cells"), "1 to 64000000 cells", advice)));
    }
    let (channels, alpha) = match decoder.color_type() {
        ColorType::L8 => (1, false),
        ColorType::La8 => (2, true),
        ColorType::Rgb8 => (3, false),
        ColorType::Rgba8 => (4, true),
        other => {
            let found = format!("{other:?} pixels");
            return Err(Failure::Refused((found, "8 bits a channel", "save it with 8 bits a channel")));
        }
    };
    let size = usize::try_from(decoder.total_bytes()).unwrap_or(usize::MAX).min(CELLS_MAX as usize * 4);
    let mut bytes = vec![0; size];
    decoder.read_image(&mut bytes).map_err(Failure::Broken)?;
    let (width, height) = (width as usize, height as usize);
    // Images begin in the north, maps in the south.
    let rows = bytes.chunks_exact(width * channels).take(height).rev();
    let cells = rows.flat_map(|row| row.chunks_exact(channels)).map(|pixel| cell(pixel, alpha, header)).collect();
    Ok(Cells { width, height, cells })
}

/// map_server's rule for one pixel, whose last channel may be its opacity.
fn cell(pixel: &[u8], alpha: bool, header: &Header) -> Cell {
    let opacity = pixel.last().copied().filter(|_| alpha);
    let colours = &pixel[..pixel.len() - usize::from(alpha)];
    // Grey counts three times beside opacity: ROS' image loaders know opacity with red, green and blue only.
    let grey = if colours.len() == 1 { 3.0 } else { 1.0 };
    let sum: f64 = colours.iter().map(|channel| f64::from(*channel)).sum::<f64>() * grey;
    let (sum, count) = match (opacity, header.mode) {
        (Some(opacity), Mode::Trinary) => (sum + f64::from(opacity), 4.0),
        (Some(_), Mode::Scale) | (None, Mode::Trinary | Mode::Scale) => (sum, 3.0),
    };
    let brightness = sum / count;
    let occupied = if header.negate { brightness / 255.0 } else { (255.0 - brightness) / 255.0 };
    match header.mode {
        Mode::Trinary if occupied > header.occupied_thresh => Cell::Occupied,
        Mode::Trinary if occupied < header.free_thresh => Cell::Free,
        Mode::Trinary => Cell::Unknown,
        Mode::Scale if opacity.is_some_and(|opacity| opacity < 255) => Cell::Unknown,
        Mode::Scale if occupied >= header.occupied_thresh => Cell::Occupied,
        Mode::Scale => Cell::Free,
    }
}
