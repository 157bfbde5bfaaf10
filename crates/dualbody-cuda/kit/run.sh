#!/bin/sh
# Compares kernels on this machine's GPU with what the CPU has computed, and measures them. It needs a driver of NVIDIA's and nothing else: no network, compiler,
# Rust or Python. NVRTC, where it is there, compiles kernels for GPUs that the kit has none for.
#
#     ./run.sh                          all parts, in at most 4 minutes
#     ./run.sh correct rates            some parts: correct, rates, contact, batch-sizes, variants (these need NVRTC)
#     SECONDS_AT_MOST=60 ./run.sh       in less time: what was done then is kept
#     ROBOTS=ur5,panda ./run.sh         some robots
#     RESULTS=folder ./run.sh           where results.json, table.txt and log.txt go: ./results, if nothing is said
#
# The exit code is 0 if all that was compared is right, 1 if something is not, 2 if nothing could be run.
set -u
cd "$(dirname "$0")" || exit 2
kit=$(pwd)
results=${RESULTS:-$kit/results}
mkdir -p "$results" || exit 2

# The folder of a library of NVIDIA's with one of some names, in the usual places; nothing if there is none.
find_nvrtc() {
  for folder in "${CUDA_HOME:-/none}"/lib64 "${CUDA_PATH:-/none}"/lib64 /usr/local/cuda*/lib64 /usr/local/cuda*/targets/x86_64-linux/lib \
    /usr/lib/x86_64-linux-gnu /usr/lib64 \
    "${VIRTUAL_ENV:-/none}"/lib/python3*/site-packages/nvidia/*/lib "${CONDA_PREFIX:-/none}"/lib/python3*/site-packages/nvidia/*/lib \
    "${CONDA_PREFIX:-/none}"/lib "${HOME:-/none}"/.local/lib/python3*/site-packages/nvidia/*/lib \
    /usr/lib/python3*/site-packages/nvidia/*/lib /usr/local/lib/python3*/*-packages/nvidia/*/lib /opt/*/lib/python3*/site-packages/nvidia/*/lib \
    /opt/*/.venv/lib/python3*/site-packages/nvidia/*/lib; do
    for name in libnvrtc.so.13 libnvrtc.so.12; do
      [ -e "$folder/$name" ] && { echo "$folder/$name"; return; }
    done
  done
}

# The names that programs ask for: the folders of the driver are on the path of most machines already.
path=${LD_LIBRARY_PATH:-}
for folder in /usr/local/nvidia/lib64 /usr/lib/wsl/lib; do
  [ -d "$folder" ] && path="${path:+$path:}$folder"
done
nvrtc=$(find_nvrtc)
if [ -n "$nvrtc" ] && mkdir -p "$results/lib" && ln -sf "$nvrtc" "$results/lib/libnvrtc.so"; then
  path="$results/lib:$(dirname "$nvrtc")${path:+:$path}"
fi
export LD_LIBRARY_PATH="$path"

{
  uname -srm
  echo "NVRTC: ${nvrtc:-none}"
  command -v nvidia-smi >/dev/null 2>&1 && nvidia-smi --query-gpu=name,driver_version,memory.total,clocks.sm,clocks.max.sm,clocks.mem --format=csv
  [ -r /proc/driver/nvidia/version ] && cat /proc/driver/nvidia/version
} >"$results/machine.txt" 2>&1

# Programs, kernels and numbers of the kit are packed.
unpacked=$kit
[ -w "$kit" ] || unpacked=$results
if [ ! -x "$unpacked/kit" ]; then
  tar -xzf "$kit/packed.tar.gz" -C "$unpacked" || exit 2
fi

parts=$(IFS=,; echo "$*")
limit=${SECONDS_AT_MOST:-230}
set -- run "$unpacked" --seconds "$limit" --json "$results/results.json"
[ -n "$parts" ] && set -- "$@" --parts "$parts"
[ -n "${ROBOTS:-}" ] && set -- "$@" --robots "$ROBOTS"
# Something that hangs is ended, and what was found before stays.
if command -v timeout >/dev/null 2>&1; then
  timeout -k 5 "$((limit + 10))" "$unpacked/kit" "$@" >"$results/table.txt" 2>"$results/log.txt"
else
  "$unpacked/kit" "$@" >"$results/table.txt" 2>"$results/log.txt"
fi
code=$?

case ",$parts," in
  ,, | *,correct,*)
    if command -v python3 >/dev/null 2>&1 && [ -e "$unpacked/libkit_bridge.so" ]; then
      python3 "$kit/dlpack.py" "$unpacked/libkit_bridge.so" >>"$results/table.txt" 2>>"$results/log.txt" || code=1
    fi
    ;;
esac

[ -s "$results/table.txt" ] || sed 's/^ *[0-9.]* s  //' "$results/log.txt" >"$results/table.txt"
cat "$results/machine.txt" "$results/table.txt"
exit "$code"
