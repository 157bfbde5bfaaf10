//! Free bodies on the ground, their energies, and differences of their steps.

use dualbody::contact::{
    ContactLaw, Contacts, HeightField, HeightFunction, HuntCrossley, PointState, RelaxedRigid,
    Rigid, SoftContact, Terrain, TerrainFunction,
};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::model::{LinkSpec, ModelBuilder};
use dualbody::sim::Actuation;
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3, vector};

/// A robot on a ground, in steps of 1 ms.
pub(crate) fn on(model: Model, terrain: Terrain, law: ContactLaw) -> Simulator {
    let contacts = Contacts::new(&model, terrain, law);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-3)
}

/// A robot with its own actuators and dampers, in steps of 2 ms that are implicit in velocity.
pub(crate) fn actuated(model: Model, contacts: Contacts) -> Simulator {
    let actuation = Actuation::from_model(&model);
    Simulator::new(model)
        .with_contacts(contacts)
        .with_actuation(actuation)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(2e-3)
}

/// A robot of one link.
pub(crate) fn body(link: LinkSpec) -> Model {
    let mut builder = ModelBuilder::new("body");
    builder.add_link(link);
    builder.build().expect("a body")
}

/// The laws with a friction: soft contact with the other numbers of one, the others with those of their defaults.
pub(crate) fn laws_with(friction: f64, soft: SoftContact) -> [ContactLaw; 3] {
    [
        ContactLaw::Soft(SoftContact { friction, ..soft }),
        ContactLaw::RelaxedRigid(RelaxedRigid {
            friction,
            ..RelaxedRigid::default()
        }),
        ContactLaw::Rigid(Rigid {
            friction,
            ..Rigid::default()
        }),
    ]
}

/// The law of [`SoftContact::estimate`] but with p = q = ½: the depths, energies and limits of the tests that take it are those of these exponents.
pub(crate) fn square_root_law(mass: f64, points: usize, depth: f64) -> SoftContact {
    let carried = mass / points as f64;
    let stiffness = carried * 9.806_65 / depth.powf(1.5);
    let slope = 1.5 * stiffness * depth.sqrt();
    SoftContact {
        normal: HuntCrossley {
            stiffness,
            damping: 2.0 * (slope * carried).sqrt() / depth.sqrt(),
            stiffness_exponent: 0.5,
            damping_exponent: 0.5,
        },
        friction: 0.5,
    }
}

/// All laws with a friction of 1; the soft one lets two points that carry 1 kg sink in by a depth, m.
pub(crate) fn sticky_laws(depth: f64) -> [ContactLaw; 3] {
    laws_with(1.0, square_root_law(1.0, 2, depth))
}

/// A robot on a ground, in steps that are implicit in velocity.
pub(crate) fn rolling_on(model: &Model, terrain: Terrain, law: ContactLaw) -> Simulator {
    let contacts = Contacts::new(model, terrain, law);
    Simulator::new(model.clone())
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
}

/// A wheel with its axle along y, turned by a phase about it and leaning by an angle about x.
pub(crate) fn wheel(
    simulator: &Simulator,
    at: [f64; 3],
    phase: f64,
    lean: f64,
    v: [f64; 6],
) -> State {
    let turn =
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2 + lean)
            * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), phase);
    let [x, y, z] = at;
    simulator.state(&[x, y, z, turn.w, turn.i, turn.j, turn.k], &v)
}

/// A free body at a place, with a base turned about y by an angle.
pub(crate) fn free(simulator: &Simulator, position: [f64; 3], angle: f64, v: [f64; 6]) -> State {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let [x, y, z] = position;
    simulator.state(&[x, y, z, cos, 0.0, sin, 0.0], &v)
}

/// The last state of a run without input.
pub(crate) fn run(simulator: &Simulator, start: &State, seconds: f64) -> State {
    let steps = (seconds / simulator.time_step()).round() as usize;
    simulator.rollout(start, steps, |_, _, _| {}).last().clone()
}

/// The velocity of the base's origin in the world.
pub(crate) fn base_velocity(state: &State) -> Vector3<f64> {
    let q = nalgebra::Quaternion::new(state.q[3], state.q[4], state.q[5], state.q[6]);
    UnitQuaternion::from_quaternion(q) * vector![state.v[0], state.v[1], state.v[2]]
}

/// Column k of A of a step without input, by central differences of a size.
pub(crate) fn difference(
    simulator: &Simulator,
    state: &State,
    k: usize,
    size: f64,
) -> DVector<f64> {
    let (model, u) = (simulator.model(), vec![0.0; simulator.nu()]);
    let [after, before] = [size, -size].map(|by| {
        let mut dx = vec![0.0; simulator.n_tangent()];
        dx[k] = by;
        simulator.step(&state.integrate(model, &dx), &u)
    });
    after.deviation(model, &before) / (2.0 * size)
}

/// A of a step without input by central differences of a size.
pub(crate) fn differences(simulator: &Simulator, state: &State, size: f64) -> DMatrix<f64> {
    let columns = 0..simulator.n_tangent();
    let columns = columns.map(|k| difference(simulator, state, k, size));
    DMatrix::from_columns(&columns.collect::<Vec<_>>())
}

/// A of a step against central differences of two sizes: the forces of relaxed contact are exact to about 1e-13 only.
#[track_caller]
pub(crate) fn assert_derivatives(simulator: &Simulator, state: &State, at: &str) {
    let a = simulator.linearize(state, &[]).a;
    let errors = [1e-7, 1e-6].map(|size| {
        let expected = differences(simulator, state, size);
        (&a - &expected).amax() / expected.amax()
    });
    assert!(errors[0].min(errors[1]) < 1e-5, "{at}: {errors:?}");
}

/// A soft box of 1 kg let go on an incline, along it and at the depth of 1 mm at which its corners carry it: it sticks
/// if and only if the slope is below friction, and else slides with g (sin α − μ cos α).
#[track_caller]
pub(crate) fn assert_sticks_or_slides(simulator: &Simulator, slope: f64, mu: f64) {
    let (sin, cos) = slope.atan().sin_cos();
    let height = 0.06 - 1e-3 * cos.powf(2.0 / 3.0);
    let at = [-sin * height, 0.0, cos * height];
    let start = free(simulator, at, -slope.atan(), [0.0; 6]);
    let down = vector![-cos, 0.0, -sin];
    let [v_1, v_2] = [1.0, 2.0].map(|t| base_velocity(&run(simulator, &start, t)).dot(&down));
    if slope < mu {
        assert!(v_2.abs() < 1e-6, "slope {slope} μ {mu}: creeps at {v_2}");
    } else {
        let (gained, expected) = (v_2 - v_1, 9.81 * (sin - mu * cos));
        let text = format!("slope {slope} μ {mu}: {gained}, not {expected}");
        assert!((gained - expected).abs() < 1e-3, "{text}");
    }
}

/// Kinetic and potential energy.
pub(crate) fn energy(model: &Model, state: &State) -> f64 {
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    kinetic_energy(model, q, v) + potential_energy(model, q)
}

/// ∫ K δ¹⁺ᵖ dδ of all points of soft contact, and ½ K δᵖ m² of their bristles.
pub(crate) fn stored(simulator: &Simulator, state: &State) -> f64 {
    let contacts = simulator.contacts().expect("contacts");
    let points = contacts.states(simulator.model(), state.q.as_slice(), state.v.as_slice());
    let bristles = state.contact.as_slice().chunks(3);
    let each = points.iter().zip(contacts.laws()).zip(bristles);
    let of = |((point, law), m): ((&PointState<f64>, &ContactLaw), &[f64])| {
        let ContactLaw::Soft(law) = law else {
            return 0.0;
        };
        let (k, p) = (law.normal.stiffness, law.normal.stiffness_exponent);
        let depth = point.depth.max(0.0);
        let m: f64 = m.iter().map(|m| m * m).sum();
        k * depth.powf(2.0 + p) / (2.0 + p) + 0.5 * k * depth.powf(p) * m
    };
    each.map(of).sum()
}

/// Hills of a few millimetres on a grid.
pub(crate) fn hills() -> Terrain {
    let heights: Vec<f64> = (0..30).map(|k| 0.004 * (1.7 * k as f64).sin()).collect();
    Terrain::HeightField(HeightField::new(
        [-1.1, -0.9],
        [0.45, 0.38],
        [6, 5],
        &heights,
    ))
}

struct Waves;

impl HeightFunction for Waves {
    fn height<T: Scalar>(&self, x: T, y: T, parameters: &[T]) -> T {
        (x * parameters[1]).sin_cos().0 * parameters[0] + y * x * 0.01
    }
}

/// Waves of a few millimetres by a function.
pub(crate) fn waves() -> Terrain {
    Terrain::Function(TerrainFunction::new(Waves, &[0.003, 2.0]))
}
