#![expect(non_snake_case, reason = "monogram notation, see the conventions")]
#![cfg_attr(
    not(feature = "second-order"),
    allow(dead_code, unused_imports, reason = "for tests of second derivatives")
)]

//! Promises of the crate, checked against independent results.

mod activations;
mod actuation;
mod adjoints;
mod analytic;
mod base_velocity;
mod batch;
mod batch_contact;
mod batch_parameters;
mod bibliography;
mod bounded_in_contact;
mod by_link;
mod collision;
mod collision_files;
mod collisions;
mod common;
mod compliance;
mod cone_lanes;
mod constraints;
mod contact;
mod contact_frames;
mod contact_margin;
mod contact_reasons;
mod control;
mod conventions;
mod coupling;
mod default_step;
mod degenerate_distances;
mod dense_jacobians;
mod derivatives;
mod derivatives_over;
mod distance_fields;
mod dry_friction;
mod dynamics_derivatives;
mod ellipsoids;
mod environments;
mod equilibrium;
mod extreme_laws;
mod file_sensors;
mod finite_differences;
mod flight;
mod floors;
mod folded_ground;
mod frame_forces;
mod frame_servos;
mod free_bodies;
mod generic_scalar;
mod golden;
mod graphs_of_pairs;
mod graphs_of_steps;
mod guide;
mod hardware;
mod identities;
mod immovable_contact;
mod impact_times;
mod impacts;
mod implicit;
mod implicit_midpoint;
mod integrators;
mod joint_kinds;
mod joint_limits;
mod link_distances;
#[cfg(feature = "live")]
mod live;
mod loading;
mod many_points;
mod mesh_contact;
mod mjcf;
mod mjcf_activations;
mod mjcf_builtin;
mod mjcf_equalities;
mod mjcf_height_fields;
mod mjcf_meshes;
mod mjcf_neighbours;
#[cfg(feature = "png")]
mod mjcf_pictures;
mod mjcf_references;
mod mjcf_sensors;
mod moments;
mod named_forces;
mod own_scalars;
mod pages_of_contact;
mod pair_reports;
mod parallel_sides;
mod parameters;
#[cfg(feature = "render")]
mod pictures;
mod piles;
mod pitfalls;
mod quadruped_walk;
mod random_trees;
mod rates;
mod refused;
mod representations;
mod rigid_at_rest;
mod rigid_contact;
mod rigid_parameters;
mod rolling;
#[cfg(feature = "second-order")]
mod rollout_hessians;
mod scalars;
mod sensor_batches;
mod sensor_meshes;
mod sensor_noise;
mod sensor_slopes;
mod sensors;
mod servos;
mod simulation;
mod sleep;
mod smooth_distances;
mod smoothing;
#[cfg(feature = "second-order")]
mod step_adjoint_derivatives;
mod step_adjoints;
mod step_remarks;
mod stop_signal;
mod surfaces;
mod tendon_servos;
mod tiled_ground;
mod time_step;
mod trajopt_costs;
mod trajopt_ddp;
mod trajopt_distances;
mod trajopt_failures;
mod trajopt_shooting;
mod trajopt_solvers;
mod trajopt_table;
#[cfg(feature = "transcription")]
mod trajopt_transcription;
mod trust_boundary;
mod turning_friction;
mod urdf_commands;
mod weightless;
mod worlds;
mod yielding_constraints;
