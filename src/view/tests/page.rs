//! Tests of the HTML viewer as text; `tests/browser/` opens it in a browser.

use serde_json::Value;

use super::super::{Recording, model_page};
use super::{HOSTILE, everything};
use crate::dynamics::{forward_kinematics, kinetic_energy, potential_energy};
use crate::io::ModelOptions;
use crate::io::temporary::Folder;
use crate::model::{BodyId, Geometry, LinkSpec, Mass, ModelBuilder, UpAxis, samples};
use crate::spatial::Transform;
use crate::{Model, Simulator, State};

/// Largest page of ten seconds of a cart-pole, bytes.
const MAX_PAGE: usize = 300_000;

/// Ten seconds of a cart-pole in steps of 10 ms.
fn ten_seconds() -> Recording {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
    let simulator = Simulator::new(Model::from_urdf_file(file).unwrap()).with_time_step(0.01);
    let rollout = simulator.rollout(&State::new(&[0.1, 0.5], &[0.0; 2]), 1000, |_, _, _| {});
    Recording::from_rollout(simulator.model(), &rollout)
}

/// The data in a page.
pub(super) fn data(page: &str) -> Value {
    let start = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let length = page[start..].find("</script>").unwrap();
    serde_json::from_str(&page[start..start + length]).unwrap()
}

/// The bytes of a blob.
fn bytes(blob: &Value) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let text = blob["data"]
        .as_str()
        .unwrap()
        .trim_end_matches('=')
        .as_bytes();
    let bits = |chunk: &[u8]| {
        let bits = chunk
            .iter()
            .fold(0_u32, |bits, &c| bits << 6 | u32::from(value(c)));
        let bits = bits << (6 * (4 - chunk.len()));
        bits.to_be_bytes()[1..chunk.len()].to_vec()
    };
    text.chunks(4).flat_map(bits).collect()
}

fn f32s(blob: &Value) -> Vec<f64> {
    let bytes = bytes(blob);
    let numbers = bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    numbers.map(f64::from).collect()
}

fn close(a: f64, b: f64, what: &str) {
    assert!(
        (a - b).abs() < 1e-4 * b.abs().max(1.0),
        "{what}: {a} against {b}"
    );
}

#[test]
fn page_of_ten_seconds_of_a_cartpole_is_small() {
    let size = ten_seconds().to_html().len();
    assert!(size < MAX_PAGE, "{size} bytes");
}

#[test]
fn poses_and_energies_on_the_page_equal_kinematics_of_the_recorded_states() {
    let recording = ten_seconds();
    let (track, page) = (&recording.robots()[0], data(&recording.to_html()));
    let (motion, model) = (&page["motion"], track.model());
    let times = bytes(&motion["times"]);
    let times = times
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    let positions = f32s(&motion["robots"][0]["positions"]);
    let rotations = bytes(&motion["robots"][0]["rotations"]);
    let energy = motion["robots"][0]["plots"]
        .as_array()
        .unwrap()
        .last()
        .unwrap();
    let energies = [0, 1].map(|i| f32s(&energy["lines"][i]["values"]));
    let mut shown = 0;
    for (k, time) in times.enumerate() {
        let row = recording.times().iter().position(|&t| t == time).unwrap();
        let (q, v) = (track.q(row), track.v(row));
        let kinematics = forward_kinematics(model, q, v);
        for body in 0..2 {
            let pose = kinematics.pose(Some(BodyId(body)));
            for axis in 0..3 {
                close(
                    positions[6 * k + 3 * body + axis],
                    pose.translation[axis],
                    "position",
                );
            }
            // tr R = 4 w² − 1
            let w = &rotations[16 * k + 8 * body..];
            let w = f64::from(i16::from_le_bytes([w[0], w[1]])) / 32767.0;
            close(4.0 * w * w - 1.0, pose.rotation.trace(), "trace");
        }
        close(
            energies[0][k],
            kinetic_energy(model, q, v),
            "kinetic energy",
        );
        close(
            energies[1][k],
            potential_energy(model, q),
            "potential energy",
        );
        shown += 1;
    }
    assert_eq!(shown, 501);
}

#[test]
fn hostile_names_stay_inside_the_data_of_the_page() {
    let recording = everything();
    let (hostile, harmless) = (recording.to_html(), ten_seconds().to_html());
    for part in ["<script", "</script", "<title", "</title"] {
        let count = |page: &str| page.matches(part).count();
        assert_eq!(count(&hostile), count(&harmless), "{part}");
    }
    let page = data(&hostile);
    assert_eq!(page["title"], HOSTILE);
    assert_eq!(page["motion"]["series"][0]["lines"][0]["name"], HOSTILE);
    assert_eq!(page["fixtures"][5]["name"], HOSTILE);
}

// A quarter of a turn about z is (cos 45°, 0, 0, sin 45°).
#[test]
fn scene_objects_on_the_page_stand_where_they_were_put() {
    let mut recording = Recording::new(&samples::pendulum());
    let turn = nalgebra::Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let place = Transform::new(turn, nalgebra::Vector3::new(1.0, 2.0, 3.0));
    let ball = Geometry::Sphere { radius: 0.2 };
    recording.add_shape("ball", ball, place, [1.0, 0.5, 0.0, 0.25]);
    recording.add_axes("goal", place);
    let missing = Geometry::Mesh {
        uri: "lost.stl".into(),
        path: None,
        scale: [1.0; 3],
        up_axis: UpAxis::Auto,
    };
    recording.add_shape("bust", missing, place, [1.0; 4]);
    let page = data(&recording.to_html());
    let [ball, goal, bust] = [0, 1, 2].map(|k| &page["fixtures"][k]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let pose = [1.0, 2.0, 3.0, half, 0.0, 0.0, half];
    for (i, expected) in pose.into_iter().enumerate() {
        let shape = &ball["shapes"][0];
        close(shape["pose"][i].as_f64().unwrap(), expected, "shape");
        close(goal["axes"][i].as_f64().unwrap(), expected, "axes");
    }
    assert_eq!(ball["shapes"][0]["shape"], "sphere");
    assert_eq!(
        ball["shapes"][0]["size"],
        serde_json::json!([0.2, 0.2, 0.2])
    );
    assert_eq!(
        ball["shapes"][0]["color"],
        serde_json::json!([1.0, 0.5, 0.0, 0.25])
    );
    assert!(ball["axes"].is_null() && goal["shapes"].as_array().unwrap().is_empty());
    assert_eq!(bust["shapes"][0]["shape"], "box");
    let warning = page["warnings"][0].as_str().unwrap();
    assert!(warning.starts_with("\"bust\": a box replaces the mesh \"lost.stl\""));
}

#[test]
fn page_names_no_place_to_fetch_from() {
    let page = ten_seconds().to_html() + &model_page(&samples::arm());
    for place in [
        "http:",
        "https:",
        "//www",
        "src=",
        "href=",
        "@import",
        "url(",
        "fetch(",
        "XMLHttp",
        "innerHTML",
    ] {
        assert!(!page.contains(place), "{place}");
    }
}

#[test]
fn ellipsoid_of_a_solid_sphere_equals_the_sphere() {
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::solid_sphere("ball", 0.3, Mass::Kilograms(2.0)));
    let page = data(&model_page(&builder.build().unwrap()));
    let radii = &page["robots"][0]["bodies"][0]["ellipsoid"][1];
    for axis in 0..3 {
        close(radii[axis].as_f64().unwrap(), 0.3, "radius");
    }
}

#[test]
fn placement_of_each_joint_equals_its_pose_at_zero() {
    let model = samples::random_tree(12, 5);
    let page = data(&model_page(&model));
    let neutral = model.neutral();
    for (i, body) in model.bodies().iter().enumerate() {
        let placement = &page["robots"][0]["bodies"][i]["placement"];
        let expected = body.place(neutral.as_slice()).translation;
        for axis in 0..3 {
            close(
                placement[axis].as_f64().unwrap(),
                expected[axis],
                "placement",
            );
        }
    }
}

#[test]
fn meshes_that_cannot_be_shown_give_a_box_and_a_warning() {
    let folder = Folder::new();
    folder.write("broken.stl", "solid x\nfacet");
    folder.write("right.obj", "v 0 0 0\nv 2 0 0\nv 0 3 0\nf 1 2 3\n");
    let visual =
        |file: &str| format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual>");
    let visuals = ["broken.stl", "missing.dae", "right.obj", "right.obj"].map(visual);
    let text = format!(
        "<robot name=\"r\"><link name=\"world\">{}</link></robot>",
        visuals.concat()
    );
    let model = Model::from_urdf_file(folder.write("r.urdf", text)).unwrap();
    let page = data(&model_page(&model));
    let shapes = page["robots"][0]["shapes"].as_array().unwrap();
    let kinds: Vec<_> = shapes
        .iter()
        .map(|shape| shape["shape"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["box", "box", "mesh", "mesh"]);
    assert_eq!(shapes[2]["size"].as_array().unwrap()[1], 1.5);
    assert_eq!(
        page["meshes"].as_array().unwrap().len(),
        1,
        "one file, once"
    );
    let warnings = page["warnings"].as_array().unwrap();
    assert!(
        warnings[0]
            .as_str()
            .unwrap()
            .contains("broken.stl\", which ")
    );
    assert!(
        warnings[1]
            .as_str()
            .unwrap()
            .contains("\"missing.dae\", which is not found")
    );
}

/// An HTML viewer that is shared does not reveal file paths; data that many meshes share are stored once.
#[test]
fn warnings_call_meshes_as_the_description_does() {
    let folder = Folder::new();
    for name in ["a.dae", "b.dae"] {
        let positions = "<source id='p'><float_array>0 0 0 1 0 0 0 1 0</float_array></source>";
        let text = format!(
            "<COLLADA><asset><up_axis>Y_UP</up_axis></asset><geometry><mesh>{positions}
             <vertices><input semantic='POSITION' source='#p'/></vertices>
             <triangles><input semantic='VERTEX'/><p>0 1 2</p></triangles></mesh></geometry></COLLADA>"
        );
        folder.write(name, text);
    }
    folder.write("broken.stl", "solid x\nfacet");
    let visual =
        |file: &str| format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual>");
    let visuals = ["a.dae", "b.dae", "broken.stl"].map(visual).concat();
    let text = format!("<robot name=\"r\"><link name=\"world\">{visuals}</link></robot>");
    let path = folder.write("r.urdf", text);
    let page = |up_axis: UpAxis| {
        let options = ModelOptions::default().with_mesh_up_axis(up_axis);
        let html = model_page(&options.load_urdf_file(&path).unwrap().0);
        assert!(!html.contains(&*folder.path("").to_string_lossy()));
        data(&html)
    };
    for (up_axis, reason, size) in [
        (UpAxis::Auto, "states Y_UP: it is rotated", [0.5, 0.0, 0.5]),
        (
            UpAxis::Ignore,
            "states Y_UP: it is used without rotation",
            [0.5, 0.5, 0.0],
        ),
    ] {
        let page = page(up_axis);
        let warnings = page["warnings"].as_array().unwrap();
        let warning = warnings[1].as_str().unwrap();
        let expected = format!("the mesh \"a.dae\", like another, {reason}");
        assert!(warning.starts_with(&expected), "{warning}");
        assert_eq!(warnings.len(), 2);
        let shape = &page["robots"][0]["shapes"][0];
        assert_eq!(shape["size"], serde_json::json!(size));
    }
}

/// A robot that stops is shown where it was last seen; its numbers end.
#[test]
fn robot_that_is_lost_stays_where_it_was() {
    let mut recording = Recording::new(&samples::pendulum());
    recording.push(0.0, &State::new(&[0.5], &[0.0]), &[]);
    recording.push(1.0, &State::new(&[f64::NAN], &[0.0]), &[]);
    let page = data(&recording.to_html());
    let rotations = bytes(&page["motion"]["robots"][0]["rotations"]);
    assert_eq!(rotations[..8], rotations[8..]);
    let angles = f32s(&page["motion"]["robots"][0]["plots"][0]["lines"][0]["values"]);
    assert!(angles[0] == 0.5 && angles[1].is_nan());
}
