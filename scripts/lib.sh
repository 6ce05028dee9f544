# Shared by the scripts beside it: where the tree is, how to prepare it and how to build a preset.
# shellcheck shell=bash
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }
die() { say "$@"; exit 1; }

# As many compilers as there are cores, and 1.5 GB of free memory for each: glTF and Vulkan headers are heavy.
build_jobs() {
  local cores memory_jobs
  cores=$(nproc)
  memory_jobs=$(awk '/^MemAvailable/ { print int($2 / 1500000) }' /proc/meminfo)
  ((memory_jobs >= 1)) || memory_jobs=1
  echo $((cores < memory_jobs ? cores : memory_jobs))
}

# configure PRESET: quiet unless it fails.
configure() {
  local launcher=() log=$root/build/$1.configure.log
  if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  mkdir -p "$root/build"
  (cd "$root" && cmake --preset "$1" "${launcher[@]}") >"$log" 2>&1 ||
    { cat "$log" >&2; die "configuring $1 failed"; }
}

# build PRESET TARGET...: the compiler's progress is shown.
build() {
  local preset=$1
  shift
  say "building $preset"
  (cd "$root" && cmake --build --preset "$preset" -j "$(build_jobs)" --target "$@") || die "building $preset failed"
}

minutes() { printf '%d:%02d min' $(($1 / 60)) $(($1 % 60)); }
