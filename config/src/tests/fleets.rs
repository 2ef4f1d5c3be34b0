//! Fleets: many robots from a few lines, each on free floor, the same every time.

use super::good;
use crate::{Links, Override, Problem, Swarm, load_swarm};
use std::path::PathBuf;

/// A swarm of `fleets` in a hall of 100 m with a pillar of 2 m in the middle.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(fleets: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().expect("a folder") };
        let kinds = ["scout_mini", "rover_mavlink"].map(|kind| (kind, good(&format!("robots/{kind}.toml"))));
        let kinds = kinds.map(|(name, path)| format!("{name} = {:?}\n", path.display().to_string()));
        let world = "enclosure = true\npoints_m = [[-50, -50], [50, -50], [50, 50], [-50, 50]]\n";
        let text = format!(
            "name = \"n\"\nduration_s = 1\n[kinds]\n{}[world]\nname = \"w\"\ncircles = [{{ centre_m = [0, 0], radius_m \
             = 2 }}]\n[[world.polygons]]\n{world}[behaviour]\nkind = \"diffuse\"\n{fleets}",
            kinds.concat()
        );
        std::fs::write(bench.path(), text).expect("written");
        bench
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("swarm.toml")
    }

    fn swarm(&self, set: &[&str]) -> Swarm {
        let set: Vec<Override> = set.iter().map(|set| Override::parse(set).expect("a key")).collect();
        load_swarm(&self.path(), &set).unwrap_or_else(|problems| panic!("{problems}"))
    }

    /// The one problem.
    fn refused(&self) -> Problem {
        let problems = load_swarm(&self.path(), &[]).expect_err("refused").0;
        let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("one problem, not {all:#?}"));
        problem
    }
}

fn nearest_pair_m(swarm: &Swarm) -> f64 {
    let place = |index: usize| swarm.robots[index].start;
    let pairs = (0..swarm.robots.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let gap_m = pairs.map(|(a, b)| libm::hypot(place(a).x_m - place(b).x_m, place(a).y_m - place(b).y_m));
    gap_m.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_grid_fills_its_region_from_the_south_west_around_what_stands_there() {
    let swarm = Bench::new(
        "[[robot]]\nid = 7\nkind = \"scout_mini\"\nstart = { x_m = -4, y_m = -4 }\n\
         [[fleet]]\nkind = \"scout_mini\"\ncount = 7\nfirst_id = 100\nregion_m = [[-6, -6], [6, 6]]\nspacing_m = 4\n\
         yaw_rad = 1\n",
    )
    .swarm(&[]);
    let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
    assert_eq!(ids, [7, 100, 101, 102, 103, 104, 105, 106]);
    let links = Links::Can { drive: "vcan106d".to_owned(), lidar: "vcan106l".to_owned() };
    assert_eq!(swarm.robots[7].links, links);
    let places: Vec<[f64; 2]> = swarm.robots.iter().skip(1).map(|robot| [robot.start.x_m, robot.start.y_m]).collect();
    // Three to a side; robot 7 has the first place and the pillar the middle one. Nothing else fits.
    let rows = [[0.0, -4.0], [4.0, -4.0], [-4.0, 0.0], [4.0, 0.0], [-4.0, 4.0], [0.0, 4.0], [4.0, 4.0]];
    assert_eq!(places, rows);
    assert!(swarm.robots.iter().skip(1).all(|robot| (robot.start.yaw_rad - 1.0).abs() < 1e-12));
}

#[test]
fn bodies_in_a_grid_may_touch_and_still_be_read_again() {
    let bench = Bench::new("[[fleet]]\nkind = \"scout_mini\"\ncount = 2000\nspacing_m = 0.84\n");
    let swarm = bench.swarm(&[]);
    std::fs::write(bench.path(), swarm.to_toml()).expect("written");
    assert_eq!(bench.swarm(&[]), swarm);
}

#[test]
fn random_places_keep_their_distance_and_follow_from_the_seed() {
    let bench = Bench::new("[[fleet]]\nkind = \"scout_mini\"\ncount = 500\nlayout = \"random\"\nspacing_m = 2\n");
    let swarm = bench.swarm(&[]);
    assert!(nearest_pair_m(&swarm) >= 2.0);
    let far = |x_m: f64, y_m: f64| x_m.abs() <= 49.58 && y_m.abs() <= 49.58 && libm::hypot(x_m, y_m) >= 2.42;
    assert!(swarm.robots.iter().all(|robot| far(robot.start.x_m, robot.start.y_m)));
    assert!(swarm.robots.windows(2).all(|pair| (pair[0].start.yaw_rad - pair[1].start.yaw_rad).abs() > 0.0));
    assert_eq!(bench.swarm(&[]), swarm);
    assert_ne!(bench.swarm(&["seed=2"]).robots, swarm.robots);
}

#[test]
fn a_moved_layout_keeps_its_shape_and_follows_from_the_seed() {
    let row = "[[fleet]]\nkind = \"scout_mini\"\ncount = 5\nregion_m = [[-30, -30], [-20, -28]]\n";
    let still = Bench::new(row).swarm(&[]);
    let bench = Bench::new(&format!("{row}shift_m = [[-2, 10], [2, 11]]\n"));
    let moved = bench.swarm(&[]);
    let offset = |swarm: &Swarm, index: usize| {
        let (robot, other) = (swarm.robots[index].start, still.robots[index].start);
        [robot.x_m - other.x_m, robot.y_m - other.y_m]
    };
    let [x_m, y_m] = offset(&moved, 0);
    assert!((-2.0..=2.0).contains(&x_m) && (10.0..=11.0).contains(&y_m));
    let same =
        |index: usize| offset(&moved, index).iter().zip([x_m, y_m]).all(|(own, first)| (own - first).abs() < 1e-9);
    assert!((0..5).all(same));
    assert_eq!(bench.swarm(&[]), moved);
    assert_ne!(bench.swarm(&["seed=2"]).robots, moved.robots);
}

#[test]
fn linked_places_are_near_to_an_earlier_one_and_others_stay_where_they_were() {
    let fleet = "[[fleet]]\nkind = \"scout_mini\"\ncount = 60\nlayout = \"random\"\nspacing_m = 2\n";
    let swarm = Bench::new(&format!("{fleet}linked_m = 3\n")).swarm(&[]);
    for (index, robot) in swarm.robots.iter().enumerate().skip(1) {
        let earlier = swarm.robots[..index].iter().map(|other| other.start);
        let gap_m = |other: crate::Start| libm::hypot(robot.start.x_m - other.x_m, robot.start.y_m - other.y_m);
        let nearest_m = earlier.map(gap_m).fold(f64::INFINITY, f64::min);
        assert!((2.0..=3.0).contains(&nearest_m), "{nearest_m}");
    }
    // So wide a link holds nobody back: it draws no chance of its own.
    let free = Bench::new(fleet).swarm(&[]);
    assert_eq!(Bench::new(&format!("{fleet}linked_m = 1000\n")).swarm(&[]), free);
}

#[test]
fn a_hundred_thousand_robots_fit_into_a_few_lines() {
    let text = "[[fleet]]\nkind = \"scout_mini\"\ncount = 60000\nregion_m = [[-10000, 60], [10000, 10000]]\n\
                [[fleet]]\nkind = \"scout_mini\"\ncount = 40000\nfirst_id = 60001\nlayout = \"random\"\n\
                region_m = [[-10000, -10000], [10000, 60]]\n[[world.circles]]\ncentre_m = [0, 100]\nradius_m = 5\n";
    let bench = Bench::new("");
    let base = std::fs::read_to_string(bench.path()).expect("written");
    let open = base.replace("enclosure = true", "enclosure = false").replace("circles = [", "#");
    std::fs::write(bench.path(), open + text).expect("written");
    let swarm = bench.swarm(&[]);
    assert_eq!(swarm.robots.len(), 100_000);
    // Written out it is far longer than a file that somebody writes, and is read all the same.
    std::fs::write(bench.path(), swarm.to_toml()).expect("written");
    assert!(bench.swarm(&[]) == swarm);
}

#[test]
fn fleets_that_cannot_be_are_refused_with_words() {
    let cases = [
        ("count = 10000000", "fleet[0].count", "10000000", "1..=100000", "in that range"),
        ("count = 0", "fleet[0].count", "0", "1..=100000", "in that range"),
        ("count = 20000", "fleet[0].count", "20000, of which 3", "1.68 m to each other", "lower count or spacing_m"),
        ("count = 9\nspacing_m = 0.5", "fleet[0].spacing_m", "0.5", "at least two radii, 0.84", "touch"),
        ("count = 9\nspacing_m = nan", "fleet[0].spacing_m", "nan", "0.01..=1000", "finite"),
        ("count = 9\nregion_m = [[0, 0], [0, 1]]", "fleet[0].region_m", "[[0, 0], [0, 1]]", "min below", "swap"),
        ("count = 9\nregion_m = [[0, 0], [inf, 1]]", "fleet[0].region_m[1]", "[inf, 1]", "a point", "finite"),
        ("count = 9\nregion_m = 3", "fleet[0].region_m", "3", "two points", "corner"),
        ("count = 9\nfirst_id = 4294967290", "fleet[0].first_id", "4294967290", "at most 4294967287", "lower"),
        (
            "count = 9\nlayout = \"gird\"",
            "fleet[0].layout",
            "\"gird\"",
            "\"grid\", \"random\"",
            "did you mean \"grid\"?",
        ),
        ("count = 9\nlinked_m = 3", "fleet[0].linked_m", "3 beside", "a random layout", "choose spacing_m"),
        (
            "count = 9\nlayout = \"random\"\nspacing_m = 2\nlinked_m = 1.9",
            "fleet[0].linked_m",
            "1.9",
            "at least spacing_m, 2",
            "raise it",
        ),
        ("count = 9\nshift_m = [[1, 0], [0, 1]]", "fleet[0].shift_m", "[[1, 0], [0, 1]]", "min below", "swap"),
        ("count = 9\nshift_m = 3", "fleet[0].shift_m", "3", "two points", "corner"),
        ("count = 9\nspacing = 1", "fleet[0].spacing", "unknown key", "spacing_m", "did you mean 'spacing_m'?"),
    ];
    for (lines, key, found, allowed, advice) in cases {
        let problem = Bench::new(&format!("[[fleet]]\nkind = \"scout_mini\"\n{lines}\n")).refused();
        assert_eq!(problem.key, key, "{problem}");
        assert!(problem.found.contains(found) && problem.expected.contains(allowed), "{problem}");
        assert!(problem.advice.contains(advice) && problem.line.is_some(), "{problem}");
    }
}

#[test]
fn what_is_wrong_with_many_robots_of_a_fleet_is_said_once() {
    let twice = "[[fleet]]\nkind = \"scout_mini\"\ncount = 9\n[[fleet]]\nkind = \"scout_mini\"\ncount = 9\n";
    let problem = Bench::new(twice).refused();
    assert_eq!(problem.key, "fleet[1].first_id");
    assert_eq!(problem.found, "1, which fleet[0] has already");
    let problem = Bench::new("[[fleet]]\nkind = \"rover_mavlink\"\ncount = 300\n").refused();
    assert_eq!((problem.key.as_str(), problem.found.as_str()), ("fleet[0].first_id", "251"));
    let problem = Bench::new("[[fleet]]\nkind = \"scout_min\"\ncount = 300\n").refused();
    assert_eq!((problem.key.as_str(), problem.advice.as_str()), ("fleet[0].kind", "did you mean \"scout_mini\"?"));
    let half = "[[fleet]]\nkind = \"scout_mini\"\ncount = 60000\nfirst_id = 1\nregion_m = [[-50, -50], [50, 50]]\n";
    let many = format!("{half}{}", half.replace("60000", "100000"));
    let problems = load_swarm(&Bench::new(&many).path(), &[]).expect_err("refused").to_string();
    assert!(problems.contains("100000, which makes 160000 robots in all; allowed: at most 100000"), "{problems}");
}
