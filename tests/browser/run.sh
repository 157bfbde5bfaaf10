#!/usr/bin/env bash
# Opens the pages that examples/pages.rs writes in a real browser and uses them as a person would.
#
#   bash tests/browser/run.sh             the checks; screenshots go to out/browser/; PROFILE is the profile of the build, release without it
#   bash tests/browser/run.sh --gallery   makes the pictures of examples/README.md in assets/gallery/ from the pages of the examples, which it runs
set -euo pipefail
cd "$(dirname "$0")/../.."

bash tests/browser/install.sh
if [ "${1:-}" = --gallery ]; then
  for example in pendulum inverse_dynamics derivatives batch computed_torque cartpole pages plots \
    cartpole_swing_up acrobot_swing_up arm_reach quadruped_jump_in_flight hopper mpc_cartpole obstacle_course \
    hopper_codesign payload falling_spheres bouncing_ball box_on_incline quadruped_stand quadruped_walk four_bar two_arms newtons_cradle stack quadrotor \
    gripper push_box reach_around dominoes pour; do
    cargo run --quiet --release --features full --example "$example" > /dev/null
  done
  node tests/browser/gallery.mjs
  cp out/plots/trajectory.png assets/gallery/plots.png
  # The guide shows some of them.
  for picture in guide/src/pictures/*.png; do cp "assets/gallery/$(basename "$picture")" "$picture"; done
else
  cargo run --quiet --profile "${PROFILE:-release}" --features full --example pages
  node --test tests/browser/checks.mjs tests/browser/collide.mjs
  # The program as its tests have it: built alone, with fewer features of other crates, it would compile the library again.
  cargo test --quiet --profile "${PROFILE:-release}" --features full --test command --no-run
  folder="${PROFILE:-release}"
  DUALBODY="${CARGO_TARGET_DIR:-target}/${folder/#dev/debug}/dualbody" node --test --test-concurrency=1 tests/browser/live.mjs
fi
