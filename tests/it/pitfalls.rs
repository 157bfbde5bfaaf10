//! Well-known defects of robot simulators, one test each, so that each is found where it is looked for.
//!
//! Tested here are those that have no better place; the others are tested where the feature is:
//!
//! | pitfall | test |
//! |---|---|
//! | potential energy with the wrong sign | `gravity_points_down_and_potential_energy_grows_with_height` |
//! | kinetic and potential energy do not add up to a constant | `energy_of_a_free_double_pendulum_stays_within_1e_6_over_ten_seconds` |
//! | no derivative in gravity or other parameters | `derivative_of_forces_accelerations_step_and_energies_in_all_parameters_equals_finite_differences` |
//! | joints of unusual kinds are dropped | `every_type_of_joint_equals_its_kind`, `types_equal_the_kinds_of_joints` |
//! | an axis that is missing or not normalised | `axis_equals_the_unit_vector_and_x_where_it_is_missing` |
//! | absent limits become zero; effort and velocity limits are not read | `limits_are_there_exactly_where_the_file_has_them`, `limits_equal_those_of_the_file_and_huge_or_negative_ones_are_none` |
//! | links without mass are dropped, or divide by zero | `massless_links_load_where_what_they_carry_resists`, `links_without_mass_keep_their_frames_shapes_and_joints` |
//! | mass, inertia or numbers that are impossible pass | `impossible_parts_equal_errors_that_name_them`, `numbers_that_are_not_finite_equal_errors_that_name_the_quantity` |
//! | inertias that no body has are refused, or pass in silence | `an_inertia_that_no_body_has_loads_with_its_eigenvalues_in_a_warning` |
//! | parts of a file are dropped in silence | `report_lists_every_unused_part_with_its_line` |
//! | meshes of packages are not found, or stop the loading | `package_reference_finds_the_file_in_every_place_that_may_hold_it`, `meshes_have_the_path_of_their_file_or_a_warning` |
//! | a file that is not a description, or xacro, ends in a panic | `unexpanded_xacro_equals_the_advice_to_run_xacro`, `any_damage_ends_in_a_model_or_an_error` |
//! | locked joints move what they carry | `dynamics_with_locked_joints_equal_those_with_joints_held`, `robot_with_joints_kept_at_load_equals_the_sum_of_its_locked_parts` |
//! | mimic joints are left out of some algorithms | `coupled_mass_matrix_equals_the_projected_free_one`, `coupled_forward_dynamics_obeys_the_projected_equation_of_motion` |
//! | rotor inertia and damping are read and not used | `armature_adds_to_the_inertia_of_the_joint_alone`, `viscous_damping_equals_exponential_decay` |
//! | order of quaternions | `quaternions_are_w_first`, `states_of_other_engines_differ_as_the_table_says` |
//! | order of spatial vectors | `spatial_vectors_are_linear_then_angular` |
//! | frame of the base velocity | `floating_base_comes_first_with_its_velocity_in_the_base_frame` |
//! | representations of accelerations lack a term | `frame_acceleration_equals_the_rate_of_the_velocity`, `equation_of_motion_holds_in_every_representation` |
//! | angles that wrap, or need two numbers | `angles_of_continuous_joints_are_not_wrapped` |
//! | quaternions lose their norm | `quaternions_stay_unit_over_a_million_steps` |
//! | random rotations are not uniform | `moments_of_random_rotations_equal_those_of_the_haar_measure` |
//! | random positions leave the limits | `random_states_are_within_all_limits_and_reach_them` |
//! | not-a-number runs on in silence | `diverging_rollout_ends_with_its_step_and_finite_states`, `each_wrong_number_of_a_state_equals_the_one_that_the_error_names` |
//! | robots without joints or without freedom break | `robot_that_cannot_move_is_simulated`, `no_dimension_of_a_robot_without_freedom_breaks_its_dynamics` |
//! | inputs or forces act on joints in another order | `inputs_act_on_the_named_joints_only_in_the_given_order` |
//! | constraints are accepted and left out of the dynamics, of J̇ v or of some integrators | `accelerations_of_linkages_equal_their_closed_forms`, `loop_stays_closed_and_energy_stays_as_the_integrator_is_exact` |
//! | redundant constraints break the solver | `weld_holds_a_body_and_carries_its_weight_even_twice` |
//! | stops pull, or add energy | `stops_of_any_stiffness_hold_from_both_sides_never_pull_and_never_add_energy` |

use std::collections::HashSet;
use std::path::Path;
use std::process::Command;

use dualbody::dynamics::{
    NamedForces, coriolis_matrix, forward_dynamics, inverse_dynamics, kinetic_energy, mass_matrix,
    mass_matrix_inverse,
};
use dualbody::joint::JointKind;
use dualbody::model::{Geometry, JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::spatial::{Force, Representation};
use dualbody::{Model, ModelOptions, Simulator};

use crate::common::{SAME_ALGEBRA, statue};

const INERTIAL: &str = r#"<inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;

fn link(name: &str, parts: &str) -> String {
    format!("<link name='{name}'>{parts}</link>")
}

fn joint(name: &str, kind: &str, parent: &str, child: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/></joint>"
    )
}

fn robot(parts: &[String]) -> String {
    format!("<robot name='r'>{}</robot>", parts.concat())
}

#[test]
fn robot_from_every_source_falls_down_with_the_same_gravity() {
    let mut builder = ModelBuilder::new("r");
    builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.0; 3], [1.0; 3]));
    let sdf = r#"<model name="r"><link name="body"><inertial><mass>1</mass>
        <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link></model>"#;
    let models = [
        builder.build(),
        Model::from_urdf_str(&robot(&[link("body", INERTIAL)])),
        Model::from_sdf_str(&format!("<sdf version='1.9'>{sdf}</sdf>")),
        Model::from_sdf_str(&format!(
            "<sdf version='1.9'><world name='w'><gravity>0 0 -9.81</gravity>{sdf}</world></sdf>"
        )),
        ModelOptions::default()
            .with_gravity([0.0, 0.0, -9.81])
            .load_urdf_str(&robot(&[link("body", INERTIAL)]))
            .map(|(model, _)| model),
    ];
    for model in models.map(|model| model.expect("a body")) {
        let zero = vec![0.0; model.nv()];
        let fall = forward_dynamics(&model, model.neutral().as_slice(), &zero, &zero);
        assert!((fall[2] + 9.81).abs() < SAME_ALGEBRA, "{}", model.name());
    }
}

#[test]
fn links_without_mass_keep_their_frames_shapes_and_joints() {
    let sphere = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
    let parts = [
        link("world", ""),
        link("arm", INERTIAL),
        link("sensor", sphere),
        link("tip", ""),
        joint("shoulder", "continuous", "world", "arm"),
        joint("mount", "fixed", "arm", "sensor"),
        joint("end", "fixed", "sensor", "tip"),
    ];
    let model = Model::from_urdf_str(&robot(&parts)).expect("a robot");
    assert_eq!(model.link_names(), ["world", "arm", "sensor", "tip"]);
    assert_eq!((model.n_bodies(), model.total_mass()), (1, 1.0));
    let shapes: Vec<usize> = (model.links().iter())
        .map(|link| link.collisions.len())
        .collect();
    assert_eq!(shapes, [0, 0, 1, 0]);
}

#[test]
fn shapes_of_every_kind_are_kept() {
    let shapes = [
        "<box size='1 2 3'/>",
        "<cylinder radius='1' length='2'/>",
        "<capsule radius='1' length='2'/>",
        "<sphere radius='1'/>",
        "<mesh filename='nowhere.stl'/>",
    ];
    let collisions =
        shapes.map(|shape| format!("<collision><geometry>{shape}</geometry></collision>"));
    let text = robot(&[link("body", &(INERTIAL.to_owned() + &collisions.concat()))]);
    let model = Model::from_urdf_str(&text).expect("a body");
    let kept = model.links()[0].collisions.iter();
    let kept: Vec<_> = kept
        .map(|collision| std::mem::discriminant(&collision.geometry))
        .collect();
    let distinct: HashSet<_> = kept.iter().collect();
    assert_eq!((kept.len(), distinct.len()), (shapes.len(), shapes.len()));
    let mesh = &model.links()[0].collisions[4].geometry;
    assert!(
        matches!(mesh, Geometry::Mesh { path: None, .. }),
        "{mesh:?}"
    );
}

#[test]
fn robot_that_hangs_on_the_world_by_several_joints_has_a_fixed_base() {
    for second in ["fixed", "continuous"] {
        let parts = [
            link("world", ""),
            link("left", INERTIAL),
            link("right", INERTIAL),
            joint("left_mount", "fixed", "world", "left"),
            joint("right_mount", second, "world", "right"),
        ];
        let model = Model::from_urdf_str(&robot(&parts)).expect("a robot");
        assert!(!model.has_floating_base(), "{second}");
        assert_eq!(model.nv(), usize::from(second == "continuous"));
    }
}

// Neither by name nor breadth first: so the coordinates of one file are the same everywhere.
#[test]
fn order_of_joints_and_coordinates_equals_that_of_the_file_depth_first() {
    let hinge = |name, parent, child| joint(name, "continuous", parent, child);
    let names = ["world", "z", "b", "a", "c"];
    let mut parts: Vec<String> = names.iter().map(|name| link(name, INERTIAL)).collect();
    parts.extend([
        hinge("z_joint", "world", "z"),
        hinge("a_joint", "world", "a"),
        hinge("b_joint", "z", "b"),
        hinge("c_joint", "z", "c"),
    ]);
    for _ in 0..3 {
        let model = Model::from_urdf_str(&robot(&parts)).expect("a robot");
        let expected = ["z_joint", "b_joint", "c_joint", "a_joint"];
        assert_eq!(model.joint_names(), expected);
        let starts = expected.map(|name| model.joint_v(model.joint(name).expect("a joint")).start);
        assert_eq!(starts, [0, 1, 2, 3]);
    }
}

#[test]
fn every_lookup_of_an_unknown_name_is_an_error_that_names_it() {
    let model = samples::arm();
    let mut forces = NamedForces::default();
    let push = Force::from_array([1.0; 6]);
    let errors = [
        model.find_joint("nobody").map(|_| ()),
        model.find_frame("nobody").map(|_| ()),
        model.parameter_layout().find("nobody").map(|_| ()),
        forces.set_joint_forces(&model, &[("nobody", &[1.0])]),
        forces.add_frame_force(&model, "nobody", &push, Representation::Body),
        Simulator::new(model.clone())
            .with_actuated_joints(&["nobody"])
            .map(|_| ()),
    ];
    for error in errors {
        let error = error.expect_err("an unknown name");
        assert_eq!(
            (error.name.as_str(), error.model.as_str()),
            ("nobody", model.name())
        );
        assert!(!error.known.is_empty());
    }
    let edits = [
        model.with_locked_joints(&[("nobody", &[0.0])]),
        model.with_kept_joints(&["nobody"], &[]),
    ];
    for error in edits {
        assert!(
            error
                .expect_err("an unknown name")
                .to_string()
                .contains("\"nobody\"")
        );
    }
}

#[test]
fn no_dimension_of_a_robot_without_freedom_breaks_its_dynamics() {
    let (model, none) = (statue(), [0.0; 0]);
    assert_eq!(mass_matrix(&model, &none).shape(), (0, 0));
    assert_eq!(kinetic_energy(&model, &none, &none), 0.0);
    assert!(mass_matrix_inverse(&model, &none).is_empty());
    assert!(coriolis_matrix(&model, &none, &none).is_empty());
    assert!(inverse_dynamics(&model, &none, &none, &none).is_empty());
    assert!(forward_dynamics(&model, &none, &none, &none).is_empty());
}

// A fixed link becomes part of the body that carries it, which also takes over its joints.
#[test]
fn fixed_joints_between_moving_ones_change_no_coordinate() {
    let build = |with_weld: bool| {
        let mut builder = ModelBuilder::new("r");
        for name in ["world", "a", "b"] {
            builder.add_link(LinkSpec::new(name).with_mass(1.0, [0.1, 0.2, 0.3], [1.0; 3]));
        }
        builder.add_joint(JointSpec::new("first", JointKind::Revolute, "world", "a"));
        let mut parent = "a";
        if with_weld {
            builder.add_link(LinkSpec::new("flange"));
            builder.add_joint(
                JointSpec::new("weld", JointKind::Fixed, "a", "flange")
                    .with_translation([0.5, 0.0, 0.0]),
            );
            parent = "flange";
        }
        let second = JointSpec::new("second", JointKind::Prismatic, parent, "b");
        builder.add_joint(second.with_translation(if with_weld {
            [0.0; 3]
        } else {
            [0.5, 0.0, 0.0]
        }));
        builder.build().expect("a robot")
    };
    let (plain, welded) = (build(false), build(true));
    assert_eq!(plain.joint_names(), welded.joint_names());
    let difference = mass_matrix(&plain, &[0.3, 0.4]) - mass_matrix(&welded, &[0.3, 0.4]);
    assert!(difference.amax() < SAME_ALGEBRA, "{difference}");
}

/// Environment variable that makes a process of this test print a robot.
const PRINT: &str = "DUALBODY_TEST_PRINT_A_ROBOT";

// Read in processes of their own: one as this one, one with another language, strange settings and no program to be
// found.
#[test]
fn robot_read_from_a_file_does_not_depend_on_the_environment() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/panda.urdf");
    if std::env::var_os(PRINT).is_some() {
        let model = Model::from_urdf_file(path).expect("the arm");
        println!("{:?} {:?}", model.bodies(), model.joints());
        return;
    }
    let numbers = |strange: bool| {
        let mut process = Command::new(std::env::current_exe().expect("this test"));
        process.env(PRINT, "1").args([
            "--exact",
            "pitfalls::robot_read_from_a_file_does_not_depend_on_the_environment",
            "--nocapture",
        ]);
        if strange {
            let settings = [
                ("LC_ALL", "de_DE.UTF-8"),
                ("LANG", "de_DE.UTF-8"),
                ("PATH", ""),
            ];
            process.envs(settings).env("ROS_PACKAGE_PATH", "/nowhere");
        }
        let output = process.output().expect("this test again");
        let text = String::from_utf8(output.stdout).expect("text");
        let line = text.lines().find(|line| line.contains("Body {"));
        line.unwrap_or_else(|| panic!("no robot: {text}"))
            .to_owned()
    };
    assert_eq!(numbers(false), numbers(true));
}

/// All sources below a folder, as one text.
fn sources(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let text = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => sources(&path),
            false => std::fs::read_to_string(path).unwrap_or_default(),
        }
    };
    entries.map(text).collect()
}

#[test]
fn every_test_that_the_table_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = sources(&root.join("src")) + &sources(&root.join("tests/it"));
    let rows = include_str!("pitfalls.rs").lines();
    let rows: Vec<&str> = rows
        .filter(|line| line.starts_with("//! | "))
        .skip(1)
        .collect();
    assert!(rows.len() > 20);
    for row in rows {
        let tests: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        assert!(!tests.is_empty(), "{row}");
        for test in tests {
            assert!(sources.contains(&format!("fn {test}(")), "{test}");
        }
    }
}
