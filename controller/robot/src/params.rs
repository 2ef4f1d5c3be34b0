//! What codecs are told, out of a robot's file.

use drover_codec::can::agilex::{AgilexParams, Model};
use drover_codec::can::dronecan::DronecanLidarParams;
use drover_codec::mavlink::MavHostParams;
use drover_config::{AgilexModel, Drive, Kind, LidarLink, RobotFile};
use drover_contract::CanNode;
use drover_io::OpenError;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Our own node on a lidar's bus.
const OWN_NODE: CanNode = CanNode(10);

/// What the codecs of a robot's kind are told.
pub(crate) enum KindParams {
    Mavlink(MavHostParams),
    Can(Box<(AgilexParams, DronecanLidarParams)>),
}

/// An epoch for a robot that starts now: seconds since 1970, so that every restart has a greater one.
#[must_use]
pub fn epoch_from_unix() -> u32 {
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u32::try_from(unix.as_secs()).unwrap_or(u32::MAX)
}

/// The codecs' parameters out of a robot's file.
pub(crate) fn kind_params(file: &RobotFile) -> Result<KindParams, OpenError> {
    let kind = &file.kind;
    let link_timeout = Duration::from_millis(u64::from(kind.timeouts.link_ms));
    match (kind.drive, kind.lidar.link) {
        (Drive::Mavlink { component, telemetry_hz }, LidarLink::ObstacleDistance { component: lidar_component }) => {
            let robot = u8::try_from(file.robot.id).map_err(|_| misfit(file, "its id is no MAVLink system id"))?;
            Ok(KindParams::Mavlink(MavHostParams {
                robot,
                component,
                telemetry_hz,
                lidar_component,
                range_m_min: kind.lidar.range_m_min,
                range_m_max: kind.lidar.range_m_max,
                link_timeout,
            }))
        }
        (Drive::AgilexV2 { model }, LidarLink::Dronecan { node, silent_is_clear }) => {
            let drive = AgilexParams { model: table_of(model), track_m: kind.body.track_m, link_timeout };
            Ok(KindParams::Can(Box::new((drive, lidar_params(kind, node, silent_is_clear)))))
        }
        (Drive::Mavlink { .. }, LidarLink::Dronecan { .. })
        | (Drive::AgilexV2 { .. }, LidarLink::ObstacleDistance { .. }) => {
            Err(misfit(file, "no adapter joins this drive with this lidar"))
        }
    }
}

/// A robot whose parts do not go together; `drover check` says so before.
pub(crate) fn misfit(file: &RobotFile, why: &str) -> OpenError {
    OpenError::new(format!("robot {}", file.robot.id), why, "check its file with drover check")
}

fn lidar_params(kind: &Kind, node: u8, silent_is_clear: bool) -> DronecanLidarParams {
    DronecanLidarParams {
        node: CanNode(node),
        own_node: OWN_NODE,
        beams: kind.lidar.beams,
        range_m_min: kind.lidar.range_m_min,
        range_m_max: kind.lidar.range_m_max,
        rate_hz: kind.lidar.rate_hz,
        silent_is_clear,
    }
}

fn table_of(model: AgilexModel) -> Model {
    match model {
        AgilexModel::Scout => Model::Scout,
        AgilexModel::ScoutMini => Model::ScoutMini,
        AgilexModel::Tracer => Model::Tracer,
        AgilexModel::Hunter => Model::Hunter,
        AgilexModel::Bunker => Model::Bunker,
    }
}
