//! A run that is looked at, and the browser that looks.

use crate::common::{Running, drover, free_port_base, peers_python, signal, top};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// How long a run may take to say where it is to be seen.
const ANNOUNCE_MAX: Duration = Duration::from_secs(20);

/// One browser at a time, also where the tests are threads of one process; nextest's are processes, its configuration
/// has a group for them.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    // A test that failed leaves nothing behind that the next one needs.
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A run with a live page.
pub(crate) struct Shown {
    running: Running,
    /// What it says to open.
    pub(crate) url: String,
    folder: TempDir,
}

impl Shown {
    /// `drover up FILE --view ADDRESS`, to itself, recordings in its own folder.
    pub(crate) fn up(file: &Path, address: &str, more: &[&str]) -> Self {
        let base = free_port_base();
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = drover();
        command.arg("up").arg(file).args(["--json", "--view", address]).args(more);
        command.arg("--set").arg(format!("mavlink_port_base={base}"));
        command.arg("--set").arg(format!("beacon.port={}", base + 319));
        command.arg("--set").arg(format!("record_dir={:?}", folder.path().display().to_string()));
        Self::start(command, folder)
    }

    /// `drover replay` of a recording.
    pub(crate) fn replay(recording: &Path) -> Self {
        let mut command = drover();
        command.arg("replay").arg(recording).args(["--view", "127.0.0.1:0"]);
        Self::start(command, tempfile::tempdir().expect("a folder"))
    }

    fn start(mut command: Command, folder: TempDir) -> Self {
        let open = |name: &str| File::create(folder.path().join(name)).expect("a writable folder");
        command.stdin(Stdio::null()).stdout(open("out")).stderr(open("errors"));
        // A token that the caller's shell holds would be asked for on loopback too.
        command.env_remove("DROVER_VIEW_TOKEN");
        let running = Running::start(&mut command);
        let url = announced(&folder.path().join("errors"));
        Self { running, url, folder }
    }

    /// Its address and port alone.
    pub(crate) fn address(&self) -> &str {
        self.url.trim_start_matches("http://").split('/').next().expect("split gives one part at least")
    }

    /// SIGKILL, as a crash.
    pub(crate) fn kill(mut self) {
        self.running.kill();
    }

    /// Ctrl-C: its exit code, and what it printed.
    pub(crate) fn interrupt(self) -> (Option<i32>, String) {
        signal("INT", self.running.id());
        self.finish()
    }

    /// Wait for its end: its exit code, and what it printed.
    fn finish(self) -> (Option<i32>, String) {
        let code = self.running.wait().code();
        (code, std::fs::read_to_string(self.folder.path().join("out")).expect("what it printed"))
    }
}

/// The address that the run wrote into `errors`.
fn announced(errors: &Path) -> String {
    let limit = Instant::now() + ANNOUNCE_MAX;
    loop {
        let text = std::fs::read_to_string(errors).expect("its errors");
        // A line without its end may be half of it.
        let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        if let Some(url) = whole.filter_map(|line| line.trim().strip_prefix("live view: ")).next() {
            return url.to_owned();
        }
        assert!(Instant::now() < limit, "no live view within {ANNOUNCE_MAX:?}: {text}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Chromium, playing one scenario of `page.py`.
pub(crate) struct Browser {
    child: Child,
    stdout: BufReader<ChildStdout>,
}

impl Browser {
    /// Open `shown`'s page.
    pub(crate) fn open(scenario: &str, shown: &Shown) -> Self {
        let pictures = pictures();
        std::fs::create_dir_all(&pictures).expect("a writable target folder");
        eprintln!("pictures: {}", pictures.display());
        let mut command = Command::new(peers_python());
        command.arg(top().join("tests/view/page.py")).args([scenario, &shown.url]).arg(pictures);
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let stdout = BufReader::new(child.stdout.take().expect("it is a pipe"));
        Self { child, stdout }
    }

    /// The next thing that it tells.
    pub(crate) fn line(&mut self) -> Value {
        let mut line = String::new();
        self.stdout.read_line(&mut line).expect("its output");
        serde_json::from_str(&line)
            .unwrap_or_else(|error| panic!("page.py printed {line:?}: {error}; see stderr above"))
    }

    /// What it found, once it has ended well.
    pub(crate) fn found(mut self) -> Value {
        let found = self.line();
        let ended = self.child.wait().expect("it was started");
        assert!(ended.success(), "page.py ended with {ended}: {found:#}");
        println!("{found}");
        found
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself. Ended by SIGTERM it takes the browser along.
        let running = self.child.try_wait().is_ok_and(|ended| ended.is_none());
        if running {
            signal("TERM", self.child.id());
            let _ = self.child.wait();
        }
    }
}

/// Where the pictures go; they are not part of the project.
fn pictures() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| top().join("target"), PathBuf::from);
    target.join("view-artefacts")
}

/// A number of what was found.
pub(crate) fn number(found: &Value) -> f64 {
    found.as_f64().unwrap_or_else(|| panic!("{found:#} is no number"))
}

/// A list of numbers of what was found.
pub(crate) fn numbers(found: &Value) -> Vec<f64> {
    found.as_array().unwrap_or_else(|| panic!("{found:#} is no list")).iter().map(number).collect()
}

/// Nothing went wrong on the page, and it talked to nobody but `shown`.
pub(crate) fn assert_clean(found: &Value, shown: &Shown) {
    assert_eq!(found["complaints"], serde_json::json!([]), "{found:#}");
    assert_eq!(found["hosts"], serde_json::json!([shown.address()]), "{found:#}");
}

/// The file of a fleet of rovers that diffuse through one of the shipped worlds.
pub(crate) fn fleet_file(folder: &Path, count: usize, world: &str) -> PathBuf {
    let config = top().join("config");
    let (world, kind) = (config.join("worlds").join(world), config.join("robots/rover_mavlink.toml"));
    let text = format!(
        "name = \"fleet\"\nseed = 1\nduration_s = 120.0\nworld = {world:?}\n[kinds]\nrover_mavlink = {kind:?}\n\
         [[fleet]]\nkind = \"rover_mavlink\"\ncount = {count}\nlayout = \"random\"\nspacing_m = 1.6\n\
         [behaviour]\nkind = \"diffuse\"\nspeed_mps = 0.5\nturn_radps = 1.0\nclearance_m = 1.2\n\
         [radio]\nrange_m = 15.0\nloss = 0.02\n"
    );
    let path = folder.join("fleet.toml");
    std::fs::write(&path, text).expect("a writable folder");
    path
}
