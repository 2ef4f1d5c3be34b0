//! Where a robot's map goes when its run is over.

use drover_core::map::{MapImage, SharedMap};
use std::path::{Path, PathBuf};

/// What robot `robot` has made of the place, as files of ROS' map_server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapFiles {
    name: String,
    image: MapImage,
}

impl MapFiles {
    /// The map of robot `robot` as it is now.
    #[must_use]
    pub fn of(robot: u32, map: &SharedMap) -> Self {
        let name = format!("robot-{robot}-map");
        let image = MapImage::new(map.lattice(), map.board(), &format!("{name}.pgm"));
        Self { name, image }
    }

    /// Write `robot-ID-map.pgm` and `robot-ID-map.yaml` into a folder that is there; the path of the latter.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        std::fs::write(folder.join(format!("{}.pgm", self.name)), &self.image.pgm)?;
        let path = folder.join(format!("{}.yaml", self.name));
        std::fs::write(&path, &self.image.yaml)?;
        Ok(path)
    }
}
