//! Pictures of what is measured of a run over time.

use crate::chart::stacked;
use crate::{Chart, Figure, PictureError, Rule, Run, Series, words};
use drover_record::{
    Connectivity, Coverage, FAR_M, Moment, PlaceIndex, connectivity, gaps, hearing, speed_mps, velocity_order,
};

/// More robots than this are not drawn one by one.
pub(crate) const ROBOTS_APART: usize = 12;

/// The second eigenvalue costs the cube of the number of robots: not more of this work than a few seconds' worth.
const EIGEN_WORK: f64 = 2e10;

/// How many robots, and which of them are linked.
type Network = (usize, Vec<(usize, usize)>);

/// What is measured of a run, a value a moment; NaN where there is none.
pub(crate) struct Measures {
    time_s: Vec<f64>,
    gap_robot_m: Vec<f64>,
    gap_wall_m: Vec<f64>,
    lambda2: Vec<f64>,
    components: Vec<f64>,
    order: Vec<f64>,
    covered: Vec<f64>,
}

fn known(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

impl Measures {
    pub(crate) fn of(run: &Run) -> Self {
        let index = PlaceIndex::new(&run.setting.place);
        let gaps: Vec<_> = run.moments.iter().map(|moment| gaps(&run.setting, &index, moment)).collect();
        let links = connectivities(run);
        let mut coverage = Coverage::new(&run.setting);
        let cover = |moment: &Moment| {
            coverage.add(moment);
            known(coverage.fraction()) * 100.0
        };
        Self {
            time_s: run.moments.iter().map(|moment| moment.time_s).collect(),
            gap_robot_m: gaps.iter().map(|gaps| known(gaps.robot_m)).collect(),
            gap_wall_m: gaps.iter().map(|gaps| known(gaps.wall_m)).collect(),
            lambda2: links.iter().map(|links| known(links.and_then(|links| links.lambda2))).collect(),
            components: links.iter().map(|links| known(links.map(|links| links.components as f64))).collect(),
            order: run.moments.iter().map(|moment| known(velocity_order(moment))).collect(),
            covered: if has_scans(run) { run.moments.iter().map(cover).collect() } else { Vec::new() },
        }
    }

    fn series(&self, name: &str, values: &[f64]) -> Series {
        let points = self.time_s.iter().zip(values).map(|(time_s, value)| [*time_s, *value]).collect();
        Series { name: name.to_owned(), points, ..Series::default() }
    }

    /// Name, value and unit of what a run came to.
    pub(crate) fn results(&self) -> Vec<(&'static str, String)> {
        let finite =
            |values: &[f64]| -> Vec<f64> { values.iter().copied().filter(|value| value.is_finite()).collect() };
        let least = |values: &[f64]| finite(values).into_iter().min_by(f64::total_cmp);
        let most = |values: &[f64]| finite(values).into_iter().max_by(f64::total_cmp);
        let order = finite(&self.order);
        let mean = (!order.is_empty()).then(|| order.iter().sum::<f64>() / order.len() as f64);
        let said = |value: Option<f64>, digits: usize, unit: &str| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}{unit}"))
        };
        vec![
            ("smallest gap between two robots", said(least(&self.gap_robot_m), 3, " m")),
            ("smallest gap to a wall", said(least(&self.gap_wall_m), 3, " m")),
            ("least algebraic connectivity λ₂", said(least(&self.lambda2), 3, "")),
            ("most parts of the network", said(most(&self.components), 0, "")),
            ("mean velocity order", said(mean, 3, "")),
            ("area covered at the end", said(self.covered.last().copied().filter(|last| last.is_finite()), 1, " %")),
        ]
    }
}

fn has_scans(run: &Run) -> bool {
    run.moments.iter().flat_map(|moment| &moment.robots).any(|robot| robot.scan.is_some())
}

/// Each moment's connectivity; `None` where it was not looked at because the swarm is large.
fn connectivities(run: &Run) -> Vec<Option<Connectivity>> {
    let robots = run.setting.robots.len().max(1) as f64;
    let affordable = (EIGEN_WORK / robots.powi(3)).clamp(20.0, 1e6) as usize;
    let apart = run.moments.len().div_ceil(affordable).max(1);
    let mut before: Option<(Network, Connectivity)> = None;
    let look = |(at, moment): (usize, &Moment)| {
        if at % apart != 0 && at + 1 != run.moments.len() {
            return None;
        }
        let network = (moment.robots.len(), hearing(&run.setting, moment));
        // The same network as before hangs together as before, and most often it is the same.
        let same = before.as_ref().filter(|(old, _)| *old == network).map(|(_, found)| *found);
        let found = same.unwrap_or_else(|| connectivity(network.0, &network.1));
        before = Some((network, found));
        Some(found)
    };
    run.moments.iter().enumerate().map(look).collect()
}

pub(crate) fn figures(run: &Run, measures: &Measures) -> Result<Vec<Figure>, PictureError> {
    Ok(vec![
        gap_figure(run, measures)?,
        connectivity_figure(run, measures)?,
        coverage_figure(run, measures)?,
        order_figure(run, measures)?,
        speed_figure(run)?,
    ])
}

/// A chart over time; an empty recording is a better reason for having no data than `why`.
fn chart(run: &Run, title: &str, y_label: &str, why: &str) -> Chart {
    let why = if run.moments.is_empty() { "the recording holds no moment" } else { why };
    Chart {
        title: title.to_owned(),
        subtitle: words::conditions(run),
        x_label: "time (s)".to_owned(),
        y_label: y_label.to_owned(),
        why_empty: why.to_owned(),
        ..Chart::default()
    }
}

fn gap_figure(run: &Run, measures: &Measures) -> Result<Figure, PictureError> {
    let title = "Smallest gaps over time";
    let why = format!("there is one robot at most, and no wall within {FAR_M} m of it");
    let mut chart = chart(run, title, "gap (m)", &why);
    chart.series = vec![
        measures.series("between two robots", &measures.gap_robot_m),
        measures.series("between a robot and a wall", &measures.gap_wall_m),
    ];
    chart.rules = vec![Rule { y: 0.0, words: "contact".to_owned() }];
    let caption = "The smallest distance at each moment, from surface to surface: between any two robots, and between \
                   any robot and a wall, an obstacle or a mover. A body counts as the disc that holds it; below 0 two \
                   things overlap. Walls farther than 5 m are not drawn.";
    Ok(Figure { name: "gaps", title, caption, svg: chart.svg()? })
}

fn connectivity_figure(run: &Run, measures: &Measures) -> Result<Figure, PictureError> {
    let title = "Connectivity of the network over time";
    let why = "there are fewer than two robots";
    let mut upper = chart(run, title, "algebraic connectivity λ₂", why);
    let mut series = measures.series("", &measures.lambda2);
    // Where the swarm was not looked at there is no break.
    series.points.retain(|point| point[1].is_finite());
    series.steps = true;
    upper.series = vec![series];
    upper.y_least = Some([0.0, 1.0]);
    let mut lower = chart(run, title, "parts of the network", why);
    lower.y_whole = true;
    let mut series = measures.series("", &measures.components);
    series.points.retain(|point| point[1].is_finite());
    series.steps = true;
    lower.series = vec![series];
    lower.y_least = Some([0.0, 2.0]);
    let single = upper.series[0].points.is_empty();
    let charts = if single { vec![upper] } else { vec![upper, lower] };
    let caption = "How well the swarm hangs together. Robots i and j are linked while each hears a beacon of the other \
                   that is not older than its timeout. Above: the algebraic connectivity λ₂, the second smallest \
                   eigenvalue of the Laplacian L = D − A (A: 1 for a link, else 0; D: links of each robot): 0 when the \
                   network has fallen apart, N when everybody hears everybody. Below: into how many parts it fell.";
    Ok(Figure { name: "connectivity", title, caption, svg: stacked(&charts)? })
}

fn coverage_figure(run: &Run, measures: &Measures) -> Result<Figure, PictureError> {
    let title = "Area covered over time";
    let why = if has_scans(run) { "the place is not known" } else { "the recording holds no scan" };
    let mut chart = chart(run, title, "free area seen (%)", why);
    chart.series = vec![measures.series("", &measures.covered)];
    chart.y_least = Some([0.0, 100.0]);
    let caption = "The share of the free area that the scans of all robots have swept so far, in cells of 0.25 m: a \
                   cell is seen once a beam has crossed it, up to what the beam met or as far as it can measure. What \
                   lies in obstacles or outside of the place is no free area.";
    Ok(Figure { name: "coverage", title, caption, svg: chart.svg()? })
}

fn order_figure(run: &Run, measures: &Measures) -> Result<Figure, PictureError> {
    let title = "Velocity order over time";
    let mut chart = chart(run, title, "velocity order", "no robot moved");
    chart.series = vec![measures.series("", &measures.order)];
    chart.y_least = Some([0.0, 1.0]);
    let caption = "How much those that move move in one direction: φ = |1/N Σ vᵢ/|vᵢ|| over the N robots faster than \
                   0.02 m/s (Vicsek et al., 1995): 1 when all go one way, near 0 when they go all ways. Broken while \
                   nobody moves.";
    Ok(Figure { name: "order", title, caption, svg: chart.svg()? })
}

fn speed_figure(run: &Run) -> Result<Figure, PictureError> {
    let title = "Speeds over time";
    let mut chart = chart(run, title, "speed (m/s)", "the setting names no robot");
    chart.y_least = Some([0.0, 0.1]);
    let robots = &run.setting.robots;
    chart.series = if robots.len() <= ROBOTS_APART {
        robots.iter().map(|robot| speed_of(run, robot.id)).collect()
    } else {
        speeds_of_many(run)
    };
    let caption = "Each robot's speed along its heading, below 0 when it drives backwards: by the simulator's truth, \
                   in the field by its own odometry. Of more than 12 robots: the fastest, the mean and the slowest.";
    Ok(Figure { name: "speeds", title, caption, svg: chart.svg()? })
}

fn speed_of(run: &Run, id: u32) -> Series {
    let point = |moment: &Moment| {
        let robot = moment.robots.iter().find(|robot| robot.id == id);
        [moment.time_s, known(robot.map(speed_mps))]
    };
    let points = run.moments.iter().map(point).collect();
    Series { name: format!("robot {id}"), points, ..Series::default() }
}

fn speeds_of_many(run: &Run) -> Vec<Series> {
    let series = |name: &str, of: &dyn Fn(&[f64]) -> f64| {
        let point = |moment: &Moment| {
            let speeds: Vec<f64> = moment.robots.iter().map(speed_mps).filter(|speed| speed.is_finite()).collect();
            [moment.time_s, if speeds.is_empty() { f64::NAN } else { of(&speeds) }]
        };
        Series { name: name.to_owned(), points: run.moments.iter().map(point).collect(), ..Series::default() }
    };
    vec![
        series("fastest", &|speeds| speeds.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
        series("mean", &|speeds| speeds.iter().sum::<f64>() / speeds.len() as f64),
        series("slowest", &|speeds| speeds.iter().copied().fold(f64::INFINITY, f64::min)),
    ]
}
