//! Soft contact against closed forms: rest, sliding, rolling, bouncing, energy, and derivatives in every mode.

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::contact::{
    ContactLaw, ContactPoint, Contacts, Feature, HeightField, HeightFunction, HuntCrossley,
    RelaxedRigid, Rigid, SoftContact, Terrain, TerrainFunction,
};
use dualbody::sim::BatchSimulator;
use dualbody::{Cast, Integrator, Model, ModelOptions, Scalar, Simulator, State};
use nalgebra::{Vector3, vector};

use crate::common::ground::{self, base_velocity, differences, free, hills, run, waves};
use crate::common::{FINITE_DIFFERENCE, SAME_ALGEBRA, asset};

const GRAVITY: f64 = 9.81;

fn soft(mu: f64) -> SoftContact {
    SoftContact {
        friction: mu,
        ..ground::square_root_law(1.0, 4, 1e-3)
    }
}

fn on(model: Model, terrain: Terrain, law: SoftContact) -> Simulator {
    ground::on(model, terrain, ContactLaw::Soft(law))
}

#[test]
fn nothing_is_felt_above_the_ground() {
    let with = on(asset("box.urdf"), Terrain::flat(0.0), soft(0.5));
    let without = Simulator::new(asset("box.urdf")).with_time_step(1e-3);
    let start = free(&with, [0.0, 0.0, 2.0], 0.4, [0.3, 0.1, 0.0, 1.0, -2.0, 0.5]);
    let (fallen, free) = (
        run(&with, &start, 0.3),
        run(&without, &start_of(&start), 0.3),
    );
    assert!((fallen.q - free.q).amax() < SAME_ALGEBRA);
    assert!(fallen.contact.iter().all(|&m| m == 0.0));
}

fn start_of(state: &State) -> State {
    State::new(state.q.as_slice(), state.v.as_slice())
}

#[test]
fn box_rests_at_the_estimated_depth_and_does_not_creep() {
    let simulator = on(asset("box.urdf"), Terrain::flat(0.3), soft(0.5));
    let start = free(
        &simulator,
        [0.0, 0.0, 0.38],
        0.0,
        [0.5, 0.2, 0.0, 0.0, 0.0, 0.3],
    );
    let rest = run(&simulator, &start, 4.0);
    assert!(rest.v.amax() < 1e-6, "{}", rest.v);
    // Four corners carry the weight at the requested depth.
    assert!(
        (rest.q[2] - (0.3 + 0.06 - 1e-3)).abs() < 1e-6,
        "{}",
        rest.q[2]
    );
    let later = run(&simulator, &rest, 2.0);
    assert!((&later.q - &rest.q).amax() < 1e-6);
    let forces = simulator.contact_report(&rest, &[]).forces;
    let sum = forces.iter().fold(Vector3::zeros(), |sum, f| sum + f);
    assert!((sum - vector![0.0, 0.0, GRAVITY]).amax() < 1e-5, "{sum}");
}

#[test]
fn box_sticks_on_an_incline_if_and_only_if_its_slope_is_below_friction() {
    for (slope, mu) in [(0.28_f64, 0.3), (0.32, 0.3), (0.55, 0.6), (0.7, 0.6)] {
        let terrain = Terrain::incline(slope.atan());
        ground::assert_sticks_or_slides(&on(asset("box.urdf"), terrain, soft(mu)), slope, mu);
    }
}

#[test]
fn sphere_rolls_down_with_five_sevenths_of_sliding() {
    let angle: f64 = 0.2;
    let simulator = on(asset("sphere.urdf"), Terrain::incline(angle), soft(0.8));
    let height = 0.1 - 1e-3 * 2.5;
    let at = [-angle.sin() * height, 0.0, angle.cos() * height];
    let start = free(&simulator, at, 0.0, [0.0; 6]);
    let (one, two) = (run(&simulator, &start, 1.0), run(&simulator, &start, 2.0));
    let down = vector![-angle.cos(), 0.0, -angle.sin()];
    let gained = (base_velocity(&two) - base_velocity(&one)).dot(&down);
    let expected = 5.0 / 7.0 * GRAVITY * angle.sin();
    // However deep the sphere has sunk in, its lowest point is a radius below the centre, and at rest on the ground while the bristle holds
    // the same force: the closed form holds to the rounding of a thousand steps.
    assert!(
        (gained - expected).abs() < 1e-12 * expected,
        "{gained} against {expected}"
    );
    let slip = base_velocity(&two).dot(&down) - 0.1 * two.v[4].abs();
    assert!(slip.abs() < 1e-12, "{slip}");
}

#[test]
fn energy_never_grows_in_passive_contact() {
    for model in ["box.urdf", "sphere.urdf"] {
        let simulator = on(asset(model), Terrain::flat(0.0), soft(0.4))
            .with_time_step(1e-4)
            .with_integrator(Integrator::RungeKutta4);
        let start = free(
            &simulator,
            [0.0, 0.0, 0.4],
            0.7,
            [1.0, 0.5, 0.0, 2.0, 3.0, -1.0],
        );
        let rollout = simulator.rollout(&start, 12_000, |_, _, _| {});
        let energy =
            |state: &State| ground::energy(simulator.model(), state) + stored(&simulator, state);
        let mut last = energy(&rollout.states[0]);
        let first = last;
        for state in rollout.states.iter().step_by(4) {
            let now = energy(state);
            assert!(
                now < last + 1e-5 * first.abs(),
                "{model}: {last} becomes {now}"
            );
            last = last.min(now);
        }
        assert!(last < 0.8 * first, "{model}: nothing was dissipated");
    }
}

/// ∫ K δ¹⁺ᵖ dδ of all points; bristles store ½ K δᵖ m².
fn stored(simulator: &Simulator, state: &State) -> f64 {
    let contacts = simulator.contacts().expect("contacts");
    let points = contacts.states(simulator.model(), state.q.as_slice(), state.v.as_slice());
    let each = points
        .iter()
        .zip(contacts.laws())
        .enumerate()
        .map(|(i, (point, law))| {
            let ContactLaw::Soft(law) = law else {
                panic!("soft")
            };
            let normal = &law.normal;
            let depth = point.depth.max(0.0);
            let p = normal.stiffness_exponent;
            let m = state.contact.rows(3 * i, 3).norm_squared();
            normal.stiffness * (depth.powf(2.0 + p) / (2.0 + p) + 0.5 * depth.powf(p) * m)
        });
    each.sum()
}

/// States in free flight, sticking, sliding, at rest exactly, and just about to touch.
fn moments(simulator: &Simulator) -> Vec<(&'static str, State)> {
    let at = |z, v| free(simulator, [0.1, -0.2, z], 0.02, v);
    let slow = [1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3];
    let fast = [1.0, 0.4, -0.1, 0.2, 0.1, 0.5];
    vec![
        ("flight", at(0.5, fast)),
        ("sticking", at(0.05, slow)),
        ("sliding", at(0.05, fast)),
        ("at zero velocity", at(0.05, [0.0; 6])),
        ("touching", free(simulator, [0.0, 0.0, 0.06], 0.0, [0.0; 6])),
    ]
}

#[test]
fn jacobians_of_the_step_equal_finite_differences_in_every_mode() {
    for terrain in [Terrain::flat(0.0), Terrain::incline(0.05), hills(), waves()] {
        for integrator in crate::common::everything::INTEGRATORS {
            let simulator =
                on(asset("box.urdf"), terrain.clone(), soft(0.5)).with_integrator(integrator);
            for (name, mut state) in moments(&simulator) {
                if name == "touching" && !matches!(&terrain, Terrain::Plane(_)) {
                    continue;
                }
                if name != "flight" && name != "touching" {
                    state.contact.fill(2e-5);
                }
                let exact = simulator.linearize(&state, &[]);
                assert!(exact.a.iter().all(|x| x.is_finite()), "{name}");
                if name == "touching" {
                    continue;
                }
                let numeric = differences(&simulator, &state, 1e-6);
                let error = (&exact.a - &numeric).amax() / numeric.amax();
                assert!(
                    error < SMALL_DIFFERENCE,
                    "{terrain:?} {integrator:?} {name}: {error:e}"
                );
            }
        }
    }
}

/// Central differences of a step that is small against the deflections of bristles: their error, relative.
const SMALL_DIFFERENCE: f64 = 1e-6;

/// The state after a step as a function of the numbers of law and terrain.
struct InParameters(Simulator, State);

impl VectorFunction for InParameters {
    fn n_outputs(&self) -> usize {
        self.1.v.len() + self.1.contact.len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let law = ContactLaw::Soft(SoftContact {
            normal: HuntCrossley {
                stiffness: x[0],
                damping: x[1],
                stiffness_exponent: x[2],
                damping_exponent: x[3],
            },
            friction: x[4],
        });
        let own = self.0.contacts().expect("contacts");
        let terrain = own.terrain().with_parameters(&x[5..]);
        let contacts = own.with_laws(&vec![law; own.points().len()]);
        let simulator: Simulator<T> = self.0.cast();
        let simulator = simulator.with_contacts(contacts.with_terrain(terrain));
        let next = simulator.step(&self.1.cast(), &[]);
        let out = next.v.iter().chain(&next.contact);
        y.iter_mut().zip(out).for_each(|(y, &x)| *y = x);
    }
}

#[test]
fn derivatives_in_the_numbers_of_contact_and_terrain_equal_finite_differences() {
    for terrain in [Terrain::incline(0.05), hills(), waves()] {
        let simulator = on(asset("box.urdf"), terrain.clone(), soft(0.5));
        for (name, state) in moments(&simulator).into_iter().take(3) {
            let law = soft(0.5);
            let mut x = vec![
                law.normal.stiffness,
                law.normal.damping,
                0.5,
                0.5,
                law.friction,
            ];
            x.extend(terrain.parameters());
            let f = InParameters(simulator.clone(), state);
            let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
            let error = (&exact - &numeric).amax() / numeric.amax().max(1e-9);
            assert!(
                error < 30.0 * FINITE_DIFFERENCE,
                "{terrain:?} {name}: {error:e}"
            );
            assert!(
                name == "flight" || exact.columns(0, 2).amax() > 0.0,
                "{name}"
            );
        }
    }
}

/// The velocity after a step as a function of the places and radii of all points.
struct InPoints(Simulator, State);

impl VectorFunction for InPoints {
    fn n_outputs(&self) -> usize {
        self.1.v.len()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let own = self.0.contacts().expect("contacts");
        let pairs = own.points().iter().zip(x.as_chunks::<4>().0);
        let points = pairs.map(|(point, &[x, y, z, radius])| ContactPoint {
            center: Vector3::new(x, y, z),
            feature: match point.feature {
                Feature::Sphere { .. } => Feature::Sphere { radius },
                _ => Feature::Corner,
            },
            ..point.cast()
        });
        let contacts = own.with_points(&points.collect::<Vec<_>>());
        let simulator: Simulator<T> = self.0.cast();
        let next = simulator
            .with_contacts(contacts)
            .step(&self.1.cast(), &vec![T::zero(); self.0.nu()]);
        y.copy_from_slice(next.v.as_slice());
    }
}

#[test]
fn derivatives_in_places_and_radii_of_points_equal_finite_differences() {
    let laws = [
        ContactLaw::Soft(soft(0.5)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ];
    for law in laws {
        for (file, z) in [("sphere.urdf", 0.0997), ("box.urdf", 0.0997)] {
            let simulator = ground::on(asset(file), Terrain::incline(0.05), law);
            let contacts = simulator.contacts().expect("contacts");
            // The sphere slides; a box stands on one corner.
            let lowest = contacts.points().iter().map(|point| match point.feature {
                Feature::Sphere { radius } => radius,
                _ => point.center.norm(),
            });
            let reach = lowest.fold(0.0, f64::max);
            let mut state = free(
                &simulator,
                [0.0, 0.0, 0.0],
                0.0,
                [0.4, 0.1, -0.02, 0.3, -0.2, 0.5],
            );
            if file == "box.urdf" {
                let corner = contacts.points()[0].center;
                let down = nalgebra::Rotation3::rotation_between(&corner, &-Vector3::z());
                let down = down.expect("a turn");
                let turn = nalgebra::UnitQuaternion::from(down);
                let [x, y, z, w] = turn.coords.into();
                state.q.as_mut_slice()[3..7].copy_from_slice(&[w, x, y, z]);
                // As fast as the sphere, in the axes of the body.
                let linear = down.inverse() * Vector3::new(0.4, 0.1, -0.02);
                state.v.rows_mut(0, 3).copy_from(&linear);
            }
            state.q[2] = reach * z / 0.1;
            let numbers = contacts.points().iter().flat_map(|point| {
                let radius = match point.feature {
                    Feature::Sphere { radius } => radius,
                    _ => 1.0,
                };
                [point.center.x, point.center.y, point.center.z, radius]
            });
            let x: Vec<f64> = numbers.collect();
            let f = InPoints(simulator, state);
            let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
            let error = (&exact - &numeric).amax() / numeric.amax();
            assert!(exact.amax() > 1e-3, "{law:?} {file}: nothing touches");
            assert!(error < 1e-4, "{law:?} {file}: {error:e}");
        }
    }
}

#[test]
fn points_stay_on_their_links_and_of_their_kind() {
    let simulator = on(asset("box.urdf"), Terrain::flat(0.0), soft(0.5));
    let contacts = simulator.contacts().expect("contacts");
    let points = contacts.points();
    assert_eq!(contacts.with_points(points).points(), points);
    let refused = |points: &[ContactPoint], expected: &str| {
        let work = std::panic::AssertUnwindSafe(|| contacts.with_points(points));
        let said = std::panic::catch_unwind(work).expect_err("refused");
        let said = said.downcast_ref::<String>().expect("a message");
        assert!(said.contains(expected), "{said}");
    };
    refused(
        &points[1..],
        "number of contact points, which must stay the same",
    );
    let mut other = points.to_vec();
    other[2].feature = Feature::Sphere { radius: 0.1 };
    refused(
        &other,
        "point 2 must stay on its link, and must stay of its kind",
    );
    other[2] = points[2];
    other[3].center.x = f64::NAN;
    refused(&other, "coordinate of a contact point is NaN");
}

#[test]
fn height_field_goes_through_its_nodes_and_its_slope_is_its_derivative() {
    let heights: Vec<f64> = (0..30).map(|k| (1.7 * k as f64).sin()).collect();
    let field = Terrain::HeightField(HeightField::new([-1.0, 2.0], [0.5, 0.25], [6, 5], &heights));
    for (k, h) in heights.iter().enumerate() {
        let (x, y) = (-1.0 + 0.5 * (k % 6) as f64, 2.0 + 0.25 * (k / 6) as f64);
        assert!((field.surface(&x, &y).height - h).abs() < SAME_ALGEBRA);
    }
    let h = 1e-5;
    for (x, y) in [(-0.9, 2.1), (0.13, 2.77), (0.5, 2.5), (1.2, 2.9)] {
        let at = field.surface(&x, &y);
        let slope_x =
            (field.surface(&(x + h), &y).height - field.surface(&(x - h), &y).height) / (2.0 * h);
        let slope_y =
            (field.surface(&x, &(y + h)).height - field.surface(&x, &(y - h)).height) / (2.0 * h);
        assert!((at.slope[0] - slope_x).abs() < 1e-7 && (at.slope[1] - slope_y).abs() < 1e-7);
    }
    // A grid of a plane is the plane, and beyond the border the ground stays at its height.
    let plane: Vec<f64> = (0..12)
        .map(|k| 0.3 * (k % 4) as f64 - 0.2 * (k / 4) as f64)
        .collect();
    let plane = Terrain::HeightField(HeightField::new([0.0; 2], [1.0, 1.0], [4, 3], &plane));
    let inside = plane.surface(&1.37, &0.81);
    assert!((inside.height - (0.3 * 1.37 - 0.2 * 0.81)).abs() < SAME_ALGEBRA);
    assert!((inside.slope[0] - 0.3).abs() < SAME_ALGEBRA);
    assert!((plane.surface(&9.0, &1.0).height - (0.9 - 0.2)).abs() < SAME_ALGEBRA);
}

#[test]
fn user_s_terrain_equals_the_same_plane() {
    struct Slope;
    impl HeightFunction for Slope {
        fn height<T: Scalar>(&self, x: T, y: T, parameters: &[T]) -> T {
            x * parameters[0] + y * parameters[1] + parameters[2]
        }
    }
    let function = Terrain::Function(TerrainFunction::new(Slope, &[0.1, -0.2, 0.3]));
    let plane = Terrain::plane([0.0, 0.0, 0.3], [-0.1, 0.2, 1.0]);
    let (f, p) = (function.surface(&0.4, &0.9), plane.surface(&0.4, &0.9));
    assert!((f.height - p.height).abs() < SAME_ALGEBRA);
    assert!((f.normal() - p.normal()).amax() < SAME_ALGEBRA);
}

#[test]
fn resumed_and_batched_runs_equal_the_run_bit_for_bit() {
    let simulator = on(asset("box.urdf"), hills(), soft(0.5));
    let start = free(
        &simulator,
        [0.0, 0.0, 0.2],
        0.5,
        [0.3, 0.0, 0.0, 1.0, 0.0, 0.2],
    );
    let whole = run(&simulator, &start, 0.6);
    let mut half = run(&simulator, &start, 0.3);
    // Through a file: every number is written in full.
    let text: Vec<String> = half.numbers().map(|x| format!("{x}")).collect();
    let read: Vec<f64> = text.iter().map(|x| x.parse().expect("a number")).collect();
    half.copy_from_slice(&read);
    assert_eq!(run(&simulator, &half, 0.3), whole);
    let starts = vec![start; 11];
    let mut batch = BatchSimulator::new(simulator, 11);
    let rollout = batch.rollout(&starts, 600, |_, _, _| {});
    let error = (&rollout.last(7).q - &whole.q).amax();
    assert!(error < SAME_ALGEBRA, "{error:e}");
}

#[test]
fn shapes_rest_where_their_geometry_says() {
    // Shape, turn about y, height of the centre when it just lies on the ground.
    let half = std::f64::consts::FRAC_PI_2;
    let shapes = [
        ("<sphere radius='0.2'/>", 0.3, 0.2),
        ("<cylinder radius='0.2' length='0.5'/>", 0.0, 0.25),
        ("<cylinder radius='0.2' length='0.5'/>", half, 0.2),
        ("<box size='0.4 0.3 0.2'/>", half, 0.2),
        ("<capsule radius='0.1' length='0.3'/>", half, 0.1),
        ("<capsule radius='0.1' length='0.3'/>", 0.0, 0.25),
        (
            "<cylinder radius='0.3' length='0.4'/>",
            0.5,
            0.3 * 0.5_f64.sin() + 0.2 * 0.5_f64.cos(),
        ),
    ];
    for (shape, angle, height) in shapes {
        let urdf = format!(
            "<robot name='r'><link name='l'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial><collision><geometry>{shape}</geometry></collision></link></robot>"
        );
        let model = ModelOptions::default()
            .load_urdf_str(&urdf)
            .expect("a shape")
            .0;
        let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(soft(0.5)));
        let (sin, cos) = (0.5 * angle).sin_cos();
        let q = [0.0, 0.0, height, cos, 0.0, sin, 0.0];
        let deepest = contacts
            .states(&model, &q, &[0.0; 6])
            .iter()
            .fold(f64::NEG_INFINITY, |d, p| d.max(p.depth));
        assert!(deepest.abs() < 1e-4, "{shape} at {angle}: {deepest}");
    }
}

#[test]
fn jacobian_of_a_point_times_velocity_equals_its_velocity() {
    let model = asset("quadruped.urdf");
    let simulator = on(model, Terrain::incline(0.1), soft(0.5));
    let (model, contacts) = (simulator.model(), simulator.contacts().expect("contacts"));
    let state = State::random(model, &mut crate::common::generator(5), 1.0);
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let points = contacts.states(model, q, v);
    for (i, point) in points.iter().enumerate() {
        let expected = contacts.jacobian(model, q, i) * &state.v;
        assert!((expected - point.velocity).amax() < SAME_ALGEBRA);
    }
}
