#!/usr/bin/env bash
# What building costs, in CPU seconds (user and system, all cores) unless a row says otherwise: they say more than a clock on a machine with other work,
# though a busy neighbour on the same core still makes them larger. Prints a table; all rows take over an hour on two cores.
#
#     bash benches/build/run.sh [--against REV] [--rows NAME,NAME] [FOLDER]
#
# --against  measures another commit too, row by row in turn, in a worktree that is made for it and removed at the end; prints ratios
# --rows     code, library, first, line, user, recorder, second, tests, pip, ci; all but ci by default
# FOLDER     where it builds: a new folder below target/ by default; one that is there already is refused, and nothing is emptied
set -euo pipefail
cd "$(dirname "$0")/../.."

against="" rows=code,library,first,line,user,recorder,second,tests,pip folder=""
while [ $# -gt 0 ]; do
  case $1 in
    --against) against=$2; shift 2 ;;
    --rows) rows=$2; shift 2 ;;
    -*) echo "unknown option $1, see the head of $0" >&2; exit 2 ;;
    *) folder=$1; shift ;;
  esac
done

mkdir -p target
if [ -n "$folder" ]; then
  mkdir "$folder" || { echo "$folder is there already: name a new folder" >&2; exit 2; }
else
  folder=$(mktemp -d target/build-bench.XXXX)
fi
folder=$(realpath "$folder")
export CARGO_INCREMENTAL=0

worktree="$folder/worktree"
if [ -n "$against" ]; then
  git worktree add --quiet --detach "$worktree" "$against"
  trap 'git worktree remove --force "$worktree"' EXIT
fi

# The command of the README, or of CONTRIBUTING, that begins with these words, without its comment.
command_of() { cat README.md CONTRIBUTING.md | grep -m1 "^$1" | sed 's/ *#.*//'; }

# A program outside of a tree that depends on the library: name, tree, features.
program() {
  mkdir -p "$1/src"
  cat >"$1/Cargo.toml" <<EOF
[package]
name = "$(basename "$1")"
version = "0.0.0"
edition = "2024"
[dependencies]
dualbody = { path = "$2", features = [$3] }
nalgebra = "0.35"
indicatif = "0.18.6"
[workspace]
EOF
}

# 850 lines that optimise trajectories: five examples as modules of one program.
user_program() {
  program "$1" "$2" ""
  cp "$2/examples/common/mod.rs" "$1/src/common.rs"
  printf '#![allow(dead_code)]\nmod common;\n' >"$1/src/main.rs"
  local example calls=""
  for example in hopper cartpole_swing_up quadruped_stand arm_reach mpc_cartpole; do
    sed -e 's/^mod common;$/use crate::common;/' -e 's/^fn main()/pub fn main()/' "$2/examples/$example.rs" >"$1/src/$example.rs"
    printf 'mod %s;\n' "$example" >>"$1/src/main.rs"
    calls+="    $example::main()?;"$'\n'
  done
  printf 'fn main() -> Result<(), Box<dyn std::error::Error>> {\n%s    Ok(())\n}\n' "$calls" >>"$1/src/main.rs"
}

# Records the step of a robot, A and B, and inverse dynamics.
recording_program() {
  local features=""
  ! grep -q '^graphs = ' "$2/Cargo.toml" || features='"graphs"'
  program "$1" "$2" "$features"
  cat >"$1/src/main.rs" <<'EOF'
use dualbody::{Simulator, codegen, model::samples};

fn main() {
    let arm = Simulator::new(samples::arm()).with_time_step(0.01);
    for graph in [codegen::step(&arm), codegen::linearization(&arm), codegen::inverse_dynamics(arm.model())] {
        println!("{}", graph.n_outputs());
    }
}
EOF
}

# cpu COMMAND...: CPU seconds of a command; what it prints goes to a file.
cpu() {
  # `times` must not run in a subshell, which has children of its own.
  times >"$folder/before"
  "$@" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
  times >"$folder/after"
  cat "$folder/before" "$folder/after" | awk '
    NR % 2 == 0 { gsub(/m/, " "); gsub(/s/, ""); s = $1 * 60 + $2 + $3 * 60 + $4 - s }
    END { printf "%.0f\n", s }' >"$folder/value"
}

# Seconds of the clock.
clock() {
  local start=$SECONDS
  "$@" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
  echo "$((SECONDS - start))" >"$folder/value"
}

quietly() { "$@" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }; }

# row NAME OUT: measures a row in the tree that is the working directory; OUT is its folder of builds.
row() {
  local out=$2 tree=$PWD
  export CARGO_TARGET_DIR="$out/$1"
  # What another row has built.
  case $1 in
    library) CARGO_TARGET_DIR=$out/code ;;
    line) CARGO_TARGET_DIR=$out/first ;;
  esac
  case $1 in
    code)
      quietly cargo build --release --lib
      nm -S --defined-only "$CARGO_TARGET_DIR/release/libdualbody.rlib" 2>/dev/null |
        awk 'BEGIN { while (i++ < 16) hex[substr("0123456789abcdef", i, 1)] = i - 1 }
          NF == 4 && $3 ~ /^[tTwW]$/ { n = 0; for (i = 1; i <= length($2); i++) n = n * 16 + hex[substr($2, i, 1)]; sum += n }
          END { printf "%.2f\n", sum / 1e6 }' >"$folder/value" ;;
    library)
      # With the crates below it in the form that it takes by itself.
      quietly cargo build --release --lib
      touch src/lib.rs
      cpu cargo build --release --lib ;;
    first) cpu cargo build --release --example cartpole ;;
    line)
      quietly cargo build --release --example cartpole
      touch examples/cartpole.rs
      cpu cargo build --release --example cartpole ;;
    user | recorder)
      if [ "$1" = user ]; then user_program "$out/$1-program" "$tree"; else recording_program "$out/$1-program" "$tree"; fi
      quietly cargo build --release --manifest-path "$out/$1-program/Cargo.toml"
      touch "$out/$1-program/src/main.rs"
      cpu cargo build --release --manifest-path "$out/$1-program/Cargo.toml" ;;
    second) eval "cpu $(command_of 'cargo test')" ;;
    tests)
      export CARGO_TARGET_DIR="$out/second"
      eval "quietly $(command_of 'cargo test') --no-run"
      eval "clock $(command_of 'cargo test') --test it" ;;
    pip)
      python3 -m venv "$out/venv"
      cpu "$out/venv/bin/pip" install --no-cache-dir ./python ;;
    ci)
      unset CARGO_TARGET_DIR
      clock bash .ci/run
      ! grep -q '== SKIPPED' "$folder/log" || sed -i 's/$/ (checks skipped)/' "$folder/value" ;;
    *) echo "no row is called $1, see the head of $0" >&2; exit 2 ;;
  esac
}

declare -A names=(
  [code]="machine code of the library, default features, MB"
  [library]="the library alone"
  [first]="the first command of the README without running, clean"
  [line]="a changed line in that example"
  [user]="a changed line in a program of 850 lines with Ddp"
  [recorder]="a changed line in a program that records steps"
  [second]="the tests, clean"
  [tests]="of it the run of tests/it, clock"
  [pip]="pip install ./python, clean"
  [ci]=".ci/run, clock"
)

printf '%-58s %10s' "" "now"
[ -z "$against" ] || printf ' %10s %7s' "$against" "ratio"
printf '\n'
for name in ${rows//,/ }; do
  row "$name" "$folder/now"
  now=$(cat "$folder/value")
  printf '%-58s %10s' "${names[$name]}" "$now"
  if [ -n "$against" ]; then
    (cd "$worktree" && row "$name" "$folder/against")
    other=$(cat "$folder/value")
    printf ' %10s %7s' "$other" "$(awk -v a="$now" -v b="$other" 'BEGIN { printf "%.2f", a / (b > 0 ? b : 1) }')"
  fi
  printf '\n'
done
