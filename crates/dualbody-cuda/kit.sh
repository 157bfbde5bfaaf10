#!/usr/bin/env bash
# Builds a kit: one folder that goes to a machine with a GPU, and compares and measures kernels there without Rust, Python, a compiler or a network. The machine that builds it
# needs no GPU; it gets a linker for old systems and NVRTC from PyPI, below target/.
#
#     bash crates/dualbody-cuda/kit.sh                       all robots of assets/, in target/kit
#     bash crates/dualbody-cuda/kit.sh my_robot.urdf …       these robots instead
#     KIT=folder bash crates/dualbody-cuda/kit.sh            another folder
#     ARCHITECTURES=90 bash crates/dualbody-cuda/kit.sh      kernels for fewer architectures: compiling takes most of the time, a quarter of an hour for each of them on two cores
#     NATIVE=1 bash crates/dualbody-cuda/kit.sh              programs for systems like this one, without that linker
#
# The folder is for x86-64 with glibc 2.28 or a later one. In it, `./run.sh`.
set -euo pipefail
given=()
for robot in "$@"; do given+=("$(realpath "$robot")"); done
cd "$(dirname "$0")/../.."

readonly target=${CARGO_TARGET_DIR:-target} crate=crates/dualbody-cuda
readonly kit=${KIT:-$target/kit} architectures=${ARCHITECTURES:-80,90}
# The oldest glibc that the programs run with.
readonly glibc=2.28 limit_kib=$((45 * 1024))

build() {
  # The profile of the tests, of which a part is built already. Recording graphs is quick enough without optimisation, which takes minutes.
  local package=profile.dev.package.dualbody-cuda
  local arguments=(-p dualbody-cuda --no-default-features --features "dualbody/formats,dlpack" --example kit --example kit_bridge
    --config "$package.opt-level=0" --config "$package.debug=false")
  if [ -n "${NATIVE:-}" ]; then
    [ -z "${FEATURES:-}" ] || arguments=(--workspace --features "$FEATURES" --example kit --example kit_bridge)
    cargo build --quiet "${arguments[@]}"
    built=$target/debug/examples
  else
    local tools=$target/zigbuild
    [ -e "$tools/bin/cargo-zigbuild" ] || { python3 -m venv "$tools" && "$tools/bin/pip" install --quiet --disable-pip-version-check "ziglang>=0.13,<0.16" cargo-zigbuild; }
    PATH="$(realpath "$tools/bin"):$PATH" cargo zigbuild --quiet --target "x86_64-unknown-linux-gnu.$glibc" "${arguments[@]}"
    built=$target/x86_64-unknown-linux-gnu/debug/examples
  fi
}

# The symbols of glibc that a program asks for are none of a later one.
check_glibc() {
  local newest
  newest=$(objdump -T "$1" | grep -o 'GLIBC_[0-9.]*' | sed 's/GLIBC_//' | sort -uV | tail -n 1)
  if [ "$(printf '%s\n%s\n' "$newest" "$glibc" | sort -V | tail -n 1)" != "$glibc" ]; then
    echo "$1 asks for glibc $newest, not for $glibc" >&2
    exit 1
  fi
}

build
rm -rf "$kit"
mkdir -p "$kit/robots"
cp "$built/kit" "$built/libkit_bridge.so" "$crate/kit/run.sh" "$crate/kit/dlpack.py" "$kit"
strip "$kit/kit" "$kit/libkit_bridge.so"
if [ -z "${NATIVE:-}" ]; then
  check_glibc "$kit/kit"
  check_glibc "$kit/libkit_bridge.so"
fi
if [ ${#given[@]} -gt 0 ]; then cp "${given[@]}" "$kit/robots"; else cp assets/*.urdf "$kit/robots"; fi
cp LICENSE-MIT LICENSE-APACHE "$kit"

nvrtc=$(bash $crate/nvrtc.sh || true)
LD_LIBRARY_PATH="$nvrtc${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
  "$kit/kit" make "$kit" --architectures "$architectures" --cache "$target/kit-cache"
(cd "$kit" && tar -czf packed.tar.gz kit libkit_bridge.so robots expected $([ ! -d kernels ] || echo kernels))
(cd "$kit" && rm -rf kit libkit_bridge.so robots expected kernels)

size=$(du -sk "$kit" | cut -f 1)
echo "$kit: $((size / 1024)) MiB"
if [ "$size" -gt "$limit_kib" ]; then
  echo "$kit is larger than $((limit_kib / 1024)) MiB: take fewer robots or ARCHITECTURES" >&2
  exit 1
fi
