//! Height fields of MJCF, against the heights that `MuJoCo` 4.0 finds by rays at the points of the same grid.

use std::fs;

use dualbody::ModelOptions;
use dualbody::contact::Terrain;
use dualbody::dynamics::frame_pose;
use dualbody::io::{ImportReport, MjcfScene};

/// Heights that `mj_ray` finds along y = −1, 0, 1 for x = −1.5, −0.5, 0.5, 1.5 from the geom's origin, m.
const HEIGHTS: [[f64; 3]; 4] = [
    [0.316667, 0.183333, 0.05],
    [0.35, 0.216667, 0.083333],
    [0.383333, 0.25, 0.116667],
    [0.45, 0.283333, 0.15],
];

const GRID: &str = "nrow='3' ncol='4' elevation='1 2 3 4  5 6 7 8  9 10 11 13'";
const GEOM: &str = "<geom type='hfield' hfield='h' pos='0.2 0.1 0.05'/>";

fn scene_of(grid: &str, geom: &str, more: &str) -> String {
    format!(
        "<mujoco><asset><hfield name='h' size='1.5 1 0.4 0.1' {grid}/></asset><worldbody>{geom}{more}\n<body name='ball' pos='0.2 0.1 0.4'><freejoint/><geom size='0.1' mass='1'/></body></worldbody></mujoco>"
    )
}

fn read(xml: &str) -> (MjcfScene, ImportReport) {
    let loaded = ModelOptions::default().load_mjcf_scene_str(xml);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

fn height(scene: &MjcfScene, x: f64, y: f64) -> f64 {
    let heights = scene.contacts.heights.clone().expect("a height field");
    Terrain::HeightField(heights).surface(&x, &y).height
}

#[test]
fn heights_equal_those_of_mujoco_at_the_points_of_the_grid() {
    let (scene, report) = read(&scene_of(GRID, GEOM, ""));
    assert!(report.ignored.is_empty(), "{report}");
    for (row, x) in HEIGHTS.iter().zip([-1.5, -0.5, 0.5, 1.5]) {
        for (theirs, y) in row.iter().zip([-1.0, 0.0, 1.0]) {
            let ours = height(&scene, 0.2 + x, 0.1 + y);
            assert!((ours - theirs).abs() < 1e-5, "{ours} {theirs} at {x}, {y}");
        }
    }
}

/// Rows of files begin at the smallest y, those of elevations at the largest.
#[test]
fn binary_files_have_their_first_row_at_the_smallest_y() {
    let file = std::env::temp_dir().join(format!("heights_{}.hf", std::process::id()));
    let counts = [3_i32, 4].into_iter().flat_map(i32::to_le_bytes);
    let numbers = (0..12_u8).flat_map(|k| f32::from(k).to_le_bytes());
    let bytes: Vec<u8> = counts.chain(numbers).collect();
    let grid = format!("file='{}'", file.display());
    fs::write(&file, &bytes).expect("a file");
    let (scene, report) = read(&scene_of(&grid, GEOM, ""));
    fs::write(&file, &bytes[..bytes.len() - 3]).expect("a file");
    let (short, short_report) = read(&scene_of(&grid, GEOM, ""));
    fs::remove_file(&file).expect("the file");
    assert!(report.ignored.is_empty(), "{report}");
    // The fifth of the numbers 0 to 11.
    let second_row = height(&scene, 0.2 - 1.5, 0.1);
    assert!((second_row - 0.05 - 0.4 * 4.0 / 11.0).abs() < 1e-7);
    assert!(short.contacts.heights.is_none());
    let says = "does not have 3 × 4 finite heights";
    assert!(short_report.to_string().contains(says), "{short_report}");
}

/// A ball comes to rest on it, and on a slope of one in four it does not.
#[test]
fn balls_rest_on_height_fields() {
    let level = "nrow='5' ncol='5'";
    let rest = |grid: &str| {
        let (scene, _) = read(&scene_of(grid, GEOM, ""));
        let fall = scene
            .simulator()
            .rollout(&scene.reference, 1000, |_, _, _| {});
        let ball = scene.model.frame("ball").expect("a ball");
        let height = frame_pose(&scene.model, fall.last().q.as_slice(), ball)
            .translation
            .z;
        (height, fall.last().v.amax())
    };
    let (height, speed) = rest(level);
    assert!(
        (height - 0.15).abs() < 1e-3 && speed < 1e-3,
        "{height} {speed}"
    );
    let slope = "nrow='2' ncol='2' elevation='0 1 0 1'";
    assert!(rest(slope).1 > 0.5);
}

#[test]
fn height_fields_that_are_no_ground_are_reported() {
    let plane = "<geom type='plane' size='1 1 1'/>";
    for geom in [plane, GEOM] {
        let on_body = format!("<body>{geom}</body>");
        let (scene, report) = read(&scene_of(GRID, "", &on_body));
        let says = "planes and height fields touch on the world only";
        assert!(report.to_string().contains(says), "{report}");
        assert!(scene.contacts.ground.is_none());
    }
    for size in ["1e308 1e308 0.4 0.1", "1 1 1e308 0.1", "5e-324 1 0.4 0.1"] {
        let huge = scene_of(GRID, &GEOM.replace("0.05", "1.7e308"), "");
        let (scene, report) = read(&huge.replace("1.5 1 0.4 0.1", size));
        assert!(scene.contacts.heights.is_none());
        let says = "beyond the range of numbers";
        assert!(report.to_string().contains(says), "{report}");
    }
    let steep = "nrow='2' ncol='2' elevation='-1e308 1e308 0 0'";
    let (scene, _) = read(&scene_of(steep, GEOM, ""));
    assert!((height(&scene, 0.2 + 1.5, 0.1 + 1.0) - 0.45).abs() < 1e-9);
    let (_, report) = read(&scene_of("file='hills.bin'", GEOM, ""));
    assert!(report.to_string().contains("is not found"), "{report}");
}

#[test]
fn broken_height_fields_are_errors_that_name_the_place() {
    for (grid, geom, says) in [
        (
            "nrow='1' ncol='4'",
            GEOM,
            "nrow = \"1\": expected 2 or more",
        ),
        ("ncol='4'", GEOM, "has no attribute nrow"),
        (
            "nrow='2' ncol='2' elevation='1 2 3'",
            GEOM,
            "expected 4 numbers, got 3",
        ),
        (
            "nrow='2' ncol='2' elevation='1 2 3 4 5'",
            GEOM,
            "expected at most 4 numbers",
        ),
        (
            "nrow='2' ncol='2' elevation='1 2 3 nan'",
            GEOM,
            "is not finite",
        ),
        (
            "nrow='2000000000' ncol='2000000000'",
            GEOM,
            "a height field of",
        ),
        (GRID, "<geom type='hfield'/>", "has no attribute hfield"),
        (
            GRID,
            "<geom type='hfield' hfield='none'/>",
            "there is no height field of that name",
        ),
    ] {
        let error = ModelOptions::default().load_mjcf_scene_str(&scene_of(grid, geom, ""));
        let error = error.map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(says), "{error}\nnot: {says}");
    }
    let flat = scene_of(GRID, GEOM, "").replace("1.5 1 0.4 0.1", "1.5 1 0 0.1");
    let error = ModelOptions::default()
        .load_mjcf_scene_str(&flat)
        .map(|_| ());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("a length is not positive"), "{error}");
}

/// Height of the middle of a ball of 0.1 m after a fall onto the second of two grounds.
fn rest_on(first: &str, second: &str) -> f64 {
    let xml = scene_of(
        "nrow='3' ncol='3' elevation='1 1 1 1 1 1 0 0 0'",
        first,
        second,
    );
    let (scene, report) = read(&xml.replace(
        "<freejoint/>",
        "<joint type='slide' axis='0 0 1' damping='5'/>",
    ));
    assert!(report.ignored.is_empty(), "{report}");
    let fall = scene
        .simulator()
        .rollout(&scene.reference, 2000, |_, _, _| {});
    let ball = scene.model.frame("ball").expect("a ball");
    let place = frame_pose(&scene.model, fall.last().q.as_slice(), ball);
    place.translation.z
}

#[test]
fn other_planes_and_height_fields_are_ground_too() {
    let deep = "<geom type='plane' size='1 1 1' pos='0 0 -5'/>";
    let high = "<geom type='plane' size='1 1 1' pos='0 0 0.2'/>";
    let wall = "<geom type='plane' size='1 1 1' pos='-9 0 0' euler='0 90 0'/>";
    let field = "<geom type='hfield' hfield='h' pos='0.2 0.3 0' euler='0 0 180'/>";
    for (first, second, expected) in [
        (deep, high, 0.3),
        (wall, high, 0.3),
        // Half turned about z, the half at small y is flat at 0.4 m.
        (deep, field, 0.5),
        (field, deep, 0.5),
        (GEOM.replace("0.05", "-5").as_str(), field, 0.5),
    ] {
        let height = rest_on(first, second);
        assert!(
            (height - expected).abs() < 2e-3,
            "{height} on {first} {second}"
        );
    }
    // Types that do not touch.
    let idle = field.replace("type=", "contype='2' conaffinity='2' type=");
    assert!(rest_on(deep, &idle) < -1.0);
}

#[test]
fn too_many_triangles_beside_the_ground_are_reported() {
    let (_, report) = read(&scene_of(
        "nrow='300' ncol='300'",
        "<geom type='plane' size='1 1 1'/>",
        GEOM,
    ));
    let says = "more than 100000 triangles";
    assert!(report.to_string().contains(says), "{report}");
}

#[cfg(not(feature = "png"))]
#[test]
fn reports_name_the_feature_that_reads_pictures() {
    let file = std::env::temp_dir().join(format!("heights_{}.png", std::process::id()));
    fs::write(&file, "a picture").expect("a file");
    let grid = format!("file='{}'", file.display());
    let (_, report) = read(&scene_of(&grid, GEOM, ""));
    fs::remove_file(&file).expect("the file");
    assert!(report.to_string().contains("feature `png`"), "{report}");
}
