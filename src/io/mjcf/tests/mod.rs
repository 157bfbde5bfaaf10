//! Files that name others.

use crate::error::LoadError;
use crate::io::temporary::Folder;
use crate::io::{MjcfTransmission, ModelOptions};

const LEG: &str =
    "<mujoco><worldbody><body name='leg'><joint name='hip'/><geom size='0.1'/></body></worldbody>
<actuator><motor name='m' joint='hip'/></actuator></mujoco>";

#[test]
fn a_file_that_includes_itself_is_an_error() {
    let folder = Folder::new();
    let path = folder.write("a.xml", "<mujoco>\n<include file='b.xml'/></mujoco>");
    folder.write(
        "b.xml",
        "<mujocoinclude><include file='a.xml'/></mujocoinclude>",
    );
    let error = ModelOptions::default().load_mjcf_file(&path).unwrap_err();
    assert!(
        matches!(error, LoadError::Include { line: 1, .. }),
        "{error}"
    );
    assert!(error.to_string().contains("includes itself"), "{error}");
    let itself = folder.write(
        "c.xml",
        "<mujoco><asset><model name='c' file='c.xml'/></asset></mujoco>",
    );
    let error = ModelOptions::default().load_mjcf_file(&itself).unwrap_err();
    assert!(error.to_string().contains("too many files"), "{error}");
}

#[test]
fn files_outside_of_the_allowed_folders_are_not_found_and_no_file_is_quoted() {
    let folder = Folder::new();
    folder.write("secret", "password");
    folder.write(
        "in/part.xml",
        "<mujocoinclude><worldbody><geom size='1'/></worldbody></mujocoinclude>",
    );
    let load = |include: &str| {
        let text = format!("<mujoco><include file='{include}'/></mujoco>");
        let path = folder.write("in/robot.xml", text);
        let options = ModelOptions::default().with_root(folder.path("in"));
        options.load_mjcf_file(path).map(|_| ())
    };
    assert!(load("part.xml").is_ok());
    let outside = load("../secret").unwrap_err().to_string();
    assert!(
        outside.contains("no such file below the root folders"),
        "{outside}"
    );
    folder.write("in/secret", "password");
    let inside = load("secret").unwrap_err().to_string();
    assert!(
        inside.contains("is not MJCF") && !inside.contains("password"),
        "{inside}"
    );
}

#[test]
fn attached_models_bring_their_actuators_under_a_prefix() {
    let folder = Folder::new();
    folder.write("leg.xml", LEG);
    let path = folder.write(
        "robot.xml",
        "<mujoco><asset><model name='leg' file='leg.xml'/></asset><worldbody><body name='hub'><joint name='turn'/><geom size='0.2'/>
         <attach model='leg' body='leg' prefix='l-'/><attach model='leg' body='leg' prefix='r-'/></body></worldbody></mujoco>",
    );
    let (scene, report) = ModelOptions::default().load_mjcf_scene_file(path).unwrap();
    assert!(report.ignored.is_empty(), "{report}");
    assert_eq!(scene.model.joint_names(), ["turn", "l-hip", "r-hip"]);
    let joints: Vec<_> = scene
        .actuation
        .iter()
        .map(|own| own.transmission.clone())
        .collect();
    let expected = ["l-hip", "r-hip"].map(|name| MjcfTransmission::Joint(name.into()));
    assert_eq!(joints, expected);
}

/// Triangles of a box of eight corners.
const BOX_FACES: &str = "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

#[test]
fn inertia_of_a_mesh_equals_that_of_the_box_it_is() {
    let folder = Folder::new();
    // Half edges 1, 2, 3 by the scale.
    let corners =
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    folder.write("meshes/cube.obj", format!("{corners}{BOX_FACES}"));
    let load = |geom: &str| {
        let text = format!(
            "<mujoco><compiler meshdir='meshes'/><asset><mesh name='cube' file='cube.obj' scale='1 2 3'/></asset>
             <worldbody><body name='b'><joint/><geom {geom} pos='0.1 0 0.3' density='10'/></body></worldbody></mujoco>"
        );
        let path = folder.write("robot.xml", text);
        let (model, report) = ModelOptions::default().load_mjcf_file(path).unwrap();
        assert!(
            report.warnings.is_empty() && report.ignored.is_empty(),
            "{report}"
        );
        model.bodies()[0].inertia.to_matrix()
    };
    let [mesh, solid] = ["type='mesh' mesh='cube'", "type='box' size='1 2 3'"].map(load);
    assert!(
        (mesh - solid).amax() < 1e-12 * solid.amax(),
        "{mesh}{solid}"
    );
}

// A box with a dent, and what MuJoCo 4.0 gives for the same text: `body_mass`, `body_ipos`, and `body_inertia` turned by `body_iquat`.
#[test]
fn inertia_of_a_dented_mesh_equals_that_of_mujoco() {
    let folder = Folder::new();
    let corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -0.5 -0.25 -0.5\nv -1 1 1\n";
    folder.write("dent.obj", format!("{corners}{BOX_FACES}"));
    let path = folder.write(
        "robot.xml",
        "<mujoco><asset><mesh name='a' file='dent.obj' scale='1 2 3'/></asset>
         <worldbody><body name='b'><joint/><geom type='mesh' mesh='a' density='10'/></body></worldbody></mujoco>",
    );
    let model = ModelOptions::default().load_mjcf_file(path).unwrap().0;
    let inertia = model.bodies()[0].inertia;
    let own = inertia.about_com();
    let found = [
        [inertia.mass, own.xx, own.yy, own.zz],
        [0.0, own.xy, own.xz, own.yz],
    ];
    let expected = [
        [
            275.06875767294247,
            1004.6976439648136,
            672.8004561826083,
            466.4804827785932,
        ],
        [0.0, 32.17212833991648, 55.78333088080173, 96.43250793891903],
    ];
    let com = [
        -0.2669860603057991,
        -0.23147963256886175,
        -0.8053928882882854,
    ];
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        // It keeps corners in single precision.
        assert!((found - expected).abs() < 1e-7 * 1e3, "{found} {expected}");
    }
    let off = inertia.com() - nalgebra::Vector3::from(com);
    assert!(off.amax() < 1e-6, "{off}");
}
