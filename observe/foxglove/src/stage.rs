//! One run as it is shown: its channels, what is sent once, and what was sent last.

use crate::send;
use drover_contract::Severity;
use drover_record::foxglove::{
    State, grid, laser_scan, scene_links, scene_place, scene_robots, timestamp, topic, transforms,
};
use drover_record::{Moment, RobotMoment, RobotSetting, Setting};
use foxglove::messages::scene_entity_deletion::Type as Deletion;
use foxglove::messages::{FrameTransforms, Grid, LaserScan, SceneEntityDeletion, SceneUpdate};
use foxglove::{Channel, ChannelBuilder, Context, Encode, SinkId};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

const SCENE: &str = "/scene";
const MAP: &str = "/map";

/// One run as it is shown.
pub(crate) struct Stage {
    setting: Setting,
    tf: Channel<FrameTransforms>,
    /// The place and the robots: sent once, and to every client that subscribes later.
    scene: Channel<SceneUpdate>,
    /// Who hears whom and who goes where: apart from the scene, as the newest message of a topic must be enough.
    links: Channel<SceneUpdate>,
    /// Only if the place has a map.
    map: Option<Channel<Grid>>,
    robots: BTreeMap<u32, RobotChannels>,
    /// The newest time that was shown, microseconds since the Unix epoch.
    now_us: AtomicU64,
    /// The newest words of each robot, and of the run under 0.
    said: Mutex<BTreeMap<u32, String>>,
}

struct RobotChannels {
    setting: RobotSetting,
    scan: Channel<LaserScan>,
    state: Channel<State>,
    /// Time of the newest scan that was sent, s, as bits: a scan is sent once.
    scan_time_s: AtomicU64,
}

impl Stage {
    pub(crate) fn new(context: &Arc<Context>, setting: &Setting) -> Self {
        let robots = setting.robots.iter().map(|robot| (robot.id, RobotChannels::new(context, robot)));
        Self {
            tf: channel(context, "/tf"),
            scene: channel(context, SCENE),
            links: channel(context, "/links"),
            map: setting.place.map.is_some().then(|| channel(context, MAP)),
            robots: robots.collect(),
            now_us: AtomicU64::new(setting.started_unix_us),
            said: Mutex::default(),
            setting: setting.clone(),
        }
    }

    /// Take the channels away from the clients.
    pub(crate) fn close(&self) {
        self.tf.close();
        self.scene.close();
        self.links.close();
        self.map.iter().for_each(Channel::close);
        for robot in self.robots.values() {
            robot.scan.close();
            robot.state.close();
        }
    }

    /// What is sent once, to every client that is there.
    pub(crate) fn tell_all(&self) {
        self.tell_once(SCENE, None);
        self.tell_once(MAP, None);
    }

    /// What is sent once on this topic, to `only` if it is given.
    pub(crate) fn tell_once(&self, topic: &str, only: Option<SinkId>) {
        let now_us = self.now_us.load(Ordering::Relaxed);
        match (topic, &self.map, &self.setting.place.map) {
            (SCENE, _, _) => send(&self.scene, now_us, only, || self.scene(now_us)),
            (MAP, Some(channel), Some(map)) => send(channel, now_us, only, || grid(now_us, map)),
            _ => {}
        }
    }

    /// The place and the robots, instead of all that was there before.
    fn scene(&self, now_us: u64) -> SceneUpdate {
        let mut update = scene_place(now_us, &self.setting);
        update.entities.extend(scene_robots(now_us, &self.setting).entities);
        update.deletions.push(SceneEntityDeletion {
            timestamp: Some(timestamp(now_us)),
            r#type: Deletion::All as i32,
            id: String::new(),
        });
        update
    }

    /// The swarm at `unix_us`, microseconds since the Unix epoch.
    pub(crate) fn show(&self, unix_us: u64, moment: &Moment) {
        self.now_us.store(unix_us, Ordering::Relaxed);
        send(&self.tf, unix_us, None, || transforms(unix_us, moment));
        send(&self.links, unix_us, None, || scene_links(unix_us, &self.setting, moment));
        for robot in &moment.robots {
            if let Some(channels) = self.robots.get(&robot.id) {
                send(&channels.state, unix_us, None, || State::new(moment.time_s, robot));
                channels.show_scan(unix_us, moment.time_s, robot);
            }
        }
    }

    /// What has changed in words since the moment before: how grave, which robot (0: the swarm), and the words.
    pub(crate) fn news(&self, moment: &Moment) -> Vec<(Severity, u32, String)> {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let run = (Severity::Info, 0, moment.run.words.clone());
        let robots = moment.robots.iter().map(|robot| (severity(robot), robot.id, words(robot)));
        let all = std::iter::once(run).chain(robots);
        let news = all.filter(|(_, id, words)| said.get(id).map_or("", String::as_str) != words);
        let news: Vec<_> = news.collect();
        said.extend(news.iter().map(|(_, id, words)| (*id, words.clone())));
        news
    }
}

impl RobotChannels {
    fn new(context: &Arc<Context>, setting: &RobotSetting) -> Self {
        Self {
            scan: channel(context, &topic(setting.id, "scan")),
            state: channel(context, &topic(setting.id, "state")),
            setting: setting.clone(),
            scan_time_s: AtomicU64::new(f64::NAN.to_bits()),
        }
    }

    /// The newest scan, if it was not yet sent. It carries the time at which it was taken.
    fn show_scan(&self, unix_us: u64, time_s: f64, robot: &RobotMoment) {
        let Some(scan) = robot.scan.as_ref().filter(|_| self.scan.has_sinks()) else { return };
        let bits = scan.time_s.to_bits();
        if self.scan_time_s.swap(bits, Ordering::Relaxed) != bits {
            let age_us = ((time_s - scan.time_s) * 1e6).max(0.0) as u64;
            let taken_us = unix_us.saturating_sub(age_us);
            send(&self.scan, unix_us, None, || laser_scan(taken_us, &self.setting, scan));
        }
    }
}

fn channel<M: Encode>(context: &Arc<Context>, topic: &str) -> Channel<M> {
    ChannelBuilder::new(topic).context(context).build()
}

fn words(robot: &RobotMoment) -> String {
    match (robot.state.as_str(), robot.reason.as_str()) {
        (state, "") => state.into(),
        // A verdict in words often begins with the state itself.
        (state, reason) if reason.starts_with(state) => reason.into(),
        (state, reason) => format!("{state}: {reason}"),
    }
}

fn severity(robot: &RobotMoment) -> Severity {
    match robot.state.as_str() {
        "dead" => Severity::Error,
        "held" | "stopped" => Severity::Warning,
        _ => Severity::Info,
    }
}
