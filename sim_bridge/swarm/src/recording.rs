//! Where a run's recordings go.

use anyhow::Context;
use drover_config::Swarm;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// The folder of one run: the recording, the resolved configuration, the summary.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// A new folder under the swarm's `record_dir`, with the resolved configuration in it.
    ///
    /// # Errors
    /// If the folder or the file cannot be written.
    pub fn create(swarm: &Swarm) -> anyhow::Result<Self> {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let name = format!("{}-{}", swarm.name, unix.as_millis());
        let path = Path::new(&swarm.record_dir).join(name);
        std::fs::create_dir_all(&path).with_context(|| {
            format!("cannot make the folder {}: set record_dir to one you can write", path.display())
        })?;
        let folder = Self { path };
        folder.write("swarm.toml", &swarm.to_toml())?;
        Ok(folder)
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where its recording is.
    #[must_use]
    pub fn recording(&self) -> PathBuf {
        self.path.join("run.mcap")
    }

    /// Write one file of the run.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, name: &str, text: &str) -> anyhow::Result<PathBuf> {
        let path = self.path.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}
