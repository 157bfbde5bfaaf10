#!/usr/bin/env bash
# Builds a wheel of the package and tries it in an environment that contains nothing but NumPy. The wheel is for Python 3.10 and newer (the stable ABI) on
# x86-64 Linux with glibc 2.28 or newer (manylinux_2_28). Needs Rust and Python; the tools, a linker for old systems among them, come from PyPI into target/.
#
#     bash python/wheel.sh                     a wheel in target/wheels
#     WHEELS=folder bash python/wheel.sh       another folder
#     PYTHON=python3.12 bash python/wheel.sh   another interpreter for the trial
#     PROFILE=dev NATIVE=1 bash python/wheel.sh   for this system only, without that linker: shares what python/check.sh has built
set -euo pipefail
cd "$(dirname "$0")"

readonly python=${PYTHON:-python3} profile=${PROFILE:-wheel} platform=manylinux_2_28
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$(cd .. && pwd)/target}"
readonly tools=$CARGO_TARGET_DIR/wheel-tools wheels=${WHEELS:-$CARGO_TARGET_DIR/wheels}

needed=("maturin>=1.9,<2")
if [ -z "${NATIVE:-}" ]; then needed+=("ziglang>=0.13,<0.16" cargo-zigbuild); fi
if [ ! -x "$tools/bin/python" ]; then "$python" -m venv "$tools"; fi
"$tools/bin/pip" install --quiet --disable-pip-version-check "${needed[@]}"
arguments=(build --quiet --profile "$profile" --out "$wheels")
if [ -z "${NATIVE:-}" ]; then
  # With this platform maturin refuses symbols of a newer glibc, and libraries that may be missing elsewhere.
  arguments+=(--zig --target x86_64-unknown-linux-gnu --compatibility "$platform")
else
  arguments+=(--compatibility linux)
fi
rm -f "$wheels"/dualbody-*.whl
PATH="$tools/bin:$PATH" "$tools/bin/maturin" "${arguments[@]}"
wheel=$(echo "$wheels"/dualbody-*.whl)
case $wheel in
  *-cp310-abi3-*) ;;
  *) echo "$wheel: not a wheel of the stable ABI (cp310-abi3)" >&2; exit 1 ;;
esac

# A bare environment, outside of the sources, which must not be found by accident.
bare=$(mktemp -d)
trap 'rm -rf "$bare"' EXIT
"$python" -m venv "$bare/venv"
"$bare/venv/bin/pip" install --quiet --disable-pip-version-check numpy
began=$(date +%s%N)
"$bare/venv/bin/pip" install --quiet --disable-pip-version-check --no-index "$wheel"
echo "$wheel: $(($(stat -c %s "$wheel") / 1048576)) MiB, installed in $((($(date +%s%N) - began) / 1000000)) ms"
"$bare/venv/bin/python" -I -c 'import dualbody, pathlib; assert pathlib.Path(dualbody.__file__).with_name("_dualbody.pyi").stat().st_size > 50_000, "no types"'
cp tests/listings.py "$bare"
readmes=("$PWD/README.md" "$PWD/../README.md")
(cd "$bare" && venv/bin/python -I listings.py "${readmes[@]}")
