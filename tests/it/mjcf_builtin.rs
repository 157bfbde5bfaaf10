//! Meshes that MJCF makes of parameters: vertices and inertias against those that `MuJoCo` 4.0 makes of the same text.

use dualbody::model::Geometry;
use dualbody::spatial::{Inertia, Symmetric3};
use dualbody::{Model, ModelOptions};
use nalgebra::Vector3;

/// Name, parameters, method of inertia; number of vertices; mass, centre of mass, and the moments xx, yy, zz, xy, xz, yz about it.
type Case = (&'static str, &'static str, &'static str, usize, [f64; 10]);

#[rustfmt::skip]
const CASES: [Case; 19] = [
    ("sphere", "0", "", 12, [2536.1504726624075, 0.0, 0.0, 0.0, 734.0702430338127, 734.0702430338127, 734.0702430338127, 0.0, 0.0, 0.0]),
    ("sphere", "2", "", 162, [4047.0446616510244, 0.0, 0.0, 0.0, 1582.1694526509998, 1582.1694513676375, 1582.1694633536251, 0.0, 0.0, 0.0]),
    ("sphere", "1", "shell", 42, [11665.931199548155, 0.0, 0.0, 0.0, 7111.950440048862, 7111.950440048863, 7111.950440048863, 0.0, 0.0, 0.0]),
    ("hemisphere", "0", "", 6, [666.6666666666665, 0.0, 0.0, 0.25, 91.66666666666717, 91.66666666666717, 133.33333333333408, 0.0, 0.0, 0.0]),
    ("hemisphere", "3", "", 42, [1909.7436909829885, 0.0, 0.0, 0.36260610739429655, 467.667323207741, 467.667323207741, 718.766514099306, 0.0, 0.0, 0.0]),
    ("hemisphere", "10", "exact", 266, [2068.308741012736, 0.0, 0.0, 0.3732706675536752, 532.2702902082057, 532.2702902082057, 820.4497973168916, 0.0, 0.0, 0.0]),
    ("hemisphere", "1", "shell", 14, [8037.302710628805, 0.0, 0.0, 0.28560216348057327, 2746.933861572977, 2746.933861572977, 4040.5965231936666, 0.0, 0.0, 0.0]),
    ("cone", "5 0", "", 6, [1585.094227875054, 0.0, 0.0, -0.5, 420.7646158322541, 420.7646113773317, 366.00095884706985, 0.0, 0.0, 0.0]),
    ("cone", "7 0.4", "", 14, [2845.86657990609, 0.0, 0.0, -0.26923076690244013, 1180.867742566793, 1180.8677322909784, 789.4924145154278, 0.0, 0.0, 0.0]),
    ("supersphere", "7 0.6 1.7", "", 44, [2584.19163102718, 0.007392792301722954, 0.0, 0.0, 741.4328217443971, 739.5733533473039, 848.9712747583322, 0.0, 0.0, 0.0]),
    ("supersphere", "5 0 0", "", 22, [7999.999999999999, 0.0, 0.0, 0.0, 5333.333333333334, 5333.333333333334, 5333.333333333333, 0.0, 0.0, 0.0]),
    ("supersphere", "9 2.5 0.5", "shell", 74, [11636.597041011342, -0.027220504456721476, 0.0, 0.0, 7124.372652577516, 7050.453650956063, 5283.673637406072, 0.0, 0.0, 0.0]),
    ("supertorus", "5 0.3 0.6 1.7", "exact", 25, [959.0610178288545, 0.06910760005949299, 0.0, 0.0, 335.3394602504489, 326.80144703401, 622.4478330490114, 0.0, 0.0, 0.0]),
    ("supertorus", "8 0.5 1 1", "exact", 64, [3999.999920445221, 0.0, 0.0, 0.0, 2335.6811173010874, 2335.6811173010874, 4220.17777491676, 0.0, 0.0, 0.0]),
    ("supertorus", "8 0.5 1 1", "", 64, [4764.297623954799, 0.0, 0.0, 0.0, 2425.1036831269153, 2425.103683126916, 4358.367246292976, 0.0, 0.0, 0.0]),
    ("supertorus", "6 1 2 0.7", "convex", 36, [11777.891484634076, 0.0, 0.0, 0.0, 9838.38377329619, 9490.332208141414, 15898.062667197797, 0.0, 0.0, 0.0]),
    ("wedge", "4 5 70 40 0.3", "", 20, [322.5459308104633, 0.0, 0.0, -0.733488635069685, 24.146648801130308, 36.591392406964765, 54.94547745605848, 0.0, 0.0, 0.0]),
    ("wedge", "3 3 90 45 0", "shell", 9, [4199.100779460705, 0.0, 0.0, -0.5782883034443457, 552.7042906187138, 950.453915996087, 1291.4803542183363, 0.0, 0.0, 0.0]),
    ("wedge", "6 3 180 90 1", "", 18, [1471.0176136681926, 0.0, 0.0, -0.2273238787407117, 319.99777234647047, 301.9086950903211, 391.7926912790619, 0.0, 0.0, 0.0]),
];

fn xml(builtin: &str, params: &str, more: &str) -> String {
    format!(
        "<mujoco><asset><mesh name='m' builtin='{builtin}' params='{params}' {more}/></asset>
         <worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
    )
}

fn load(builtin: &str, params: &str, more: &str) -> Model {
    let loaded = ModelOptions::default().load_mjcf_str(&xml(builtin, params, more));
    let (model, report) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let notes = report.warnings.len() + report.ignored.len();
    assert_eq!(notes, 0, "{builtin} {params}: {report}");
    model
}

fn vertices(model: &Model) -> usize {
    let visual = &model.links()[0].visuals[0];
    let Geometry::Mesh { uri, .. } = &visual.geometry else {
        panic!("no mesh")
    };
    uri.matches("v%20").count()
}

#[test]
fn vertices_and_inertias_equal_those_of_mujoco() {
    for (builtin, params, method, count, expected) in CASES {
        let more = match method {
            "" => String::new(),
            _ => format!("inertia='{method}'"),
        };
        let model = load(builtin, params, &more);
        assert_eq!(vertices(&model), count, "{builtin} {params}");
        let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = expected;
        let moments = Symmetric3::new(xx, xy, xz, yy, yz, zz);
        let theirs = Inertia::from_com(mass, &Vector3::new(x, y, z), &moments).to_matrix();
        let error = (model.link_inertias()[0].to_matrix() - theirs).amax() / theirs.amax();
        // Vertices there are in single precision, and are rounded once more where the mesh is moved to its centre.
        assert!(error < 1e-7, "{builtin} {params} {method}: {error:e}");
    }
}

#[test]
fn scales_act_on_made_meshes() {
    let [one, other] = ["", "scale='1 2 3'"].map(|more| load("cone", "6 0.5", more));
    let ratio = other.total_mass() / one.total_mass();
    assert!((ratio - 6.0).abs() < 1e-6, "{ratio}");
}

/// Plates have no volume: `MuJoCo` refuses such a geom, here it is in the report.
#[test]
fn plates_are_in_the_report() {
    let loaded = ModelOptions::default().load_mjcf_str(&xml("plate", "3 4", ""));
    let (model, report) = loaded.expect("a body");
    assert!(report.to_string().contains("in one plane"), "{report}");
    assert!(model.links()[0].visuals.is_empty());
}

#[test]
fn parameters_out_of_range_are_errors() {
    for (builtin, params, says) in [
        ("ball", "1", "expected one of none, sphere"),
        ("sphere", "1 2", "expected at most 1 numbers"),
        (
            "sphere",
            "5",
            "the number of subdivisions is not from 0 to 4",
        ),
        ("sphere", "-1", "is not from 0 to 4"),
        ("hemisphere", "11", "the resolution is not from 0 to 10"),
        ("cone", "2", "expected 2 numbers"),
        ("cone", "2 0", "the number of corners"),
        ("cone", "4 1.5", "the radius 1.5 is not in [0, 1]"),
        ("supersphere", "2 1 1", "the resolution"),
        ("supersphere", "3 -1 1", "e -1 is not at least 0"),
        ("supersphere", "9000 1 1", "more than 200000 vertices"),
        ("supertorus", "4 2 1 1", "the radius 2 is not in (0, 1]"),
        ("supertorus", "4 0.5 0 1", "s 0 is not positive"),
        ("wedge", "2 2 200 30 0", "the first angle 200"),
        ("wedge", "2 2 60 100 0", "the second angle 100"),
        ("wedge", "2 2 60 30 2", "gamma 2"),
        ("wedge", "1e99 1e99 60 30 0", "the first resolution"),
    ] {
        let loaded = ModelOptions::default().load_mjcf_str(&xml(builtin, params, ""));
        let error = loaded.map(|_| ()).unwrap_err().to_string();
        assert!(error.starts_with("MJCF text:1: <mesh> \"m\""), "{error}");
        assert!(error.contains(says), "{error}: not {says}");
    }
}
