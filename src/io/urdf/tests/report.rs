//! Nothing is lost silently.

use super::*;
use crate::model::Base;

#[test]
fn report_lists_every_unused_part_with_its_line() {
    let text = arm_on(&joint("continuous", "<limit lower='-1' effort='2' velocity='3' jerk='4'/>\n<calibration rising='0'/>\n<safety_controller k_velocity='1'/>\n<axis xyz='0 0 1'/><axis xyz='1 0 0'/>"))
        .replace("</robot>", "\n<transmission name='t'><actuator name='m'/></transmission>\n<gazebo reference='arm'><gravity>false</gravity><mu1>0.2</mu1></gazebo><gazebo reference='arm'><material>Red</material></gazebo>\n<unknown/>stray text</robot>");
    let (model, report) = load(&text);
    assert_eq!(model.joints()[0].axis, nalgebra::Vector3::z());
    assert_eq!(
        places(&report.ignored),
        [
            ("robot", "r", 1),
            ("robot/joint/limit@jerk", "j", 1),
            ("robot/joint/limit@lower", "j", 1),
            ("robot/joint/calibration", "j", 2),
            ("robot/joint/safety_controller", "j", 3),
            ("robot/joint/axis", "j", 4),
            ("robot/transmission", "t", 5),
            ("robot/gazebo/mu1", "arm", 6),
            ("robot/gazebo", "arm", 6),
            ("robot/unknown", "", 7),
        ]
    );
    assert_eq!(places(&report.warnings), []);
    let table = report.to_string();
    assert!(table.contains("<mu1> 0.2 of another simulator is not modelled"));
    assert!(table.contains("limits of position, speed and effort (1 joints)"));
    assert!(table.contains("line 5: robot/transmission \"t\": a transmission without a type"));
}

#[test]
fn report_lists_unused_parts_of_links() {
    let parts = r#"<link name="arm" type="x">
      <visual><geometry><box size="1 1 1"/><sphere radius="1"/></geometry>
        <material name="m"><texture/></material></visual>
      <visual><geometry><ellipsoid/></geometry></visual>
      <visual/>
      <collision><geometry><box size="1 1 1"/></geometry><verbose value="1"/></collision>
      INERTIAL<sensor/></link>"#;
    let (model, report) = load(&robot(&parts.replace("INERTIAL", INERTIAL)));
    assert_eq!(model.links()[0].visuals.len(), 1);
    assert_eq!(
        places(&report.ignored),
        [
            ("robot/link@type", "arm", 1),
            ("robot/link/visual/geometry/sphere", "arm", 2),
            ("robot/link/visual/material/texture", "arm", 3),
            ("robot/link/visual/geometry/ellipsoid", "arm", 4),
            ("robot/link/visual", "arm", 4),
            ("robot/link/visual", "arm", 5),
            ("robot/link/collision/verbose", "arm", 6),
            ("robot/link/sensor", "arm", 7),
        ]
    );
}

#[test]
fn motion_of_a_fixed_joint_is_ignored_whatever_it_says() {
    let parts = "<axis xyz='0 0 0'/><limit lower='x'/><dynamics friction='1'/><mimic/>";
    let (model, report) = load(&arm_on(&joint("fixed", parts)));
    assert_eq!((model.nv(), report.ignored.len()), (0, 4));
    assert_eq!(report.warnings, []);
}

#[test]
fn warnings_equal_what_may_not_mean_what_its_author_wanted() {
    let reasons = |parts: &str| -> Vec<String> {
        let (_, report) = load(&arm_on(&joint("revolute", parts)));
        let reasons = report.warnings.into_iter();
        reasons.map(|warning| warning.reason).collect()
    };
    let limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
    let axis = "<axis xyz='0 0 1'/>";
    assert_eq!(reasons(&[limit, axis].concat()), [""; 0]);
    for (parts, expected) in [
        (limit.to_owned(), "no <axis>: taken as 1 0 0"),
        (axis.to_owned(), "no <limit>"),
        (
            [limit, axis, "<dynamics friction='0.5'/>"].concat(),
            "friction 0.5",
        ),
        (
            [limit, axis].concat().replace("'-1'", "'1'"),
            "no room to move",
        ),
        (
            [limit, axis].concat().replace("effort='1'", "effort='inf'"),
            "effort is infinite",
        ),
        (
            [limit, axis].concat().replace("effort='1'", "effort='0'"),
            "effort is limited to 0",
        ),
    ] {
        let reasons = reasons(&parts);
        assert!(
            reasons.len() == 1 && reasons[0].contains(expected),
            "{expected}: {reasons:?}"
        );
    }
}

#[test]
fn an_inertia_that_no_body_has_loads_with_its_eigenvalues_in_a_warning() {
    let text = arm_on(&joint("fixed", "")).replace("ixx=\"1\"", "ixx=\"2.5\"");
    let (model, report) = load(&text);
    assert_eq!(model.to_builder().links[1].inertia.rotational.xx, 2.5);
    let warning = report.warnings[0].to_string();
    for part in [
        "line 1",
        "\"arm\"",
        "triangle",
        "1.000000e0, 1.000000e0, 2.500000e0",
    ] {
        assert!(warning.contains(part), "{part} is not in: {warning}");
    }
}

#[test]
fn massless_links_load_where_what_they_carry_resists() {
    let link = |name: &str, inertial: &str| format!("<link name='{name}'>{inertial}</link>");
    let edge = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><axis xyz='{axis}'/></joint>"
        )
    };
    let links = [link("world", ""), link("cross", ""), link("arm", INERTIAL)].concat();
    let joints = [
        edge("u", "world", "cross", "1 0 0"),
        edge("v", "cross", "arm", "0 1 0"),
    ];
    let (model, report) = load(&robot(&(links.clone() + &joints.concat())));
    assert_eq!(model.nv(), 2);
    assert_eq!(places(&report.warnings), [("robot/joint", "u", 1)]);
    // Seven free directions have one too many for one rigid body.
    let floating = joints
        .concat()
        .replacen("type='continuous'", "type='floating'", 1);
    let (model, report) = load(&robot(&(links + &floating)));
    assert_eq!(
        model.check_mass_matrix().unwrap_err().joints[0].link,
        "cross"
    );
    assert_eq!(places(&report.warnings), [("robot/joint", "u", 1)]);
}

#[test]
fn base_equals_what_the_root_link_and_the_options_say() {
    let on = |root: &str| arm_on(&joint("fixed", "")).replace("world", root);
    for (root, base, expected, root_link) in [
        ("world", Base::Auto, Base::Fixed, "world"),
        ("pelvis", Base::Auto, Base::Floating, "pelvis"),
        ("pelvis", Base::Fixed, Base::Fixed, "pelvis"),
        ("world", Base::Floating, Base::Floating, "arm"),
    ] {
        let options = ModelOptions::default().with_base(base);
        let (model, report) = options.load_urdf_str(&on(root)).unwrap();
        let found = (report.base, report.root_link.as_str());
        assert_eq!(found, (expected, root_link), "{root} {base:?}");
        assert_eq!(model.nv(), if expected == Base::Floating { 6 } else { 0 });
    }
}

// Who loads without the report finds its lines at the model, and variants and other scalars keep them.
#[test]
fn remarks_of_a_model_are_the_lines_of_the_report() {
    let text = arm_on(&joint(
        "continuous",
        "<limit effort='2' velocity='3'/><calibration rising='0'/>",
    ));
    let (model, report) = load(&text);
    assert_eq!(model.remarks(), report.remarks());
    assert!(report.base_note().is_some() && report.limits_note().is_some());
    assert_eq!(
        report.remarks().len(),
        2 + report.warnings.len() + report.ignored.len()
    );
    let variant = model.cast::<num_dual::Dual64>();
    assert_eq!(variant.remarks(), model.remarks());
    assert!(crate::model::samples::cartpole().remarks().is_empty());
}
