#!/usr/bin/env bash
# Checks the sources, builds the package in an environment of its own, and runs its tests, notebooks and type checkers.
# PYTHON is the interpreter (3.10 or newer), PROFILE the profile of the build (dev or release), FEATURES what is built besides (cuda).
set -euo pipefail
cd "$(dirname "$0")"

python="${PYTHON:-python3}"
profile="${PROFILE:-dev}"
features="${FEATURES:-}"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$(cd .. && pwd)/target}"
venv="$CARGO_TARGET_DIR/python-venv"

step() {
  printf '\n== %s\n' "$*"
  "$@"
}

if [ ! -x "$venv/bin/python" ]; then step "$python" -m venv "$venv"; fi
step "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r requirements-check.txt
step cargo fmt --all --check
step cargo clippy --quiet ${features:+--features "$features"} -- -D warnings
# Needs neither a GPU nor NVIDIA's tools to compile.
step cargo clippy --quiet --features cuda -- -D warnings
VIRTUAL_ENV="$venv" step "$venv/bin/maturin" develop --quiet --profile "$profile" ${features:+--features "$features"}
step "$venv/bin/python" -m pytest -q
step "$venv/bin/mypy"
# Pyright brings its own Node; where that cannot be had it is left out.
if "$venv/bin/pyright" --version >/dev/null 2>&1; then step "$venv/bin/pyright" --pythonpath "$venv/bin/python"; fi
