#!/usr/bin/env bash
# Installs NVRTC, NVIDIA's compiler of kernels, from PyPI into target/nvrtc, unless it is there, and prints the folder of its library. It needs
# no GPU:
#
#     LD_LIBRARY_PATH=$(bash crates/dualbody-cuda/nvrtc.sh) cargo test -p dualbody-cuda
#
# Prints nothing, and fails, where it cannot be installed.
set -euo pipefail
cd "$(dirname "$0")/../.."

readonly folder=${CARGO_TARGET_DIR:-target}/nvrtc
# The version that kernels/counts.txt was made with; another one makes other code.
readonly version=12.9.86

find_library() {
  find "$folder" -name 'libnvrtc.so.12' -printf '%h\n' 2>/dev/null | head -n 1
}

if [ -z "$(find_library)" ]; then
  {
    python3 -m venv "$folder" && "$folder/bin/pip" install --quiet --disable-pip-version-check "nvidia-cuda-nvrtc-cu12==$version"
  } >&2
fi
library=$(find_library)
[ -n "$library" ] || { echo "NVRTC $version cannot be installed here" >&2; exit 1; }
realpath "$library"
