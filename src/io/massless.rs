//! Treatment of moving links without inertia.

use std::collections::HashSet;

use crate::error::{LoadError, SingularMassMatrix};
use crate::model::{Joint, Model, ModelBuilder};
use crate::spatial::Inertia;

/// Treatment of moving links without inertia, whose motion nothing resists: they make the mass matrix singular.
///
/// This does not concern links without inertia that carry links with enough inertia (the cross of a universal joint), or whose joint has a rotor
/// inertia, or is a mimic joint of a heavier link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MasslessLinks {
    /// Massless links are kept, with a warning: kinematics and inverse dynamics work; forward dynamics and simulators refuse the robot, see
    /// [`Model::check_mass_matrix`].
    #[default]
    Kept,
    /// Massless links are an error, [`LoadError::MissingInertia`].
    Refused,
    /// The inertia of a solid ball at the origin is added to massless links.
    SolidBall {
        /// Mass of the ball, kg.
        mass: f64,
        /// Radius of the ball, m.
        radius: f64,
    },
}

impl MasslessLinks {
    /// Builds the model and does with such links what is requested.
    pub(super) fn build(self, parts: &mut ModelBuilder) -> Result<Model, LoadError> {
        let model = parts.build()?;
        match self {
            Self::Kept => Ok(model),
            Self::Refused => model.check_mass_matrix().map(|()| model).map_err(|source| {
                let file = parts.source.clone();
                LoadError::MissingInertia { file, source }
            }),
            Self::SolidBall { mass, radius } => {
                add_to_unresisted(parts, model, &Inertia::solid_sphere(mass, radius))
            }
        }
    }
}

/// Adds an inertia to every link that nothing resists the motion of, until all are resisted or more inertia changes
/// nothing.
fn add_to_unresisted(
    parts: &mut ModelBuilder,
    mut model: Model,
    added: &Inertia<f64>,
) -> Result<Model, LoadError> {
    let mut before = usize::MAX;
    while let Err(SingularMassMatrix { joints, .. }) = model.check_mass_matrix()
        && joints.len() < before
    {
        before = joints.len();
        parts.add_inertia(joints.iter().map(|at| at.link.as_str()), added);
        model = parts.build()?;
    }
    Ok(model)
}

/// A remark on a joint whose link has no inertia.
pub(super) struct Remark {
    /// The name of the joint; `None` for a floating base.
    pub(super) joint: Option<String>,
    pub(super) reason: String,
    /// Whether the links that it carries resist the joint.
    pub(super) is_carried: bool,
}

/// Remarks on the joints that nothing resists, and on those that only what their link carries does.
pub(super) fn remarks(model: &Model) -> Vec<Remark> {
    let unresisted = model.check_mass_matrix().err();
    let unresisted = unresisted.map_or_else(Vec::new, |error| error.joints);
    let names: HashSet<&str> = unresisted
        .iter()
        .filter_map(|at| at.joint.as_deref())
        .collect();
    // Followers are moved by their leaders.
    let is_massless = |joint: &&Joint| {
        let body = model.body(joint.body);
        body.inertia == Inertia::zero() && body.coupling.is_none()
    };
    let others = model.joints().iter().filter(is_massless);
    let others = others.filter(|joint| !names.contains(joint.name.as_str()));
    let carried = others.map(|joint| Remark {
        joint: Some(joint.name.clone()),
        reason: "the link that it moves has no inertia: only what that one carries resists".into(),
        is_carried: true,
    });
    let free = unresisted.iter().map(|at| Remark {
        joint: at.joint.clone(),
        reason: format!(
            "nothing resists its motion (inertia {:e} at link \"{}\"): the mass matrix is singular, forward dynamics and simulators refuse \
             the robot; see the option massless_links",
            at.inertia, at.link
        ),
        is_carried: false,
    });
    carried.chain(free).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{inverse_dynamics, mass_matrix};
    use crate::io::ModelOptions;
    use crate::tests::OTHER_ALGORITHM;
    use crate::{Simulator, State};

    /// A gripper on an arm, whose two fingers have no inertia; the second follows the first.
    const GRIPPER: &str = "<robot name='gripper'><link name='world'/>
<link name='arm'><inertial><mass value='2'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>
<link name='a'/><link name='b'/><link name='c'/>
<joint name='lift' type='prismatic'><parent link='world'/><child link='arm'/><axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint>
<joint name='fa' type='continuous'><parent link='arm'/><child link='a'/><axis xyz='1 0 0'/></joint>
<joint name='fb' type='continuous'><parent link='arm'/><child link='b'/><axis xyz='1 0 0'/><mimic joint='fa'/></joint>
<joint name='fc' type='continuous'><parent link='arm'/><child link='c'/><axis xyz='0 1 0'/></joint></robot>";

    #[test]
    fn massless_links_load_with_a_warning_each_and_inverse_dynamics_is_that_of_the_others() {
        let (model, report) = ModelOptions::default().load_urdf_str(GRIPPER).unwrap();
        let warned: Vec<_> = (report.warnings.iter())
            .filter(|note| note.reason.contains("massless_links"))
            .map(|note| (note.name.as_str(), note.line))
            .collect();
        assert_eq!(warned, [("fa", 5), ("fc", 7)], "{report}");
        // τ = m (z̈ + g) on the slide, nothing elsewhere.
        let tau = inverse_dynamics(&model, &[0.1, 0.2, 0.3], &[1.0, 2.0, 3.0], &[0.5, 7.0, 8.0]);
        assert_eq!(tau.as_slice(), [2.0 * (0.5 + 9.81), 0.0, 0.0]);
        assert_eq!(mass_matrix(&model, &[0.1, 0.2, 0.3]).trace(), 2.0);
    }

    #[test]
    fn refused_massless_links_are_one_error_that_names_them_all() {
        let options = ModelOptions::default().with_massless_links(MasslessLinks::Refused);
        let error = options.load_urdf_str(GRIPPER).unwrap_err();
        let LoadError::MissingInertia { source, .. } = &error else {
            panic!("{error}")
        };
        let links: Vec<_> = source.joints.iter().map(|at| at.link.as_str()).collect();
        assert_eq!(links, ["a", "c"]);
        assert!(error.to_string().starts_with("URDF text: "), "{error}");
        assert!(options.load_urdf_file("assets/quadruped.urdf").is_ok());
    }

    #[test]
    fn links_with_a_ball_accelerate_as_its_moment_of_inertia_says() {
        let ball = MasslessLinks::SolidBall {
            mass: 0.5,
            radius: 0.2,
        };
        let options = ModelOptions::default().with_massless_links(ball);
        let model = options.load_urdf_str(GRIPPER).unwrap().0;
        // The ball is on the joint's axis: J = 2/5 m r².
        let a = crate::dynamics::forward_dynamics(&model, &[0.0; 3], &[0.0; 3], &[0.0, 0.0, 1.0]);
        assert!(
            (a[2] - 1.0 / (0.4 * 0.5 * 0.04)).abs() < OTHER_ALGORITHM,
            "{a}"
        );
        let next = Simulator::new(model).step(&State::new(&[0.0; 3], &[0.0; 3]), &[0.0; 3]);
        assert!(next.is_finite());
    }

    #[test]
    #[should_panic(
        expected = "joint \"fa\" (link \"a\", inertia 0e0), joint \"fc\" (link \"c\", inertia 0e0)"
    )]
    fn simulator_of_massless_links_panics_with_all_their_names() {
        let model = Model::from_urdf_str(GRIPPER).unwrap();
        let _ = Simulator::new(model);
    }
}
