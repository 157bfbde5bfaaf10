//! Contact of meshes, beside the shapes that they are meshes of.

use std::path::PathBuf;

use dualbody::contact::{ContactLaw, ContactOptions, Contacts, Rigid, Terrain};
use dualbody::model::UpAxis;
use dualbody::{Model, ModelOptions, Simulator, State};
use nalgebra::{Vector3, vector};

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA};

/// Corners of the unit cube, and triangles between them, both ways: which way a triangle looks does not matter to a
/// hull.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    f 1 2 3\nf 2 3 4\nf 5 6 7\nf 6 7 8\nf 1 2 5\nf 2 5 6\nf 3 4 7\nf 4 7 8\nf 1 3 5\nf 3 5 7\nf 2 4 6\nf 4 6 8\n";

/// Writes a mesh for a test of this name.
fn mesh(name: &str, text: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a folder for tests");
    path.display().to_string()
}

/// A free link of a solid box of 1 kg with these collision shapes.
fn link(shapes: &[String]) -> Model {
    Model::from_urdf_str(&described(shapes)).expect("a link")
}

/// The description of it.
fn described(shapes: &[String]) -> String {
    let shapes: Vec<String> = shapes
        .iter()
        .map(|shape| format!("<collision>{shape}</collision>"))
        .collect();
    format!(
        "<robot name='r'><link name='l'><inertial><mass value='1'/>\
         <inertia ixx='0.006' ixy='0' ixz='0' iyy='0.012' iyz='0' izz='0.0156'/></inertial>{}</link></robot>",
        shapes.concat()
    )
}

fn geometry(file: &str, scale: &str) -> String {
    format!("<geometry><mesh filename='{file}' scale='{scale}'/></geometry>")
}

/// The cube as a box of these edges about the origin.
fn as_box(file: &str, size: [f64; 3]) -> String {
    let at = size.map(|x| -0.5 * x);
    format!(
        "<origin xyz='{} {} {}'/>{}",
        at[0],
        at[1],
        at[2],
        geometry(file, &format!("{} {} {}", size[0], size[1], size[2]))
    )
}

fn law() -> ContactLaw {
    ContactLaw::Rigid(Rigid::default())
}

fn on_ground(model: &Model) -> Contacts {
    Contacts::new(model, Terrain::flat(0.0), law())
}

fn centers(contacts: &Contacts) -> Vec<Vector3<f64>> {
    contacts.points().iter().map(|p| p.center).collect()
}

#[test]
fn points_of_a_cube_mesh_equal_the_corners_of_the_box() {
    let file = mesh("corners.obj", CUBE);
    let size = [0.36, 0.24, 0.12];
    let turned = "<origin xyz='0.1 -0.2 0.3' rpy='0.4 -0.8 1.1'/>";
    let sides = format!(
        "<geometry><box size='{} {} {}'/></geometry>",
        size[0], size[1], size[2]
    );
    let (by_mesh, by_box) = (link(&[as_box(&file, size)]), link(&[sides]));
    let (mesh, expected) = (centers(&on_ground(&by_mesh)), centers(&on_ground(&by_box)));
    assert_eq!(mesh.len(), 8);
    for (a, b) in mesh.iter().zip(&expected) {
        assert!((a - b).amax() < SAME_ALGEBRA, "{a} {b}");
    }
    // About its corner, posed and mirrored by its scale.
    let mirrored = link(&[format!("{turned}{}", geometry(&file, "-0.36 0.24 0.12"))]);
    let straight = link(&[format!("{turned}{}", geometry(&file, "1 1 1"))]);
    let (mirrored, straight) = (on_ground(&mirrored), on_ground(&straight));
    let pose = |p: &Vector3<f64>| {
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.8, 1.1);
        turn * p + vector![0.1, -0.2, 0.3]
    };
    for k in 0..8 {
        let corner = Vector3::from_fn(|axis, _| (k >> axis & 1) as f64);
        let scaled = corner.component_mul(&vector![-0.36, 0.24, 0.12]);
        let (a, b) = (centers(&straight)[k], centers(&mirrored)[k]);
        assert!((a - pose(&corner)).amax() < SAME_ALGEBRA, "{a}");
        assert!((b - pose(&scaled)).amax() < SAME_ALGEBRA, "{b}");
    }
    let again = on_ground(&link(&[as_box(&file, size)]));
    assert_eq!(centers(&again), mesh);
}

#[test]
fn a_box_of_a_mesh_falls_and_rests_like_the_box() {
    let file = mesh("rest.obj", CUBE);
    let by_mesh = link(&[as_box(&file, [0.36, 0.24, 0.12])]);
    let by_box = link(&["<geometry><box size='0.36 0.24 0.12'/></geometry>".into()]);
    let ends = [by_mesh, by_box].map(|model| {
        let contacts = on_ground(&model);
        let simulator = Simulator::new(model).with_contacts(contacts);
        let (sin, cos) = 0.2_f64.sin_cos();
        let start = State::new(
            &[0.0, 0.0, 0.3, cos, 0.0, sin, 0.0],
            &[0.5, 0.2, 0.0, 0.0, 0.0, 0.3],
        );
        let rollout = simulator.rollout(&start, 2000, |_, _, _| {});
        rollout.last().clone()
    });
    assert!(ends[0].v.amax() < 1e-6 && (ends[0].q[2] - 0.06).abs() < 1e-6);
    assert!(
        (&ends[0].q - &ends[1].q).amax() < OTHER_ALGORITHM,
        "{}",
        ends[0].q
    );
}

/// Points on a ball of radius 1, on rings of latitude.
fn ball(rings: usize, around: usize) -> String {
    let mut out = String::from("v 0 0 1\nv 0 0 -1\n");
    for i in 1..rings {
        let (r, z) = (std::f64::consts::PI * i as f64 / rings as f64).sin_cos();
        for k in 0..around {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
            out += &format!("v {} {} {z}\n", r * cos, r * sin);
        }
    }
    let count = 2 + (rings - 1) * around;
    for k in 1..=count {
        out += &format!("f {k} {} {}\n", k % count + 1, (k + 1) % count + 1);
    }
    out
}

#[test]
fn a_ball_keeps_its_radius_up_to_what_its_points_are_asked_to() {
    let (coarse, fine) = (
        mesh("coarse.obj", &ball(6, 8)),
        mesh("fine.obj", &ball(40, 60)),
    );
    let (coarse, fine) = (
        link(&[geometry(&coarse, "0.1 0.1 0.1")]),
        link(&[geometry(&fine, "0.1 0.1 0.1")]),
    );
    assert_eq!(on_ground(&coarse).points().len(), 42);
    for (most, short) in [(8, 0.5), (64, 0.07), (256, 0.02), (10_000, 0.01)] {
        let options = ContactOptions { mesh_points: most };
        let contacts = Contacts::with_options(&fine, Terrain::flat(0.0), law(), &options)
            .expect("enough memory");
        let n = contacts.points().len();
        assert_eq!(n, most.min(2 + 39 * 60));
        assert!(
            centers(&contacts)
                .iter()
                .all(|p| (p.norm() - 0.1).abs() < 1e-7)
        );
        let deepest = |direction: &Vector3<f64>| {
            let along = centers(&contacts).into_iter().map(|p| p.dot(direction));
            along.fold(f64::NEG_INFINITY, f64::max)
        };
        for direction in [vector![0.0, 0.0, -1.0], vector![0.48, 0.6, -0.64]] {
            let reach = deepest(&direction);
            assert!(reach > 0.1 * (1.0 - short), "{most}: {reach}");
        }
    }
}

/// The visual and the collision shape are rotated alike: a wedge whose highest point in the file is at y = 2.
#[test]
fn up_axis_of_a_collada_mesh_is_up_on_the_ground() {
    let wedge = mesh(
        "wedge.dae",
        "<COLLADA><asset><up_axis>Y_UP</up_axis></asset><geometry><mesh>
         <source id='p'><float_array>0 0 0 1 0 0 0 0 3 0 2 0</float_array></source>
         <vertices><input semantic='POSITION' source='#p'/></vertices><triangles>
         <input semantic='VERTEX'/><p>0 1 2 0 1 3 0 2 3 1 2 3</p></triangles></mesh></geometry></COLLADA>",
    );
    let text = format!(
        "<robot name='r'><link name='l'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' \
         iyz='0' izz='1'/></inertial><collision>{}</collision></link></robot>",
        geometry(&wedge, "1 1 1")
    );
    let corners = |up_axis: UpAxis| {
        let options = ModelOptions::default().with_mesh_up_axis(up_axis);
        let (model, _) = options.load_urdf_str(&text).expect("a wedge");
        let contacts = on_ground(&model);
        let [remark] = contacts.mesh_remarks() else {
            panic!("{:?}", contacts.mesh_remarks())
        };
        assert!(
            remark.contains("wedge.dae") && remark.contains("Y_UP"),
            "{remark}"
        );
        centers(&contacts)
    };
    let as_it_stands = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, 3.0],
        [0.0, 2.0, 0.0],
    ];
    let turned = as_it_stands.map(|[x, y, z]| Vector3::new(x, -z, y));
    assert_eq!(corners(UpAxis::Auto), turned);
    assert_eq!(corners(UpAxis::Honour), turned);
    assert_eq!(corners(UpAxis::Ignore), as_it_stands.map(Vector3::from));
}

#[test]
fn meshes_that_cannot_touch_say_why_and_others_still_do() {
    let cube = mesh("good.obj", CUBE);
    let nan = mesh("nan.obj", &CUBE.replace("v 1 0 0", "v nan 0 0"));
    let torn = mesh("torn.stl", "solid x\nfacet\nvertex 0 0 0");
    let damaged = mesh("damaged.dae", "<COLLADA");
    let bare = mesh("bare.obj", "v 0 0 0\n");
    let shapes = [
        geometry("nowhere.stl", "1 1 1"),
        geometry(&nan, "1 1 1"),
        geometry(&torn, "1 1 1"),
        geometry(&damaged, "1 1 1"),
        geometry(&bare, "1 1 1"),
        geometry(&cube, "1 1 1"),
    ];
    let contacts = on_ground(&link(&shapes));
    // The corners of the cube.
    assert_eq!(contacts.points().len(), 8);
    let reasons: Vec<&str> = contacts
        .shapes_without_points()
        .iter()
        .map(|u| u.reason.as_str())
        .collect();
    assert_eq!(reasons.len(), 5, "{reasons:?}");
    assert_eq!(reasons[0], "the mesh nowhere.stl is not found");
    assert!(reasons[1].contains("has the vertex [NaN"), "{reasons:?}");
    assert!(reasons[4].ends_with("has no triangles"), "{reasons:?}");
    assert!(
        contacts
            .shapes_without_points()
            .iter()
            .all(|u| u.link == "l")
    );
    let none = ContactOptions { mesh_points: 0 };
    let none = Contacts::with_options(&link(&shapes), Terrain::flat(0.0), law(), &none)
        .expect("enough memory");
    assert!(none.points().is_empty() && none.shapes_without_points().len() == 6);
}

#[test]
fn flat_meshes_touch_with_the_corners_of_their_polygon() {
    let plate = mesh(
        "plate.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0.5 0.5 0\nf 1 2 5\nf 2 4 5\nf 4 3 5\nf 3 1 5\n",
    );
    let rod = mesh("rod.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n");
    let dot = mesh("dot.obj", "v 3 2 1\nf 1 1 1\n");
    let number = |file: &str| on_ground(&link(&[geometry(file, "1 1 1")])).points().len();
    assert_eq!([number(&plate), number(&rod), number(&dot)], [4, 2, 1]);
    // A mesh that is scaled to nothing is refused.
    let flattened = described(&[geometry(&plate, "1 1 0")]);
    let error = Model::from_urdf_str(&flattened).unwrap_err().to_string();
    assert!(error.contains("scale = \"0\""), "{error}");
}
