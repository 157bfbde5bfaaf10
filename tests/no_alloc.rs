//! Hot functions do not allocate after set-up, which a counting allocator proves.

#![expect(unsafe_code, reason = "an allocator is unsafe by its trait")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use dualbody::autodiff::CHUNK;
use dualbody::cone::{Block, ConeOptions, ConeProblem, ConeSolver, Law};
use dualbody::constraint::{Anchor, Constraint as HoldTogether};
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, PointState, RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::dynamics::{
    AbaScratch, CoriolisScratch, CrbaScratch, ForwardDynamicsDerivatives,
    ForwardDynamicsDerivativesScratch, ForwardDynamicsGradient, ForwardDynamicsVjpScratch,
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch, InverseDynamicsGradient,
    InverseDynamicsVjpScratch, Kinematics, MassMatrixFactor, MassMatrixInverseScratch, RneaScratch,
    add_frame_force, bias_forces_into, coriolis_matrix_into, forward_dynamics_derivatives_into,
    forward_dynamics_into, forward_dynamics_vjp_into, forward_kinematics_into,
    frame_jacobian_derivative_into, frame_jacobian_into, frame_pose, frame_pose_at, frame_velocity,
    gravity_forces_into, inverse_dynamics_derivatives_into, inverse_dynamics_into,
    inverse_dynamics_vjp_into, mass_matrix_into, mass_matrix_inverse_into,
};
use dualbody::linearize::{LinearizeScratch, StepGradient, VjpScratch};
use dualbody::model::{FrameId, Mass, Model, Object, World, samples};
use dualbody::sim::{
    Actuation, BatchSimulator, ExternalForce, ForceFunction, FrameActuator, Sleeping, StepScratch,
};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, FramePosition, InputError, Problem, Robot, StateError,
    Trajectory,
};
use dualbody::{Integrator, Linearization, Over, Scalar, Simulator, State};
use nalgebra::DMatrix;
use num_dual::DualSVec64;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs a function and asserts that it did not allocate.
fn without_allocation(what: &str, f: impl FnOnce()) {
    let before = ALLOCATIONS.with(Cell::get);
    f();
    let count = ALLOCATIONS.with(Cell::get) - before;
    assert_eq!(count, 0, "{what} allocated {count} times");
}

fn models() -> Vec<Model> {
    vec![
        samples::cartpole(),
        samples::arm(),
        samples::random_tree(12, 3),
    ]
}

/// Finds the gradient of a step.
fn check_vjp(what: &str, simulator: &Simulator, state: &State, u: &[f64]) {
    let adjoint = vec![0.1; simulator.n_tangent()];
    let mut out = StepGradient::zeros(simulator);
    let mut scratch = VjpScratch::new(simulator);
    without_allocation(what, || {
        simulator.vjp_into(state, u, &adjoint, &mut scratch, &mut out);
    });
}

fn check_dynamics<T: Over<f64>>(model: &Model) {
    let zeros = || vec![T::zero(); model.nv()];
    let q: Vec<T> = model.neutral().iter().map(|&q| T::constant(q)).collect();
    let (v, mut out) = (zeros(), zeros());
    let (mut rnea, mut crba, mut aba) = (
        RneaScratch::new(model),
        CrbaScratch::new(model),
        AbaScratch::new(model),
    );
    let mut external = vec![Force::zero(); model.n_bodies()];
    let (mut mass, mut jacobian) = (
        DMatrix::zeros(model.nv(), model.nv()),
        DMatrix::zeros(6, model.nv()),
    );
    let (mut inverse, mut coriolis) = (
        MassMatrixInverseScratch::new(model),
        CoriolisScratch::new(model),
    );
    let mut factor = MassMatrixFactor::new(model, &mass);
    let (mut inverse_vjp, mut forward_vjp) = (
        InverseDynamicsVjpScratch::new(model),
        ForwardDynamicsVjpScratch::new(model),
    );
    let mut inverse_slopes = InverseDynamicsGradient::zeros(model);
    let mut forward_slopes = ForwardDynamicsGradient::zeros(model);
    let mut kinematics = Kinematics::new(model);
    let last = FrameId(model.frames().len() - 1);
    without_allocation("dynamics", || {
        forward_kinematics_into(model, &q, &v, &mut kinematics);
        add_frame_force(
            model,
            &kinematics,
            last,
            &Force::zero(),
            Representation::Mixed,
            &mut external,
        );
        inverse_dynamics_into(model, &q, &v, &v, &external, &mut rnea, &mut out);
        bias_forces_into(model, &q, &v, &[], &mut rnea, &mut out);
        gravity_forces_into(model, &q, &mut rnea, &mut out);
        mass_matrix_into(model, &q, &mut crba, &mut mass);
        factor.refactor(&mass);
        factor.solve(&mut out);
        mass_matrix_inverse_into(model, &q, &mut inverse, &mut mass);
        coriolis_matrix_into(model, &q, &v, &mut coriolis, &mut mass);
        forward_dynamics_into(model, &q, &v, &v, &external, &mut aba, &mut out);
        let slopes = &mut inverse_slopes;
        inverse_dynamics_vjp_into(model, &q, &v, &v, &external, &v, &mut inverse_vjp, slopes);
        let slopes = &mut forward_slopes;
        forward_dynamics_vjp_into(model, &q, &v, &v, &external, &v, &mut forward_vjp, slopes);
        frame_jacobian_into(model, &q, last, Representation::Inertial, &mut jacobian);
        let r = Representation::Mixed;
        frame_jacobian_derivative_into(model, &q, &v, last, r, &mut jacobian);
        frame_pose(model, &q, last);
        frame_pose_at(model, &kinematics, last);
        frame_velocity(model, &q, &v, last, Representation::Body);
    });
}

#[test]
fn dynamics_do_not_allocate() {
    for model in models() {
        check_dynamics::<f64>(&model);
        check_dynamics::<DualSVec64<CHUNK>>(&model);
    }
}

#[test]
fn bases_of_states_are_read_and_set_without_allocation() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
    let model = Model::from_urdf_file(file).expect("a robot");
    let mut state: State = State::neutral(&model);
    without_allocation("the base", || {
        for representation in [Representation::Mixed, Representation::Inertial] {
            let pose = state
                .free_pose(&model, "floating_base")
                .expect("a floating base");
            let set = state.set_free_pose(&model, "floating_base", &pose);
            set.expect("a floating base");
            let velocity = state.free_velocity(&model, "floating_base", representation);
            let velocity = velocity.expect("a floating base");
            let set = state.set_free_velocity(&model, "floating_base", &velocity, representation);
            set.expect("a floating base");
        }
    });
}

#[test]
fn derivatives_of_dynamics_do_not_allocate() {
    for model in &models() {
        let (q, v) = (model.neutral(), vec![0.1; model.nv()]);
        let q = q.as_slice();
        let mut inverse = InverseDynamicsDerivativesScratch::new(model);
        let mut of_inverse = InverseDynamicsDerivatives::zeros(model);
        without_allocation("derivatives of inverse dynamics", || {
            inverse_dynamics_derivatives_into(model, q, &v, &v, &[], &mut inverse, &mut of_inverse);
        });
        let mut forward = ForwardDynamicsDerivativesScratch::new(model);
        let mut of_forward = ForwardDynamicsDerivatives::zeros(model);
        without_allocation("derivatives of forward dynamics", || {
            forward_dynamics_derivatives_into(model, q, &v, &v, &[], &mut forward, &mut of_forward);
        });
    }
}

#[test]
fn step_and_linearize_do_not_allocate() {
    for model in models() {
        for integrator in [
            Integrator::SemiImplicitEuler,
            Integrator::RungeKutta4,
            Integrator::ImplicitMidpoint,
        ] {
            let simulator = Simulator::new(model.clone()).with_integrator(integrator);
            let state = State::neutral(&model);
            let mut next = state.clone();
            let u = vec![0.1; simulator.nu()];
            let (mut step, mut linearize) = (
                StepScratch::new(&simulator),
                LinearizeScratch::new(&simulator),
            );
            let mut out = Linearization::zeros(&simulator);
            without_allocation("step", || {
                simulator.step_into(&state, &u, &mut step, &mut next);
            });
            without_allocation("linearize", || {
                simulator.linearize_into(&state, &u, &mut linearize, &mut out);
            });
            check_vjp("vjp", &simulator, &state, &u);
        }
    }
}

/// A force that follows its place.
struct Drag;

impl ForceFunction for Drag {
    fn force<T: Scalar>(&self, _: &Transform<T>, velocity: &Motion<T>, c: &[T]) -> Force<T> {
        Force::new(velocity.linear * -c[0], velocity.angular * -c[0])
    }
}

#[test]
fn step_and_linearize_with_forces_on_frames_do_not_allocate() {
    let integrators = [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
        Integrator::ImplicitMidpoint,
    ];
    for (model, integrator) in models()
        .into_iter()
        .flat_map(|model| integrators.map(|by| (model.clone(), by)))
    {
        let links = model.link_names();
        let place = Anchor::frame(&model, links[links.len() - 1]).expect("a link");
        let push = Force::from_array([1.0; 6]);
        let forces = Representation::ALL.into_iter().flat_map(|r| {
            let drag = ExternalForce::function(place, Drag, &[0.1], r);
            [ExternalForce::constant(place, push, r), drag]
        });
        let jet = FrameActuator::thruster("jet", place, [0.0, 0.0, 1.0], 0.1);
        let simulator = Simulator::new(model.clone())
            .with_external_forces(forces.collect())
            .with_frame_actuators(vec![jet.with_limits(0.0, 1.0)])
            .with_integrator(integrator);
        let state: State = simulator.neutral_state();
        let (mut next, u) = (state.clone(), vec![0.1; simulator.nu()]);
        let mut step = StepScratch::new(&simulator);
        let mut linearize = LinearizeScratch::new(&simulator);
        let mut out = Linearization::zeros(&simulator);
        without_allocation("step with forces", || {
            simulator.step_into(&state, &u, &mut step, &mut next);
        });
        without_allocation("linearize with forces", || {
            simulator.linearize_into(&state, &u, &mut linearize, &mut out);
        });
        check_vjp("vjp with forces", &simulator, &state, &u);
    }
}

#[test]
fn states_of_contact_points_do_not_allocate() {
    let path = format!("{}/assets/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("an asset of the crate");
    let law = ContactLaw::Rigid(Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let (q, v) = (model.neutral(), vec![0.1; model.nv()]);
    let mut kinematics = Kinematics::new(&model);
    let n = contacts.points().len();
    let mut points = vec![PointState::zero(); n];
    without_allocation("states of contact points", || {
        forward_kinematics_into(&model, q.as_slice(), &v, &mut kinematics);
        contacts.states_into(&kinematics, &mut points);
    });
}

#[test]
fn steps_with_sleep_do_not_allocate() {
    let mut world = World::default();
    for (name, x, z) in [("low", 0.0, 0.1), ("top", 0.0, 0.3), ("beside", 1.0, 0.1)] {
        let place = Transform::from_translation([x, 0.0, z].into());
        let object = Object::free(Mass::Kilograms(1.0)).at(place);
        world.add_box(name, [0.2; 3], &object).expect("a box");
    }
    let model = world.build().expect("a world");
    let law = ContactLaw::Rigid(Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    let sleeping = Sleeping {
        speed: 1e-3,
        time: 0.02,
    };
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_sleeping(sleeping);
    let rest = simulator.rollout(&simulator.neutral_state(), 200, |_, _, _| {});
    let asleep = rest.last().clone();
    let mut some = asleep.clone();
    some.v[12] = 0.1;
    let mut pushed = asleep.clone();
    pushed.v[0] = 0.1;
    assert_eq!(simulator.asleep(&asleep).len(), 3);
    let mut step = StepScratch::new(&simulator);
    let mut next = asleep.clone();
    for measured in [false, true] {
        for start in [&simulator.neutral_state(), &asleep, &some, &pushed] {
            let mut take = || {
                simulator.step_into(start, &[], &mut step, &mut next);
            };
            match measured {
                false => take(),
                true => without_allocation("step with sleep", take),
            }
        }
    }
}

#[test]
fn step_and_linearize_with_contact_and_actuation_do_not_allocate() {
    let path = format!("{}/assets/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("an asset of the crate");
    let laws = [
        ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 4, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ];
    let actuation = Actuation::from_model(&model);
    let stand = Anchor::frame(&model, "FR_foot").expect("a frame of the robot");
    let tied = HoldTogether::distance([Anchor::world(), stand], 0.5);
    let names = model.joint_names();
    let tendon = HoldTogether::tendon(&model, &[(names[0], 0.3), (names[3], 0.2)], 0.1);
    let tendon = tendon.expect("joints of the robot").with_largest_force(0.5);
    let soft = [
        tied.clone().with_spring(300.0, 3.0),
        tendon.clone().with_spring(30.0, 0.3),
        tendon,
    ];
    let integrators = [
        (Integrator::SemiImplicitEuler, vec![]),
        (Integrator::SemiImplicitEuler, soft.to_vec()),
        (Integrator::RungeKutta4, vec![tied.clone()]),
        (Integrator::RungeKutta4, soft.to_vec()),
        (Integrator::ImplicitVelocity, vec![tied]),
    ];
    let cases = integrators
        .iter()
        .flat_map(|case| laws.map(|law| (case, law)));
    for (&(integrator, ref constraints), law) in cases {
        if integrator == Integrator::RungeKutta4 && matches!(law, ContactLaw::Rigid(_)) {
            continue; // it acts over a step
        }
        let simulator = Simulator::new(model.clone())
            .with_constraints(constraints.clone())
            .with_contacts(Contacts::new(&model, Terrain::incline(0.1), law))
            .with_actuation(actuation.clone())
            .with_integrator(integrator);
        // With its feet in the ground; with its legs, on many points; in flight.
        for height in [0.39, 0.0, 2.0] {
            let mut state: State = simulator.neutral_state();
            state.q[2] = height;
            let (mut next, u) = (state.clone(), vec![0.1; simulator.nu()]);
            let (mut step, mut linearize) = (
                StepScratch::new(&simulator),
                LinearizeScratch::new(&simulator),
            );
            let mut out = Linearization::zeros(&simulator);
            without_allocation("step with contact", || {
                simulator.step_into(&state, &u, &mut step, &mut next);
            });
            without_allocation("linearize with contact", || {
                simulator.linearize_into(&state, &u, &mut linearize, &mut out);
            });
            check_vjp("vjp with contact", &simulator, &state, &u);
        }
    }
}

#[test]
fn batch_does_not_allocate() {
    for model in models() {
        let simulator = Simulator::new(model.clone());
        let starts = vec![State::neutral(&model); 11];
        let inputs = vec![0.1; 11 * simulator.nu()];
        let models = vec![model.clone(); 11];
        let variants = BatchSimulator::of_variants(&simulator, models).expect("variants");
        for batch in [BatchSimulator::new(simulator, 11), variants] {
            let mut batch = batch.with_threads(1);
            let mut states = batch.states(&starts);
            without_allocation("a step of a batch", || {
                batch.step(&mut states, &inputs);
                states.set(3, &starts[3]);
            });
        }
    }
}

#[test]
fn iterations_of_trajectory_optimisation_do_not_allocate() {
    for model in models() {
        let last = FrameId(model.frames().len() - 1);
        let simulator = Simulator::new(model).with_time_step(0.02);
        let neutral = simulator.pack(&State::neutral(simulator.model()));
        let cost = || {
            let target = FramePosition::new(last, [0.3, 0.1, 0.5]);
            Cost::new().with(1.0, Activation::Quadratic, target).with(
                0.1,
                Activation::Quadratic,
                StateError::to_neutral(&simulator),
            )
        };
        let effort = InputError::to_zero(&simulator);
        let nu = simulator.nu();
        let still = Constraint::equal_to_zero(&simulator, StateError::to_neutral(&simulator));
        let problem = Problem::new(simulator.clone(), 5, neutral.as_slice())
            .with_stage_cost(cost().with(1e-2, Activation::Quadratic, effort))
            .with_final_cost(cost())
            .with_final_constraint(still)
            .with_input_bounds(&vec![-5.0; nu], &vec![5.0; nu]);
        let mut ddp = Ddp::new(&problem);
        let guess = Trajectory::zero_input(&problem);
        without_allocation("trajectory optimisation", || {
            assert!(ddp.solve(&problem, &guess).iterations > 2);
        });
    }
}

/// A bilateral row, a ray and contacts, two of them with the same rows; and bilateral rows that contradict each other.
fn check_contact_forces<T: Scalar>(law: Law, kappa: f64) {
    let constants = |x: &[f64]| -> Vec<T> { x.iter().map(|&x| T::constant(x)).collect() };
    let n = 14;
    let entry = |i: usize, k: usize| (1.0 + (7 * (i % 11) + 3 * k) as f64).sin();
    let product = |i, j| (0..20).map(|k| entry(i, k) * entry(j, k)).sum();
    let matrix: Vec<f64> = (0..n * n).map(|at| product(at % n, at / n)).collect();
    let offset: Vec<f64> = (0..n).map(|i| entry(i, 30) - 0.5).collect();
    let blocks = [[Block::Free(1), Block::Ray].as_slice(), &[Block::Cone; 4]].concat();
    let bounded = [[Block::Interval; 5].as_slice(), &[Block::Cone; 3]].concat();
    let contradiction = [[Block::Free(n)].as_slice(), &[Block::Free(0); 5]].concat();
    let mut solver = ConeSolver::new(n, bounded.len())
        .with_options(ConeOptions::default().with_smoothing(kappa));
    let (matrix, offset) = (constants(&matrix), constants(&offset));
    let (friction, regularization) = (constants(&[0.5; 8]), constants(&vec![0.0; n]));
    let mut f = constants(&vec![0.0; n]);
    without_allocation("contact forces", || {
        for blocks in [&blocks, &bounded, &contradiction] {
            let problem = ConeProblem {
                law,
                blocks,
                friction: &friction[..blocks.len()],
                matrix: &matrix,
                regularization: &regularization,
                free_velocity: &offset,
            };
            solver.solve(&problem, &mut f);
        }
    });
}

#[test]
fn contact_forces_do_not_allocate() {
    for law in [Law::Convex, Law::Coulomb] {
        for kappa in [0.0, 1e-3] {
            check_contact_forces::<f64>(law, kappa);
            check_contact_forces::<DualSVec64<CHUNK>>(law, kappa);
        }
    }
}

#[test]
fn evaluating_a_graph_does_not_allocate() {
    let graph = dualbody::codegen::step(&Simulator::new(samples::arm()));
    let x: Vec<f64> = (0..graph.n_inputs()).map(|k| (k as f64).sin()).collect();
    let (mut scratch, mut next) = (graph.scratch(), vec![0.0; graph.n_outputs()]);
    without_allocation("evaluating a graph", || {
        let held = graph.evaluate_into(&x, &mut scratch, &mut next);
        held.expect("slow motion");
    });
    assert!(next.iter().any(|x| x.abs() > 0.0));
}

// The counter itself must see an allocation, or the tests above prove nothing.
#[test]
#[should_panic(expected = "allocated 1 times")]
fn counter_sees_an_allocation() {
    without_allocation("a vector", || drop(std::hint::black_box(vec![1.0_f64; 3])));
}
