//! Meshes of MJCF as vertices in the description and as MSH files: inertia against `MuJoCo` 4.0, shapes, files for other engines.

use std::fs;
use std::path::PathBuf;

use dualbody::contact::LinkShapes;
use dualbody::io::{ImportReport, MjcfScene};
use dualbody::model::Geometry;
use dualbody::spatial::{Inertia, Symmetric3};
use dualbody::{Model, ModelOptions};
use nalgebra::Vector3;

/// A tetrahedron with a dent in its largest side, whose tip is the fifth vertex.
const VERTICES: [f32; 15] = [
    0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.4, 0.06, 0.09, 0.12,
];
const FACES: [i32; 18] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4, 2, 3, 4, 3, 1, 4];

/// Mass, centre of mass, and the moments xx, yy, zz, xy, xz, yz about it that `MuJoCo` finds; lengths there are in single precision.
const DENTED: [f64; 10] = [
    3.600000160932541,
    0.04833333370172315,
    0.07250000226000942,
    0.09666666740344632,
    0.0335375030933128,
    0.026830001950879055,
    0.017439501863862773,
    0.0027510002644696107,
    0.0036680002773961558,
    0.005502000554201097,
];
const HULL: [f64; 10] = [
    4.0000002781550155,
    0.050000000745058074,
    0.07500000298023225,
    0.10000000149011615,
    0.037500004430781254,
    0.030000002951838564,
    0.01950000260115867,
    0.0030000003517770017,
    0.004000000393335528,
    0.006000000730556831,
];
const SHELL: [f64; 10] = [
    208.7505075950017,
    0.046011452491110244,
    0.0798396820267429,
    0.11346049776279055,
    3.2007255779619017,
    2.54997658768597,
    1.6691525505967943,
    0.26705092618854687,
    0.3482907198072469,
    0.5450700095890539,
];
const SCALED: [f64; 10] = [
    3.240000144839287,
    0.02161291660744316,
    0.36930609841416295,
    0.20213773467260798,
    0.07211198628457649,
    0.06902399462287763,
    0.042381236835806954,
    0.01356601643949174,
    -0.0032229704807498487,
    -0.017482676565139372,
];

fn words<T: ToString>(numbers: &[T]) -> String {
    let words: Vec<String> = numbers.iter().map(T::to_string).collect();
    words.join(" ")
}

fn mesh() -> String {
    format!("vertex='{}' face='{}'", words(&VERTICES), words(&FACES))
}

fn xml(mesh: &str, geom: &str) -> String {
    format!(
        "<mujoco><asset><mesh name='dent' {mesh}/></asset>\n<worldbody><body name='b'><freejoint/><geom type='mesh' mesh='dent' {geom}/></body></worldbody></mujoco>"
    )
}

fn read(mesh: &str, geom: &str) -> (MjcfScene, ImportReport) {
    let loaded = ModelOptions::default().load_mjcf_scene_str(&xml(mesh, geom));
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

fn check(model: &Model, expected: &[f64; 10], tolerance: f64) {
    let own = model.link_inertias()[0];
    let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = *expected;
    let moments = Symmetric3::new(xx, xy, xz, yy, yz, zz);
    let com = Vector3::new(x, y, z);
    let theirs = Inertia::from_com(mass, &com, &moments);
    let error = (own.to_matrix() - theirs.to_matrix()).amax() / theirs.to_matrix().amax();
    assert!(error < tolerance, "{error:e}");
}

#[test]
fn inertia_of_vertices_equals_that_of_mujoco() {
    let whole = mesh();
    let with = |method: &str| format!("{whole} inertia='{method}'");
    let cloud = format!("vertex='{}'", words(&VERTICES));
    let placed = "density='300' pos='.1 .2 .3' euler='10 20 30'";
    for (mesh, geom, expected) in [
        (whole.clone(), "", DENTED),
        (with("exact"), "", DENTED),
        (with("convex"), "", HULL),
        (with("shell"), "", SHELL),
        (cloud, "", HULL),
        (format!("{whole} scale='1 2 -1.5'"), placed, SCALED),
    ] {
        let (scene, report) = read(&mesh, geom);
        assert!(
            report.ignored.is_empty() && report.warnings.is_empty(),
            "{report}"
        );
        // Scales act in single precision there.
        let tolerance = if geom.is_empty() { 1e-10 } else { 3e-8 };
        check(&scene.model, &expected, tolerance);
    }
}

/// The file of the mesh with a normal and two texture coordinates.
fn msh(faces: &[i32]) -> Vec<u8> {
    let counts = [5, 1, 2, faces.len() as i32 / 3];
    let tables = VERTICES.iter().chain(&[0.5; 7]);
    let words = counts.iter().map(|n| n.to_le_bytes());
    let words = words.chain(tables.map(|x| x.to_le_bytes()));
    let words = words.chain(faces.iter().map(|n| n.to_le_bytes()));
    words.flatten().collect()
}

fn stored(name: &str, bytes: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("{}_{name}", std::process::id()));
    fs::write(&path, bytes).expect("a file");
    path
}

#[test]
fn msh_files_are_read_as_mujoco_reads_them() {
    for (faces, expected) in [(&FACES[..], DENTED), (&[], HULL)] {
        let path = stored("dent.msh", &msh(faces));
        let (scene, report) = read(&format!("file='{}'", path.display()), "");
        let shapes = LinkShapes::new(&scene.model);
        fs::remove_file(&path).expect("the file");
        assert!(
            report.ignored.is_empty() && report.warnings.is_empty(),
            "{report}"
        );
        check(&scene.model, &expected, 1e-10);
        assert!(shapes.missing().is_empty(), "{:?}", shapes.missing());
    }
    let path = stored("cut.msh", &msh(&FACES)[..150]);
    let (_, report) = read(&format!("file='{}'", path.display()), "");
    fs::remove_file(&path).expect("the file");
    let says = "_cut.msh\" has 150 bytes, but its header counts 176";
    assert!(report.to_string().contains(says), "{report}");
}

/// Vertices survive both formats that are written, so that a robot needs no mesh file.
#[test]
fn vertices_are_written_and_read_again() {
    let (scene, _) = read(&mesh(), "mass='2'");
    let model = &scene.model;
    let from_urdf = Model::from_urdf_str(&model.to_urdf().expect("a URDF")).expect("a model");
    let text = model.to_mjcf().expect("an MJCF");
    assert!(text.contains(" vertex=\"0 0 0 "), "{text}");
    let (from_mjcf, report) = ModelOptions::default()
        .load_mjcf_str(&text)
        .expect("a model");
    assert!(report.ignored.is_empty(), "{report}");
    let shapes = |model: &Model| {
        let shapes = LinkShapes::new(model);
        assert!(shapes.missing().is_empty(), "{:?}", shapes.missing());
        shapes.shapes()[0].shape.clone()
    };
    assert_eq!(shapes(&from_urdf), shapes(model));
    assert_eq!(shapes(&from_mjcf), shapes(model));
}

#[test]
fn messages_about_vertices_name_the_mesh_and_not_its_content() {
    let flat = "vertex='0 0 0 1 0 0 0 1 0 1 1 0' face='0 1 2'";
    let (scene, report) = read(flat, "");
    let says = "the mesh \"data:model/obj;name=dent\" has no volume";
    assert!(report.to_string().contains(says), "{report}");
    let Geometry::Mesh { uri, path, .. } = &scene.model.links()[0].collisions[0].geometry else {
        panic!("a mesh")
    };
    assert!(uri.contains("v%201%201%200%0A") && path.is_none(), "{uri}");
    let broken = Model::from_urdf_str(
        "<robot name='r'><link name='l'><collision><geometry><mesh filename='data:model/obj;name=x,v 1 2'/></geometry></collision></link></robot>",
    );
    let broken = LinkShapes::new(&broken.expect("a model"));
    let reason = &broken.missing()[0].reason;
    let says = "the mesh data:model/obj;name=x has a vertex without three numbers on line 1";
    assert_eq!(reason, says);
    // It opens no other file.
    let curious = "data:model/obj,mtllib /etc/passwd%0Av 0 0 0%0Av 1 0 0%0Av 0 1 0%0Af 1 2 3";
    let curious = Model::from_urdf_str(&format!(
        "<robot name='r'><link name='l'><collision><geometry><mesh filename='{curious}'/></geometry></collision></link></robot>"
    ));
    assert!(
        LinkShapes::new(&curious.expect("a model"))
            .missing()
            .is_empty()
    );
}

#[test]
fn broken_vertices_are_errors_that_name_the_place() {
    for (mesh, says) in [
        ("vertex='0 0 0 1'", "expected three numbers for each vertex"),
        ("vertex='0 0 0 1 0 x'", "x"),
        ("vertex='0 0 nan'", "is not finite"),
        ("vertex='0 0 1e300'", "beyond single precision"),
        (
            "vertex='0 0 0 1 0 0' face='0 1'",
            "expected three vertices for each face",
        ),
        ("vertex='0 0 0 1 0 0' face='0 1 2'", "there is no vertex 2"),
        (
            "vertex='0 0 0 1 0 0' face='0 1 -1'",
            "there is no vertex -1",
        ),
        (
            "vertex='0 0 0 1 0 0' face='0 1 0.5'",
            "there is no vertex 0.5",
        ),
        (
            "vertex='0 0 0' inertia='none'",
            "expected one of legacy, exact",
        ),
    ] {
        let error = ModelOptions::default().load_mjcf_scene_str(&xml(mesh, ""));
        let error = error.map(|_| ()).unwrap_err().to_string();
        assert!(
            error.contains(says) && error.contains("MJCF text:1:"),
            "{error}\nnot: {says}"
        );
    }
    for (mesh, says) in [
        ("", "has no file and no vertices"),
        ("vertex=''", "has no vertices"),
        (
            "vertex='0 0 0 1 0 0 0 1 0 1 1 0'",
            "its vertices are in one plane",
        ),
    ] {
        let (_, report) = read(mesh, "");
        assert!(report.to_string().contains(says), "{report}\nnot: {says}");
    }
}

/// A large mesh that many geoms name does not take memory out of proportion.
#[test]
fn many_geoms_share_a_bounded_amount_of_vertices() {
    let many = words(&(0..120_000).map(|k| k % 97).collect::<Vec<i32>>());
    let geoms = "<geom type='mesh' mesh='m' mass='0'/>".repeat(200);
    let xml = format!(
        "<mujoco><asset><mesh name='m' vertex='{many}' face='0 1 2'/></asset><worldbody><body><geom size='1'/>{geoms}</body></worldbody></mujoco>"
    );
    let (model, report) = ModelOptions::default()
        .load_mjcf_str(&xml)
        .expect("a model");
    let kept = model.links().iter().map(|link| link.collisions.len());
    assert!((50..150).contains(&kept.sum::<usize>()));
    assert!(
        report
            .to_string()
            .contains("is too large for so many geoms"),
        "{report}"
    );
}
