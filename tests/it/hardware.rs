//! Sizes and densities of links as parameters: against closed forms, another engine, and robots that are built anew.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::contact::{ContactLaw, Contacts, Feature, SoftContact, Terrain};
use dualbody::dynamics::{center_of_mass, gravity_forces, inverse_dynamics, mass_matrix};
use dualbody::error::EditError;
use dualbody::joint::JointKind;
use dualbody::linearize::{RolloutCost, RolloutGradientOptions, WantedParameters};
use dualbody::model::{
    Collision, Dimension, Geometry, Hardware, JointSpec, LinkShape, LinkSpec, Mass,
    MassDistribution, Model, ModelBuilder, ScaledLink, UpAxis, Visual,
};
use dualbody::scalar::Dual;
use dualbody::spatial::{Inertia, Quaternion, Transform};
use dualbody::{Integrator, Lanes, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, asset, random_point,
};

const ASSETS: [&str; 12] = [
    "acrobot.urdf",
    "box.urdf",
    "cartpole.urdf",
    "double_pendulum.urdf",
    "four_bar.urdf",
    "hopper.urdf",
    "humanoid.urdf",
    "panda.urdf",
    "quadrotor.urdf",
    "quadruped.urdf",
    "sphere.urdf",
    "ur5.urdf",
];

/// One free direction.
type Along = Dual<f64, 1>;

fn pose(turn: [f64; 3], at: [f64; 3]) -> Transform<f64> {
    Transform::new(Quaternion::exp(&turn.into()).to_matrix(), at.into())
}

/// A link that is a solid in a place, to show and to touch, of 700 kg/m³.
fn solid(name: &str, geometry: Geometry, placement: Transform<f64>) -> LinkSpec {
    let inertia = geometry.inertia(Mass::Density(700.0)).expect("no mesh");
    let collision = Collision {
        name: None,
        placement,
        geometry: geometry.clone(),
    };
    LinkSpec::new(name)
        .with_inertia(placement.inertia(&inertia))
        .with_collision(collision)
        .with_visual(Visual {
            name: None,
            placement,
            geometry,
            color: None,
        })
}

/// A chain of one link of each shape, turned and shifted; a foot that is fixed to the last but one, and a frame.
fn chain() -> Model {
    let shapes = [
        Geometry::Box {
            size: [0.3, 0.2, 0.1],
        },
        Geometry::Cylinder {
            radius: 0.05,
            length: 0.4,
        },
        Geometry::Capsule {
            radius: 0.04,
            length: 0.3,
        },
        Geometry::Sphere { radius: 0.07 },
    ];
    let mut builder = ModelBuilder::new("chain");
    for (k, shape) in shapes.into_iter().enumerate() {
        let turned = pose([0.3 * k as f64, 0.2, -0.1], [0.02, 0.01, -0.15]);
        builder.add_link(solid(&format!("link{k}"), shape, turned));
        if k > 0 {
            let kind = [JointKind::Revolute, JointKind::Fixed][usize::from(k == 3)];
            let (name, parent) = (format!("joint{k}"), format!("link{}", k - 1));
            let joint = JointSpec::new(name, kind, parent, format!("link{k}"));
            let placed = joint.with_placement(pose([0.1, -0.2, 0.3], [0.03, -0.02, -0.25]));
            builder.add_joint(placed.with_axis([0.0, 0.6, 0.8]).with_damping(0.2));
        }
    }
    builder.add_frame("tip", "link2", pose([0.0, 0.4, 0.0], [0.0, 0.01, -0.3]));
    builder.build().expect("a robot that is known to be right")
}

fn all_of(model: &Model) -> Hardware {
    Hardware::new(model, &ScaledLink::all_of(model)).expect("shapes with sizes")
}

/// Largest difference of all numbers that dynamics depend on, and of all poses, beside the largest.
fn distance(a: &Model, b: &Model) -> f64 {
    let parameters = (a.parameters() - b.parameters()).amax() / b.parameters().amax();
    let bodies = a.bodies().iter().zip(b.bodies());
    let placements = bodies.map(|(a, b)| (a.placement, b.placement));
    let frames = a.frames().iter().zip(b.frames());
    let poses = placements.chain(frames.map(|(a, b)| (a.placement, b.placement)));
    let off = |(a, b): (Transform<f64>, Transform<f64>)| {
        (a.rotation - b.rotation)
            .amax()
            .max((a.translation - b.translation).amax())
    };
    poses.map(off).fold(parameters, f64::max)
}

#[test]
fn robots_at_their_own_sizes_are_what_they_are() {
    let robots = ASSETS.map(asset);
    for model in robots.iter().chain([&chain()]) {
        let hardware = all_of(model);
        assert!(!hardware.names().is_empty(), "{}", model.name());
        let same = hardware.model(hardware.nominal()).unwrap();
        let off = distance(&same, model);
        assert!(off < 10.0 * ROUNDING, "{}: {off:e}", model.name());
        let shapes = |model: &Model| {
            let links = model.links().iter();
            let shapes = links.map(|link| (link.visuals.clone(), link.collisions.clone()));
            shapes.collect::<Vec<_>>()
        };
        assert_eq!(shapes(&same), shapes(model), "{}", model.name());
    }
}

// A change of all sizes by s and all densities by ρ equals `Model::scaled`, by the laws of dimensions.
#[test]
fn uniform_change_of_all_sizes_equals_the_scaled_robot() {
    const S: f64 = 1.7;
    const RHO: f64 = 0.6;
    for masses in [MassDistribution::Described, MassDistribution::Homogeneous] {
        let model = chain();
        let chosen = ScaledLink::all_of(&model).into_iter();
        let chosen = chosen.map(|link| link.with_mass_distribution(masses));
        let hardware = Hardware::new(&model, &chosen.collect::<Vec<_>>()).unwrap();
        let names = hardware.names().iter().zip(hardware.nominal());
        let factor = |name: &str| if name.ends_with("density") { RHO } else { S };
        let x: Vec<f64> = names.map(|(name, x)| x * factor(name)).collect();
        let (actual, expected) = (hardware.model(&x).unwrap(), model.scaled(S, RHO).unwrap());
        let off = distance(&actual, &expected);
        assert!(off < 10.0 * SAME_ALGEBRA, "{masses:?}: {off:e}");
    }
}

// The parts of a box's inertia are known in each of its edges: J_x = ρ x y z (y² + z²) / 12.
#[test]
fn inertia_of_a_box_and_its_derivative_in_an_edge_equal_the_closed_form() {
    let mut builder = ModelBuilder::new("box");
    builder.add_link(LinkSpec::solid_box(
        "box",
        [0.3, 0.2, 0.1],
        Mass::Density(500.0),
    ));
    let chosen = ScaledLink::new("box", &[Dimension::Y, Dimension::Density]);
    let hardware = Hardware::new(&builder.build().unwrap(), &[chosen]).unwrap();
    assert_eq!(hardware.names(), ["box: y", "box: density"]);
    let (y, rho) = (0.4, 900.0);
    let wide = hardware
        .model(&[Along::variable(y, 0), rho.into()])
        .unwrap();
    let inertia = wide.bodies()[0].inertia;
    let (x, z) = (0.3, 0.1);
    let pairs = [
        (inertia.mass, rho * x * y * z, rho * x * z),
        (
            inertia.rotational.xx,
            rho * x * y * z * (y * y + z * z) / 12.0,
            rho * x * z * (3.0 * y * y + z * z) / 12.0,
        ),
        (
            inertia.rotational.yy,
            rho * x * y * z * (x * x + z * z) / 12.0,
            rho * x * z * (x * x + z * z) / 12.0,
        ),
    ];
    for (actual, value, slope) in pairs {
        assert!(
            (actual.re - value).abs() < SAME_ALGEBRA * value,
            "{actual:?}"
        );
        assert!(
            (actual.eps[0] - slope).abs() < SAME_ALGEBRA * slope,
            "{actual:?}"
        );
    }
}

// A thin rod that hangs by its end: T = 2π √(2 l / 3 g), dT/dl = T / 2 l.
#[test]
fn period_of_a_rod_and_its_derivative_in_the_length_equal_the_closed_form() {
    let mut builder = ModelBuilder::new("rod");
    let rod = Geometry::Cylinder {
        radius: 1e-8,
        length: 1.0,
    };
    let below = Transform::from_translation(Vector3::new(0.0, 0.0, -0.5));
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(solid("rod", rod, below));
    let hinge = JointSpec::new("hinge", JointKind::Continuous, "world", "rod");
    builder.add_joint(hinge.with_axis([0.0, 1.0, 0.0]));
    let chosen = [ScaledLink::new("rod", &[Dimension::Length])];
    let hardware = Hardware::new(&builder.build().unwrap(), &chosen).unwrap();
    let length = 1.4909;
    let rod = hardware.model(&[Along::variable(length, 0)]).unwrap();
    let q = [Along::from(FRAC_PI_2)];
    // The torque m g l / 2 that holds it out, by J, is the square of the frequency of small swings.
    let square = gravity_forces(&rod, &q)[0] / mass_matrix(&rod, &q)[0];
    let period = Along::from(2.0 * PI) / square.sqrt();
    let expected = 2.0 * PI * (2.0 * length / (3.0 * 9.81)).sqrt();
    assert!((period.re - expected).abs() < SAME_ALGEBRA * expected);
    let slope = expected / (2.0 * length);
    assert!((period.eps[0] - slope).abs() < SAME_ALGEBRA * slope);
}

/// A box, a cylinder and a sphere, as `JaxSim` has them below.
const LIMB: &str = r#"<robot name="limb">
  <link name="base">
    <inertial><mass value="6"/><inertia ixx="0.065" iyy="0.1" izz="0.125" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.4 0.3 0.2"/></geometry></visual>
  </link>
  <link name="arm">
    <inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
      <inertia ixx="0.06125" iyy="0.06125" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 -0.3"/><geometry><cylinder radius="0.05" length="0.6"/></geometry></visual>
  </link>
  <link name="tip">
    <inertial><origin xyz="0.02 0 -0.1"/><mass value="1"/>
      <inertia ixx="0.00256" iyy="0.00256" izz="0.00256" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0.02 0 -0.1"/><geometry><sphere radius="0.08"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute"><origin xyz="0.1 0.05 -0.1"/><parent link="base"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
  <joint name="wrist" type="revolute"><origin xyz="0.01 0.02 -0.6"/><parent link="arm"/><child link="tip"/>
    <axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
</robot>"#;

// JaxSim 0.9.0 in double precision (jax 0.10.2, rod 0.5.0), the same robot as SDF: `update_hw_parameters` with the factors (1.5, 0.8, 1.2) for the edges of the base,
// 1.1 and 1.7 for radius and length of the arm, 0.7 for the radius of the tip, 0.9, 1.3 and 2 for the densities; then masses, centres of mass and moments about them,
// origins of joints, `free_floating_mass_matrix` of the joints and `com_position` at (0.4, −0.7), and `jax.grad` of the first entry of that matrix in the factor of the
// arm's length.
#[test]
fn sizes_of_a_limb_equal_those_of_jaxsim() {
    let model = Model::from_urdf_str(LIMB).unwrap();
    for masses in [MassDistribution::Described, MassDistribution::Homogeneous] {
        let chosen = ScaledLink::all_of(&model).into_iter();
        let chosen = chosen.map(|link| link.with_mass_distribution(masses));
        let hardware = Hardware::new(&model, &chosen.collect::<Vec<_>>()).unwrap();
        let factors = [1.5, 0.8, 1.2, 0.9, 1.1, 1.7, 1.3, 0.7, 2.0];
        let pairs = hardware.nominal().iter().zip(factors);
        let x: Vec<f64> = pairs.map(|(x, factor)| x * factor).collect();
        let description = hardware.description(&x).unwrap();
        let expected = [
            (7.776, [0.0, 0.0, 0.0], [0.0746496, 0.2706048, 0.2706048]),
            (
                5.3482,
                [0.0, 0.0, -0.51],
                [0.46773351625, 0.46773351625, 0.0080891525],
            ),
            (0.686, [0.014, 0.0, -0.07], [0.0008605184; 3]),
        ];
        for (link, (mass, com, moments)) in description.links.iter().zip(expected) {
            let inertia = &link.inertia;
            let about_com = inertia.about_com();
            assert!(
                (inertia.mass - mass).abs() < SAME_ALGEBRA,
                "{masses:?}, {}",
                &link.name
            );
            assert!((inertia.com() - Vector3::from(com)).amax() < SAME_ALGEBRA);
            let off = about_com.to_matrix() - nalgebra::Matrix3::from_diagonal(&moments.into());
            assert!(
                off.amax() < SAME_ALGEBRA,
                "{masses:?}, {}: {off}",
                &link.name
            );
        }
        let origins = [[0.15, 0.04, -0.12], [0.011, 0.022, -1.02]];
        for (joint, origin) in description.joints.iter().zip(origins) {
            assert!((joint.placement.translation - Vector3::from(origin)).amax() < ROUNDING);
        }
        let duals: Vec<Along> = x.iter().map(|&x| x.into()).collect();
        let scaled = hardware.model(&duals).unwrap();
        let mut q: Vec<Along> = model.neutral().iter().map(|&x| x.into()).collect();
        (q[7], q[8]) = (0.4.into(), (-0.7).into());
        let actual = mass_matrix(&scaled, &q).view((6, 6), (2, 2)).map(|x| x.re);
        let (m00, m01, m11) = (2.6506949209672115, 0.00077338333352885, 0.0042219184);
        let expected = DMatrix::from_row_slice(2, 2, &[m00, m01, m01, m11]);
        assert!((actual - expected).amax() < SAME_ALGEBRA);
        let com = center_of_mass(&scaled, &q).map(|x| x.re);
        let expected = [
            -0.03099379559579944,
            0.01633029692972197,
            -0.2839470234622239,
        ];
        assert!((com - Vector3::from(expected)).amax() < SAME_ALGEBRA);
        let length = hardware.find("arm: length").unwrap();
        let mut duals = duals;
        duals[length] = Along::variable(x[length], 0);
        let slope = mass_matrix(&hardware.model(&duals).unwrap(), &q)[(6, 6)].eps[0] * 0.6;
        assert!(
            (slope - 4.159214828700082).abs() < OTHER_ALGORITHM,
            "{slope}"
        );
    }
}

/// All sizes and densities changed, each differently.
fn changed(hardware: &Hardware) -> Vec<f64> {
    let values = hardware.nominal().iter().enumerate();
    values
        .map(|(k, x)| x * (0.8 + 0.05 * ((7 * k) % 11) as f64))
        .collect()
}

#[test]
fn urdf_of_a_changed_robot_loads_to_the_same_robot() {
    let robots = ASSETS.map(asset);
    for model in robots.iter().chain([&chain()]) {
        let hardware = all_of(model);
        let other = hardware.model(&changed(&hardware)).unwrap();
        let loaded = Model::from_urdf_str(&other.to_urdf().unwrap()).unwrap();
        assert!(distance(&other, model) > 0.01, "{}", model.name());
        let off = distance(&loaded, &other);
        assert!(off < SAME_ALGEBRA, "{}: {off:e}", model.name());
        let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
        let contacts = |model: &Model| Contacts::new(model, Terrain::flat(0.0), law);
        assert_same_points(
            &contacts(&loaded),
            &contacts(&other),
            SAME_ALGEBRA,
            model.name(),
        );
    }
}

#[test]
fn description_of_a_changed_robot_builds_the_same_robot() {
    let hardware = all_of(&chain());
    let x = changed(&hardware);
    let built = hardware.description(&x).unwrap().build().unwrap();
    let over = hardware.model(&x).unwrap();
    assert_eq!(distance(&built, &over), 0.0);
    assert_eq!(over.to_builder(), hardware.description(&x).unwrap());
}

/// Numbers of a feature: axis and radius.
fn numbers_of(feature: &Feature) -> Vec<f64> {
    match *feature {
        Feature::Corner => vec![],
        Feature::Sphere { radius } => vec![radius],
        Feature::Rim {
            axis,
            radius,
            angle,
        } => vec![axis.x, axis.y, axis.z, radius, angle],
        _ => panic!("another feature"),
    }
}

fn assert_same_points(a: &Contacts, b: &Contacts, tolerance: f64, name: &str) {
    assert_eq!(a.points().len(), b.points().len(), "{name}");
    for (a, b) in a.points().iter().zip(b.points()) {
        let off = (a.center - b.center).amax();
        let (x, y) = (numbers_of(&a.feature), numbers_of(&b.feature));
        assert_eq!(x.len(), y.len(), "{name}");
        let features = x.iter().zip(&y).map(|(x, y)| (x - y).abs());
        let off = features.fold(off, f64::max);
        assert!(off < tolerance, "{name}: {a:?} is {off:e} from {b:?}");
    }
}

#[test]
fn points_of_contact_that_move_equal_those_of_the_changed_shapes() {
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
    for model in [
        chain(),
        asset("box.urdf"),
        asset("quadruped.urdf"),
        asset("hopper.urdf"),
    ] {
        let (hardware, name) = (all_of(&model), model.name());
        let x = changed(&hardware);
        let own = Contacts::new(&model, Terrain::flat(0.0), law);
        let same = own.with_hardware(&hardware, hardware.nominal()).unwrap();
        assert_same_points(&same, &own, ROUNDING, name);
        let moved = own.with_hardware(&hardware, &x).unwrap();
        let anew = Contacts::new(&hardware.model(&x).unwrap(), Terrain::flat(0.0), law);
        assert_same_points(&moved, &anew, SAME_ALGEBRA, name);
    }
}

/// A foot below a leg of its own link, and a rotor across it: parts besides the chosen shape.
#[test]
fn other_shapes_of_a_link_move_and_keep_their_kind() {
    let leg = Geometry::Cylinder {
        radius: 0.02,
        length: 0.4,
    };
    let collision = |at: [f64; 3], turn: [f64; 3], geometry| Collision {
        name: None,
        placement: pose(turn, at),
        geometry,
    };
    let rotor = Geometry::Cylinder {
        radius: 0.03,
        length: 0.05,
    };
    let middle = Transform::from_translation(Vector3::new(0.0, 0.0, -0.2));
    let mut builder = ModelBuilder::new("leg");
    builder.add_link(
        solid("leg", leg, middle)
            .with_collision(collision(
                [0.0, 0.0, -0.4],
                [0.0; 3],
                Geometry::Sphere { radius: 0.03 },
            ))
            .with_collision(collision([0.0; 3], [FRAC_PI_2, 0.0, 0.0], rotor)),
    );
    let chosen = ScaledLink::new("leg", &[Dimension::Radius, Dimension::Length]);
    let hardware = Hardware::new(&builder.build().unwrap(), &[chosen]).unwrap();
    let longer = hardware.description(&[0.04, 0.6]).unwrap();
    let shapes = &longer.links[0].collisions;
    let size = |k: usize| match shapes[k].geometry {
        Geometry::Sphere { radius } => [radius, 0.0],
        Geometry::Cylinder { radius, length } => [radius, length],
        _ => panic!("another kind"),
    };
    // The rotor lies across: as long as the leg is thick, and as round as lengths and radii in the mean.
    let round = 0.03 * (2.0_f64 * 1.5).sqrt();
    for (k, at, expected) in [
        (0, [0.0, 0.0, -0.3], [0.04, 0.6]),
        (1, [0.0, 0.0, -0.6], [0.06, 0.0]),
        (2, [0.0; 3], [round, 0.1]),
    ] {
        assert!(
            (shapes[k].placement.translation - Vector3::from(at)).amax() < ROUNDING,
            "{k}"
        );
        let off = (size(k)[0] - expected[0]).abs() + (size(k)[1] - expected[1]).abs();
        assert!(off < ROUNDING, "{k}: {:?}", size(k));
    }
    // The ball is the one that is meant.
    let by_ball = ScaledLink::new("leg", &[Dimension::Radius]).with_shape(LinkShape::Collision(1));
    let hardware = Hardware::new(&builder.build().unwrap(), &[by_ball]).unwrap();
    assert_eq!(hardware.nominal(), [0.03]);
}

#[test]
fn lanes_of_a_changed_robot_equal_its_values() {
    let hardware = all_of(&chain());
    let (a, b) = (hardware.nominal().to_vec(), changed(&hardware));
    let lanes: Vec<_> = a.iter().zip(&b).map(|(&a, &b)| Lanes([a, b])).collect();
    let both = hardware.model(&lanes).unwrap().parameters();
    for (lane, x) in [a, b].iter().enumerate() {
        let one = hardware.model(x).unwrap().parameters();
        let off = (both.map(|x| x.value(lane)) - &one).amax() / one.amax();
        assert!(off < 10.0 * ROUNDING, "lane {lane}: {off:e}");
    }
}

/// Torques of inverse dynamics as a function of sizes and densities, each beside its own.
struct Torques<'a> {
    hardware: &'a Hardware,
    model: &'a Model,
}

impl VectorFunction for Torques<'_> {
    fn n_outputs(&self) -> usize {
        self.model.nv()
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let x: Vec<T> = x
            .iter()
            .zip(self.hardware.nominal())
            .map(|(&x, &n)| x * n)
            .collect();
        let model = self.hardware.model(&x).expect("positive sizes");
        let point = random_point(self.model, 1);
        let [q, v, a] = [&point.q, &point.v, &point.w].map(|x| x.map(T::constant));
        let tau = inverse_dynamics(&model, q.as_slice(), v.as_slice(), a.as_slice());
        y.copy_from_slice(tau.as_slice());
    }
}

#[test]
fn derivatives_in_sizes_equal_finite_differences() {
    let model = chain();
    let hardware = all_of(&model);
    let torques = Torques {
        hardware: &hardware,
        model: &model,
    };
    let x = vec![1.1; hardware.names().len()];
    let (exact, numeric) = (
        jacobian(&torques, &x),
        finite_difference::jacobian(&torques, &x),
    );
    let off = (&exact - numeric).amax() / exact.amax();
    assert!(off < FINITE_DIFFERENCE, "{off:e}");
}

/// Speeds and positions of all steps, and effort.
struct Motion;

impl RolloutCost for Motion {
    fn stage<T: Scalar>(&self, _: usize, state: &State<T>, u: &[T]) -> T {
        let squares = state
            .v
            .iter()
            .chain(u)
            .fold(T::zero(), |sum, &x| sum + x * x);
        squares * 0.01
    }
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        last.q.iter().fold(T::zero(), |sum, &x| sum + x * x)
    }
}

const STEPS: usize = 60;

/// The cost of a swing of the arm as a function of sizes and densities beside their own.
struct Swing {
    hardware: Hardware,
    simulator: Simulator,
    inputs: Vec<DVector<f64>>,
}

impl Swing {
    fn new() -> Self {
        let model = asset("ur5.urdf");
        let nv = model.nv();
        Self {
            hardware: all_of(&model),
            simulator: Simulator::new(model).with_time_step(0.005),
            inputs: (0..STEPS)
                .map(|k| DVector::from_fn(nv, |i, _| ((k + 3 * i) as f64 * 0.1).sin() * 10.0))
                .collect(),
        }
    }

    fn sizes<T: Scalar>(&self, x: &[T]) -> Vec<T> {
        x.iter()
            .zip(self.hardware.nominal())
            .map(|(&x, &n)| x * n)
            .collect()
    }
}

impl VectorFunction for Swing {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let model = self.hardware.model(&self.sizes(x)).expect("positive sizes");
        let simulator = self
            .simulator
            .with_model(model)
            .expect("the same structure");
        let mut state = self.simulator.neutral_state::<T>();
        y[0] = T::zero();
        for (k, u) in self.inputs.iter().enumerate() {
            let u = u.map(T::constant);
            y[0] += Motion.stage(k, &state, u.as_slice());
            state = simulator.step(&state, u.as_slice());
        }
        y[0] += Motion.end(&state);
    }
}

#[test]
fn gradient_of_a_rollout_in_sizes_by_the_chain_rule_equals_forward_mode_and_differences() {
    let swing = Swing::new();
    let x = vec![1.05; swing.hardware.names().len()];
    let sizes = swing.sizes(&x);
    let simulator = swing
        .simulator
        .with_model(swing.hardware.model(&sizes).unwrap())
        .unwrap();
    let start = simulator.neutral_state();
    let options = RolloutGradientOptions {
        parameters: WantedParameters::Model,
        ..Default::default()
    };
    let rollout = &simulator.rollout_gradients(&[start], &[&swing.inputs], &Motion, &options)[0];
    let to_sizes = swing.hardware.parameter_jacobian(&sizes).unwrap();
    let mut gradient = to_sizes.transpose() * &rollout.parameters;
    gradient
        .iter_mut()
        .zip(swing.hardware.nominal())
        .for_each(|(g, n)| *g *= n);
    let forward = jacobian(&swing, &x).transpose();
    let off = (&gradient - &forward).amax() / forward.amax();
    assert!(off < 1e-10, "forward mode: {off:e}");
    let numeric = finite_difference::jacobian(&swing, &x).transpose();
    let off = (&gradient - &numeric).amax() / numeric.amax();
    assert!(off < 1e-6, "differences: {off:e}");
}

/// Height and place of the hopper's body after it has dropped onto its foot, as functions of the lengths of its leg.
struct Drop {
    hardware: Hardware,
    simulator: Simulator,
}

impl VectorFunction for Drop {
    fn n_outputs(&self) -> usize {
        2
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let contacts = self.simulator.contacts().expect("a foot");
        let contacts = contacts
            .with_hardware(&self.hardware, x)
            .expect("positive lengths");
        let model = self.hardware.model(x).expect("positive lengths");
        let simulator = self
            .simulator
            .with_model(model)
            .expect("the same structure");
        let simulator = simulator.with_contacts(contacts);
        let mut state: State<T> = simulator.state(
            &[0.0, 0.45, -0.6, 1.2].map(T::constant),
            &[0.0; 4].map(T::constant),
        );
        for _ in 0..200 {
            state = simulator.step(&state, &[T::zero(), T::zero()]);
        }
        y.copy_from_slice(&state.q.as_slice()[..2]);
    }
}

#[test]
fn derivative_in_the_lengths_of_a_leg_through_contact_equals_differences() {
    let model = asset("hopper.urdf");
    let lengths = ["thigh", "shank"].map(|link| ScaledLink::new(link, &[Dimension::Length]));
    let hardware = Hardware::new(&model, &lengths).unwrap();
    let law = ContactLaw::Soft(SoftContact::estimate(4.0, 1, 5e-3));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_contacts(contacts)
        .with_actuated_joints(&["hip", "knee"])
        .unwrap()
        .with_time_step(2e-3);
    let drop = Drop {
        hardware,
        simulator,
    };
    let x = [0.22, 0.25];
    let exact = jacobian(&drop, &x);
    let by = 1e-6;
    for k in 0..2 {
        let at = |sign: f64| {
            let (mut x, mut y) = (x, [0.0; 2]);
            x[k] += sign * by;
            drop.eval(&x, &mut y);
            DVector::from_row_slice(&y)
        };
        let numeric = (at(1.0) - at(-1.0)) / (2.0 * by);
        let off = (exact.column(k) - &numeric).amax() / numeric.amax();
        assert!(
            numeric.amax() > 0.1 && off < 1e-5,
            "{k}: {off:e}, {numeric}"
        );
    }
}

/// A tetrahedron with corners on the axes, closed.
const OBJ: &str = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

// V = 2·3·4/6; c = (2, 3, 4)/4; ∫x² = V 2²/10, ∫xy = V 2·3/20.
#[test]
fn mesh_of_other_scale_and_density_equals_the_closed_form_of_a_tetrahedron() {
    let folder = std::env::temp_dir().join(format!("dualbody_hardware_{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let (closed, open) = (folder.join("closed.obj"), folder.join("open.obj"));
    fs::write(&closed, OBJ).unwrap();
    fs::write(&open, OBJ.replace("f 2 3 4\n", "")).unwrap();
    let robot = |file: &std::path::Path, scale: [f64; 3]| {
        let mesh = Geometry::Mesh {
            uri: file.display().to_string(),
            path: Some(file.to_owned()),
            scale,
            up_axis: UpAxis::Auto,
        };
        let mut builder = ModelBuilder::new("stone");
        let stone = LinkSpec::new("stone").with_mass(4.0, [0.1, 0.0, 0.0], [0.2; 3]);
        builder.add_link(stone.with_visual(Visual {
            name: None,
            placement: Transform::identity(),
            geometry: mesh,
            color: None,
        }));
        builder.build().unwrap()
    };
    let chosen = |dimensions: &[Dimension]| {
        let link = ScaledLink::new("stone", dimensions);
        [link.with_mass_distribution(MassDistribution::Homogeneous)]
    };
    let all = [Dimension::X, Dimension::Y, Dimension::Z, Dimension::Density];
    for mirror in [1.0, -1.0] {
        let model = robot(&closed, [0.1, 0.1 * mirror, 0.1]);
        let hardware = Hardware::new(&model, &chosen(&all)).unwrap();
        // 4 kg in 0.004 m³.
        let nominal = [0.1, 0.1, 0.1, 1000.0];
        for (x, expected) in hardware.nominal().iter().zip(nominal) {
            assert!((x - expected).abs() < 100.0 * ROUNDING * expected);
        }
        let (s, rho) = ([0.2, 0.3, 0.05], 500.0);
        let inertia = hardware.model(&[s[0], s[1], s[2], rho]).unwrap().bodies()[0].inertia;
        let [a, b, c] = [2.0 * s[0], 3.0 * s[1] * mirror, 4.0 * s[2]];
        let mass = rho * (a * b * c).abs() / 6.0;
        let com = Vector3::new(a, b, c) / 4.0;
        assert!((inertia.mass - mass).abs() < 100.0 * ROUNDING * mass);
        assert!((inertia.com() - com).amax() < SAME_ALGEBRA);
        let j = inertia.rotational;
        assert!((j.xx - mass * (b * b + c * c) / 10.0).abs() < SAME_ALGEBRA * mass);
        assert!((j.xy + mass * a * b / 20.0).abs() < SAME_ALGEBRA * mass);
    }
    let error = Hardware::new(&robot(&open, [1.0; 3]), &chosen(&all))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("\"stone\"") && error.contains("is not closed"),
        "{error}"
    );
    let error = Hardware::new(&robot(&folder.join("none.obj"), [1.0; 3]), &chosen(&all));
    assert!(error.unwrap_err().to_string().contains("cannot be read"));
    // Where no volume is needed, no file is read.
    let open = Hardware::new(
        &robot(&open, [1.0; 3]),
        &[ScaledLink::new("stone", &all[..3])],
    );
    let longer = open.unwrap().model(&[2.0, 1.0, 1.0]).unwrap();
    assert!((longer.total_mass() - 8.0).abs() < ROUNDING * 8.0);
    fs::remove_dir_all(&folder).unwrap();
}

// A body that is not a homogeneous solid is stretched particle by particle: two balls on an axis move apart.
#[test]
fn inertia_that_is_no_homogeneous_solid_is_stretched_with_its_shape() {
    let (mass, arm, length) = (3.0, 0.3, 1.0);
    let mut builder = ModelBuilder::new("dumbbell");
    let rod = Geometry::Cylinder {
        radius: 0.01,
        length,
    };
    let across = mass * arm * arm;
    let points = LinkSpec::new("dumbbell").with_mass(mass, [0.0; 3], [across, across, 0.0]);
    builder.add_link(points.with_visual(Visual {
        name: None,
        placement: Transform::identity(),
        geometry: rod,
        color: None,
    }));
    let chosen = ScaledLink::new("dumbbell", &[Dimension::Length]);
    let hardware = Hardware::new(&builder.build().unwrap(), &[chosen]).unwrap();
    let inertia = hardware.model(&[1.5]).unwrap().bodies()[0].inertia;
    // Masses and arms grow by 1.5.
    let expected = Inertia::from_com(
        1.5 * mass,
        &Vector3::zeros(),
        &dualbody::spatial::Symmetric3::diagonal(&Vector3::new(
            1.5_f64.powi(3) * across,
            1.5_f64.powi(3) * across,
            0.0,
        )),
    );
    assert!((inertia.to_matrix() - expected.to_matrix()).amax() < 10.0 * ROUNDING);
}

fn choice_error(model: &Model, links: &[ScaledLink]) -> String {
    Hardware::new(model, links).unwrap_err().to_string()
}

#[test]
fn choices_that_make_no_sense_are_errors_that_name_the_link() {
    let model = asset("hopper.urdf");
    let length = |link: &str| ScaledLink::new(link, &[Dimension::Length]);
    let unknown = choice_error(&model, &[length("tigh")]);
    assert!(
        unknown.contains("no link \"tigh\"") && unknown.contains("thigh"),
        "{unknown}"
    );
    let twice = choice_error(&model, &[length("thigh"), length("thigh")]);
    assert!(twice.contains("\"thigh\""), "{twice}");
    let none = choice_error(&model, &[length("boom")]);
    assert!(
        none.contains("\"boom\"") && none.contains("no shape"),
        "{none}"
    );
    let ball = choice_error(&model, &[length("foot")]);
    assert!(
        ball.contains("\"foot\" cannot be scaled: its shape is a sphere, without length"),
        "{ball}"
    );
    let other = length("foot").with_shape(LinkShape::Collision(3));
    let other = choice_error(&model, &[other]);
    assert!(other.contains("no collision shape 3"), "{other}");
    let mut builder = ModelBuilder::new("ghost");
    builder.add_link(solid(
        "ghost",
        Geometry::Sphere { radius: 0.1 },
        Transform::identity(),
    ));
    builder.links[0].inertia = Inertia::zero();
    let ghost = Hardware::new(
        &builder.build().unwrap(),
        &[ScaledLink::new("ghost", &[Dimension::Density])],
    );
    assert!(matches!(ghost, Err(EditError::NoMass { .. })), "{ghost:?}");
}

#[test]
fn values_that_make_no_sense_are_errors_that_name_the_parameter() {
    let model = asset("hopper.urdf");
    let chosen = ScaledLink::new("shank", &[Dimension::Radius, Dimension::Density]);
    let hardware = Hardware::new(&model, &[chosen]).unwrap();
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let error = hardware.model(&[bad, 1.0]).unwrap_err().to_string();
        let said = format!("the parameter \"shank: radius\" {bad} is not positive and finite");
        assert_eq!(error, said);
        let error = hardware
            .model(&[Along::from(0.01), bad.into()])
            .unwrap_err();
        assert!(error.to_string().contains("shank: density"), "{error}");
        assert!(hardware.description(&[0.01, bad]).is_err());
        assert!(hardware.parameter_jacobian(&[0.01, bad]).is_err());
    }
    assert!(hardware.find("shank: length").is_err());
}
