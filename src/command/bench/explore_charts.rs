//! The figures of the exploration paper as they come out here.

use drover_bench::{ExploreCourse, ExploreResult, ExploreScene};
use drover_picture::{Chart, Rule, Series};
use drover_swarm::Spread;

/// The rows of figure 6.
const DIRECTION: [&str; 2] = ["INEA", "INEA, no direction"];

/// Those that the result has numbers for, each with the name of its file.
pub(super) fn of(result: &ExploreResult) -> Vec<(String, Chart)> {
    let mut charts: Vec<(String, Chart)> =
        result.courses.lines.iter().map(|course| (format!("figure4_{}", course.scene), course_chart(course))).collect();
    let courses = result.courses.lines.iter();
    charts.extend(courses.map(|course| (format!("figure5_{}", course.scene), concentration_chart(course))));
    let scenes = result.scenes.iter().filter(|scene| DIRECTION.iter().all(|row| has(scene, row)));
    charts.extend(scenes.map(|scene| (format!("figure6_{}", scene.scene), direction_chart(scene, result.seeds))));
    charts
}

fn has(scene: &ExploreScene, name: &str) -> bool {
    scene.rows.iter().any(|row| row.row == name)
}

/// Growth is so small beside the others that it is shown over the greatest.
fn course_chart(course: &ExploreCourse) -> Chart {
    let windows = &course.windows;
    let most = windows.iter().map(|window| window.growth).fold(f64::MIN_POSITIVE, f64::max);
    let series = |name: &str, of: &dyn Fn(usize) -> f64| Series {
        name: name.into(),
        points: (0..windows.len()).map(|at| [f64::from(windows[at].steps), 100.0 * of(at)]).collect(),
        ..Series::default()
    };
    Chart {
        title: "What is known, how fast that grows, and targets that another robot had seen first".into(),
        subtitle: format!("{}: the paper's method to 96 %, one run, windows of 15 steps", course.scene),
        x_label: "steps".into(),
        y_label: "%".into(),
        y_least: Some([0.0, 100.0]),
        series: vec![
            series("known", &|at| windows[at].coverage),
            series("growth, of the greatest", &|at| windows[at].growth / most),
            series("targets of others (obex)", &|at| windows[at].obex),
        ],
        rules: vec![Rule { y: 96.0, words: "96 %".into() }],
        ..Chart::default()
    }
}

fn concentration_chart(course: &ExploreCourse) -> Chart {
    let points = |mean: &[f64]| mean.iter().zip(0_u32..).map(|(mean, at)| [f64::from(at), *mean]).collect();
    let series = course.concentrations.iter().map(|row| Series {
        name: row.row.into(),
        points: points(&row.mean),
        ..Series::default()
    });
    Chart {
        title: "Mean concentration of antibodies".into(),
        subtitle: format!("{}: one robot's antibodies, mean of runs; the paper compares with eq. 4", course.scene),
        x_label: "generation".into(),
        y_label: "mean concentration".into(),
        y_least: Some([0.0, 1.0]),
        series: series.collect(),
        ..Chart::default()
    }
}

fn direction_chart(scene: &ExploreScene, [first, end]: [u64; 2]) -> Chart {
    let series = |name: &&str| {
        let row = scene.rows.iter().find(|row| row.row == *name)?;
        let shares = [(90.0, &row.steps_90), (96.0, &row.steps_96), (99.0, &row.steps_99), (100.0, &row.steps_finish)];
        let there: Vec<(f64, &Spread)> =
            shares.into_iter().filter_map(|(share, steps)| Some((share, steps.as_ref()?))).collect();
        let ends = |spread: &Spread| [spread.ci95_low, spread.ci95_high].map(|end| end.unwrap_or(spread.mean));
        Some(Series {
            name: row.row.into(),
            points: there.iter().map(|(share, steps)| [*share, steps.mean]).collect(),
            errors: there.iter().map(|(_, steps)| ends(steps)).collect(),
            ..Series::default()
        })
    };
    Chart {
        title: "Steps with and without the direction term".into(),
        subtitle: format!("{}: means of seeds {first}..{end} with 95 % intervals; 100 %: the end", scene.scene),
        x_label: "% known".into(),
        y_label: "steps".into(),
        y_least: Some([0.0, 1.0]),
        series: DIRECTION.iter().filter_map(series).collect(),
        ..Chart::default()
    }
}
