//! The project's own Rust sources.

use std::path::{Path, PathBuf};

/// One source file.
pub(crate) struct Source {
    /// Its path from the top of the project, with slashes.
    pub(crate) name: String,
    /// Its text.
    pub(crate) text: String,
}

impl Source {
    /// The text before the tests that stand at the end of the same file; a `mod tests;` ends nothing.
    pub(crate) fn production_text(&self) -> &str {
        self.text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default()
    }

    /// Whether the whole file is a test.
    pub(crate) fn is_test(&self) -> bool {
        let in_tests = self.name.starts_with("tests/") || self.name.contains("/tests/");
        in_tests || self.name.ends_with("tests.rs") || self.name.ends_with("testing.rs")
    }
}

/// The top of the project.
pub(crate) fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file of the project.
pub(crate) fn all_sources() -> Vec<Source> {
    const ROOTS: [&str; 8] = ["src", "config", "firmware_if", "controller", "sim_bridge", "observe", "bench", "tests"];
    let mut files = Vec::new();
    ROOTS.iter().for_each(|root| collect(&top().join(root), &mut files));
    files.sort();
    assert!(files.len() > 30, "found only {} sources: the search is broken", files.len());
    files.into_iter().map(read).collect()
}

/// Every Rust file that is not a test as a whole.
pub(crate) fn production_sources() -> Vec<Source> {
    all_sources().into_iter().filter(|source| !source.is_test()).collect()
}

fn read(path: PathBuf) -> Source {
    let name = path.strip_prefix(top()).unwrap_or(&path).to_string_lossy().replace('\\', "/");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
    Source { name, text }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target") {
            collect(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}
