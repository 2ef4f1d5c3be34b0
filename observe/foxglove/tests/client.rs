//! A client as Foxglove is one: it connects, reads what there is, subscribes and gets messages.

use drover_foxglove::FoxgloveServer;
use drover_record::foxglove::WORLD;
use drover_record::{MapSetting, Moment, Place, PlaceSetting, RobotMoment, RobotSetting, ScanMoment, Setting};
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, Grid, LaserScan, Log, SceneUpdate};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

const STARTED_US: u64 = 1_700_000_000_000_000;
const PATIENCE: Duration = Duration::from_secs(20);

struct Viewer {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    /// Ids of the channels by topic.
    channels: BTreeMap<String, u64>,
    /// The schema's name by topic.
    schemas: BTreeMap<String, String>,
    info: Value,
}

impl Viewer {
    async fn connect(address: SocketAddr) -> Self {
        let mut request = format!("ws://{address}").into_client_request().expect("a request");
        request.headers_mut().insert("sec-websocket-protocol", "foxglove.sdk.v1".parse().expect("a header"));
        let (socket, response) = connect_async(request).await.expect("a connection");
        assert_eq!(response.headers()["sec-websocket-protocol"], "foxglove.sdk.v1");
        let mut viewer = Self { socket, channels: BTreeMap::new(), schemas: BTreeMap::new(), info: Value::Null };
        viewer.info = viewer.text().await;
        viewer
    }

    async fn next(&mut self) -> Message {
        timeout(PATIENCE, self.socket.next()).await.expect("in time").expect("not closed").expect("a message")
    }

    async fn text(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.next().await {
                return serde_json::from_str(text.as_str()).expect("JSON");
            }
        }
    }

    /// Read what is advertised until `topic` is.
    async fn learn(&mut self, topic: &str) {
        while !self.channels.contains_key(topic) {
            let message = self.text().await;
            assert_eq!(message["op"], "advertise");
            for channel in message["channels"].as_array().expect("channels") {
                let topic = channel["topic"].as_str().expect("a topic").to_string();
                self.channels.insert(topic.clone(), channel["id"].as_u64().expect("an id"));
                assert_eq!(channel["schemaEncoding"], "protobuf");
                self.schemas.insert(topic, channel["schemaName"].as_str().expect("a schema").into());
            }
        }
    }

    async fn subscribe(&mut self, topic: &str) {
        let id = self.channels[topic];
        let ask = json!({"op": "subscribe", "subscriptions": [{"id": id, "channelId": id}]});
        self.socket.send(Message::text(ask.to_string())).await.expect("sent");
    }

    /// The next message on `topic`: its time, ns, and its bytes.
    async fn message(&mut self, topic: &str) -> (u64, Vec<u8>) {
        loop {
            let Message::Binary(bytes) = self.next().await else { continue };
            let (head, data) = bytes.split_at(13);
            let id = u32::from_le_bytes(head[1..5].try_into().expect("4 bytes"));
            if head[0] == 1 && u64::from(id) == self.channels[topic] {
                return (u64::from_le_bytes(head[5..13].try_into().expect("8 bytes")), data.to_vec());
            }
        }
    }
}

fn setting() -> Setting {
    let map = MapSetting { resolution_m: 0.5, width: 2, height: 1, runs: vec![1, 1], ..MapSetting::default() };
    Setting {
        started_unix_us: STARTED_US,
        robots: vec![RobotSetting { id: 3, radius_m: 0.2, ..RobotSetting::default() }],
        place: PlaceSetting { map: Some(map), ..PlaceSetting::default() },
        ..Setting::default()
    }
}

fn moment() -> Moment {
    let scan = ScanMoment { time_s: 0.75, range_m_max: 8.0, ranges_m: vec![Some(1.0), None], ..ScanMoment::default() };
    let robot = RobotMoment {
        id: 3,
        state: "held".into(),
        reason: "obstacle".into(),
        believed: Some(Place { x_m: 1.0, y_m: 2.0, yaw_rad: 0.0 }),
        scan: Some(scan),
        ..RobotMoment::default()
    };
    Moment { time_s: 1.0, robots: vec![robot], ..Moment::default() }
}

/// Show `moment` again and again until `viewer` gets a message on `topic`: a subscription takes effect some time later.
async fn shown(server: &FoxgloveServer, viewer: &mut Viewer, topic: &str) -> (u64, Vec<u8>) {
    let mut moment = moment();
    let showing = async {
        loop {
            server.show(STARTED_US + 1_000_000, &moment);
            // What is the same is not told twice, so it has to change.
            moment.robots[0].reason.push('!');
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::select! {
        message = viewer.message(topic) => message,
        () = showing => unreachable!("it never ends"),
    }
}

async fn running() -> FoxgloveServer {
    let server = FoxgloveServer::start(SocketAddr::from(([127, 0, 0, 1], 0))).await.expect("a server");
    server.begin(&setting());
    server
}

#[tokio::test]
async fn a_viewer_is_told_what_there_is() {
    let server = running().await;
    let mut viewer = Viewer::connect(server.address()).await;
    assert_eq!((&viewer.info["op"], &viewer.info["name"]), (&json!("serverInfo"), &json!("drover")));
    for (topic, schema) in [
        ("/tf", "foxglove.FrameTransforms"),
        ("/scene", "foxglove.SceneUpdate"),
        ("/links", "foxglove.SceneUpdate"),
        ("/map", "foxglove.Grid"),
        ("/log", "foxglove.Log"),
        ("/robot-3/scan", "foxglove.LaserScan"),
        ("/robot-3/state", "drover.State"),
    ] {
        viewer.learn(topic).await;
        assert_eq!(viewer.schemas[topic], schema);
    }
    assert_eq!(server.clients(), 1);
}

#[tokio::test]
async fn a_viewer_that_subscribes_late_is_told_the_place_and_the_map() {
    let server = running().await;
    let mut viewer = Viewer::connect(server.address()).await;
    viewer.learn("/scene").await;
    viewer.learn("/map").await;
    viewer.subscribe("/scene").await;
    let (_, bytes) = viewer.message("/scene").await;
    let scene = <SceneUpdate as Decode>::decode(bytes.as_slice()).expect("a scene");
    assert!(scene.entities.iter().any(|entity| entity.id == "robot-3"));
    viewer.subscribe("/map").await;
    let (_, bytes) = viewer.message("/map").await;
    assert_eq!(<Grid as Decode>::decode(bytes.as_slice()).expect("a map").data.as_ref(), [0, 1]);
}

#[tokio::test]
async fn a_viewer_sees_the_swarm_move() {
    let server = running().await;
    let mut viewer = Viewer::connect(server.address()).await;
    for topic in ["/tf", "/robot-3/scan", "/robot-3/state", "/log"] {
        viewer.learn(topic).await;
    }
    viewer.subscribe("/tf").await;
    let (time_ns, bytes) = shown(&server, &mut viewer, "/tf").await;
    assert_eq!(time_ns, (STARTED_US + 1_000_000) * 1_000);
    let tf = <FrameTransforms as Decode>::decode(bytes.as_slice()).expect("transforms");
    assert_eq!((tf.transforms[0].parent_frame_id.as_str(), tf.transforms.len()), (WORLD, 1));
    viewer.subscribe("/robot-3/scan").await;
    let (_, bytes) = shown(&server, &mut viewer, "/robot-3/scan").await;
    let scan = <LaserScan as Decode>::decode(bytes.as_slice()).expect("a scan");
    assert_eq!(scan.timestamp.map(|stamp| stamp.total_nanos()), Some((STARTED_US + 750_000) * 1_000));
    viewer.subscribe("/robot-3/state").await;
    assert!(!shown(&server, &mut viewer, "/robot-3/state").await.1.is_empty());
    viewer.subscribe("/log").await;
    let (_, bytes) = shown(&server, &mut viewer, "/log").await;
    let log = <Log as Decode>::decode(bytes.as_slice()).expect("a log");
    assert!(log.message.starts_with("held: obstacle") && log.name == "robot-3");
}

#[tokio::test]
async fn a_new_run_replaces_the_one_before() {
    let server = running().await;
    let mut viewer = Viewer::connect(server.address()).await;
    viewer.learn("/robot-3/state").await;
    let robots = vec![RobotSetting { id: 8, ..RobotSetting::default() }];
    server.begin(&Setting { robots, ..Setting::default() });
    let mut gone = Vec::new();
    loop {
        let message = viewer.text().await;
        match message["op"].as_str() {
            Some("unadvertise") => gone.extend(message["channelIds"].as_array().expect("ids").clone()),
            Some("advertise") if message.to_string().contains("/robot-8/state") => break,
            _ => {}
        }
    }
    assert!(gone.contains(&json!(viewer.channels["/robot-3/state"])));
}

#[tokio::test]
async fn a_server_that_is_dropped_no_longer_listens() {
    let server = running().await;
    let address = server.address();
    drop(server);
    let mut tries = 0;
    while TcpStream::connect(address).await.is_ok() {
        tries += 1;
        assert!(tries < 200, "it still listens");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}
