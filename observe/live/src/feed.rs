//! What the producer of moments holds, and what the clients take from it.

use axum::extract::ws::Utf8Bytes;
use drover_record::{Control, Controls, Moment, Setting};
use serde::Serialize;
use std::sync::{Arc, OnceLock};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, watch};

/// More pages than this at once are turned away.
pub(crate) const CLIENTS_MAX: usize = 32;

/// Controls that the producer has not taken yet; more are refused.
const CONTROLS_WAITING_MAX: usize = 16;

/// Faster than this nothing can be asked to go.
const RATE_MAX: f64 = 64.0;

/// A handle to what is shown: it costs nothing to clone, and nothing it does waits.
#[derive(Clone)]
pub struct Feed {
    shared: Arc<Shared>,
}

struct Shared {
    view: watch::Sender<View>,
    controls: mpsc::Sender<Control>,
    seats: Arc<Semaphore>,
}

/// All there is to see: a client that takes it owes nothing to what was before.
#[derive(Clone)]
pub(crate) struct View {
    pub(crate) run: Arc<Run>,
    pub(crate) frame: Option<Arc<Frame>>,
}

/// What does not change while a run goes on.
pub(crate) struct Run {
    pub(crate) number: u64,
    pub(crate) controls: Controls,
    setting: Setting,
    text: OnceLock<Utf8Bytes>,
}

/// A moment, and the texts made of it.
pub(crate) struct Frame {
    pub(crate) number: u64,
    moment: Moment,
    /// For each robot, whether its scan is the one that the frame before had.
    same_scan: Vec<bool>,
    whole: OnceLock<Utf8Bytes>,
    lean: OnceLock<Utf8Bytes>,
}

/// What a page is told.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Message<'a> {
    Setting { setting: &'a Setting, controls: Controls },
    Moment { moment: &'a Moment },
    Refused { why: &'a str },
}

impl Message<'_> {
    /// As text. Our own types always have one; if one ever had not, the page would be told why.
    fn text(&self) -> Utf8Bytes {
        match serde_json::to_string(self) {
            Ok(text) => text.into(),
            Err(error) => {
                tracing::error!(%error, "a message for the live view has no text");
                Utf8Bytes::from_static(r#"{"type":"refused","why":"the server could not write a message"}"#)
            }
        }
    }
}

/// The text that tells a page why it does not get what it asked for.
pub(crate) fn refused(why: &str) -> Utf8Bytes {
    Message::Refused { why }.text()
}

impl Run {
    fn new(number: u64, setting: Setting, controls: Controls) -> Arc<Self> {
        Arc::new(Self { number, controls, setting, text: OnceLock::new() })
    }

    pub(crate) fn text(&self) -> Utf8Bytes {
        let write = || Message::Setting { setting: &self.setting, controls: self.controls }.text();
        self.text.get_or_init(write).clone()
    }
}

impl Frame {
    /// `before` is the frame that this one replaces, of the same run.
    fn new(moment: Moment, before: Option<&Frame>) -> Self {
        let same_scan = moment.robots.iter().enumerate().map(|(index, robot)| {
            let earlier = before.and_then(|frame| frame.moment.robots.get(index));
            let scan_of_earlier = earlier.filter(|earlier| earlier.id == robot.id).and_then(|it| it.scan.as_ref());
            let times = robot.scan.as_ref().zip(scan_of_earlier);
            times.is_some_and(|(scan, old)| scan.time_s.total_cmp(&old.time_s).is_eq())
        });
        let same_scan = same_scan.collect();
        let number = before.map_or(1, |frame| frame.number + 1);
        Self { number, moment, same_scan, whole: OnceLock::new(), lean: OnceLock::new() }
    }

    /// The text for a client whose last frame was `seen` (0: none). One that has the frame before is not told the same
    /// scans again: they are most of the text.
    pub(crate) fn text_after(&self, seen: u64) -> Utf8Bytes {
        if seen == 0 || seen + 1 != self.number || !self.same_scan.contains(&true) {
            return self.whole.get_or_init(|| Message::Moment { moment: &self.moment }.text()).clone();
        }
        self.lean.get_or_init(|| Message::Moment { moment: &self.without_old_scans() }.text()).clone()
    }

    fn without_old_scans(&self) -> Moment {
        let mut moment = self.moment.clone();
        for (robot, _) in moment.robots.iter_mut().zip(&self.same_scan).filter(|(_, same)| **same) {
            robot.scan = None;
        }
        moment
    }
}

impl Feed {
    /// A feed that shows `setting` and lets pages ask for what `controls` allows; and where that arrives.
    #[must_use]
    pub fn new(setting: Setting, controls: Controls) -> (Self, mpsc::Receiver<Control>) {
        let (sender, receiver) = mpsc::channel(CONTROLS_WAITING_MAX);
        let view = View { run: Run::new(1, setting, controls), frame: None };
        let seats = Arc::new(Semaphore::new(CLIENTS_MAX));
        let shared = Shared { view: watch::Sender::new(view), controls: sender, seats };
        (Self { shared: Arc::new(shared) }, receiver)
    }

    /// A new run begins: every page is told its setting and forgets the run before.
    pub fn begin(&self, setting: Setting, controls: Controls) {
        self.shared.view.send_modify(|view| {
            *view = View { run: Run::new(view.run.number + 1, setting, controls), frame: None };
        });
    }

    /// Show `moment`; it replaces the one before, whether anybody saw that or not. A page that comes later sees it too.
    pub fn show(&self, moment: Moment) {
        self.shared.view.send_modify(|view| {
            view.frame = Some(Arc::new(Frame::new(moment, view.frame.as_deref())));
        });
    }

    /// Whether a page is open. Nobody needs to gather moments while none is; show one soon after this turns true.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        self.shared.seats.available_permits() < CLIENTS_MAX
    }

    pub(crate) fn views(&self) -> watch::Receiver<View> {
        self.shared.view.subscribe()
    }

    /// A seat for one more client; `None`: all are taken.
    pub(crate) fn seat(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.shared.seats).try_acquire_owned().ok()
    }

    /// Hand on what a client wrote, if it is a control and allowed.
    ///
    /// # Errors
    /// Why not, in words for the page.
    pub(crate) fn ask(&self, text: &str) -> Result<(), String> {
        let control: Control = serde_json::from_str(text).map_err(|error| format!("not a control: {error}"))?;
        let allowed = self.shared.view.borrow().run.controls;
        may(control, allowed)?;
        self.shared.controls.try_send(control).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => "too much is asked at once; try again".to_owned(),
            mpsc::error::TrySendError::Closed(_) => "the run has ended; nobody is there to do it".to_owned(),
        })?;
        tracing::info!(?control, "asked for from the live view");
        Ok(())
    }
}

/// Whether `control` makes sense and `allowed` has it.
fn may(control: Control, allowed: Controls) -> Result<(), String> {
    let (is_allowed, what) = match control {
        Control::Stop => (allowed.stop, "be stopped"),
        Control::Pause | Control::Resume | Control::Speed { .. } => (allowed.pace, "change its pace"),
        Control::Restart => (allowed.restart, "be restarted"),
        Control::Seek { .. } => (allowed.seek, "go to another moment"),
    };
    if !is_allowed {
        return Err(format!("this run cannot {what} from here"));
    }
    match control {
        Control::Speed { rate } if !(rate > 0.0 && rate <= RATE_MAX) => {
            Err(format!("a speed is more than 0 and at most {RATE_MAX}"))
        }
        Control::Seek { time_s } if !(time_s >= 0.0 && time_s.is_finite()) => {
            Err("a moment is at 0 s or later".to_owned())
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_record::{RobotMoment, ScanMoment};

    fn seen(scan_time_s: f64) -> Moment {
        let scan = ScanMoment { time_s: scan_time_s, ranges_m: vec![Some(1.5)], ..ScanMoment::default() };
        let robot = RobotMoment { id: 1, scan: Some(scan), ..RobotMoment::default() };
        Moment { robots: vec![robot], ..Moment::default() }
    }

    #[test]
    fn a_scan_is_told_once_to_those_who_follow_and_again_to_those_who_do_not() {
        let first = Frame::new(seen(0.1), None);
        let second = Frame::new(seen(0.1), Some(&first));
        let third = Frame::new(seen(0.2), Some(&second));
        assert!(first.text_after(0).contains("ranges_m"));
        assert!(!second.text_after(1).contains("ranges_m"));
        assert!(second.text_after(0).contains("ranges_m"));
        assert!(third.text_after(2).contains("ranges_m"));
        assert!(third.text_after(1).contains("ranges_m"));
    }

    #[test]
    fn a_speed_or_a_moment_that_makes_no_sense_is_refused() {
        let all = Controls { stop: true, pace: true, restart: true, seek: true };
        for control in [Control::Speed { rate: 0.0 }, Control::Speed { rate: 1e9 }, Control::Seek { time_s: -1.0 }] {
            assert!(may(control, all).is_err(), "{control:?}");
        }
        assert_eq!(may(Control::Speed { rate: 16.0 }, all), Ok(()));
    }

    #[test]
    fn nothing_is_allowed_by_default() {
        for control in [Control::Stop, Control::Pause, Control::Restart, Control::Seek { time_s: 1.0 }] {
            assert!(may(control, Controls::default()).is_err());
        }
    }

    #[test]
    fn controls_that_nobody_takes_are_refused_and_not_kept() {
        let controls = Controls { stop: true, ..Controls::default() };
        let (feed, mut receiver) = Feed::new(Setting::default(), controls);
        let told: Vec<_> = (0..=CONTROLS_WAITING_MAX).map(|_| feed.ask(r#"{"do":"stop"}"#)).collect();
        assert_eq!(told.iter().filter(|told| told.is_ok()).count(), CONTROLS_WAITING_MAX);
        receiver.close();
        while receiver.try_recv().is_ok() {}
        assert!(feed.ask(r#"{"do":"stop"}"#).unwrap_err().contains("ended"));
    }
}
