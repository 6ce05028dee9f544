# Functions of the scripts in this folder: they configure and build a preset and start both programs.
# shellcheck shell=bash
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
programs=${FARSHADE_PROGRAMS:-$root/build/release}  # the build folder of the programs that scripts start

say() { printf '%s: %s\n' "${0##*/}" "$*" >&2; }
die() { say "$@"; exit 1; }
unknown_option() { say "unknown option '$1'; see ${0##*/} --help"; exit 2; }

# jobs_for N: prints the number of compilers or tests to run at the same time: at most N, but each needs 1.5 GB of free
# memory.
jobs_for() {
  local most=$1 memory_jobs
  memory_jobs=$(awk '/^MemAvailable/ { print int($2 / 1500000) }' /proc/meminfo)
  ((memory_jobs >= 1)) || memory_jobs=1
  echo $((most < memory_jobs ? most : memory_jobs))
}

# configure PRESET [CMAKE_OPTION...]: prints CMake's output only if it fails.
configure() {
  local preset=$1 options=() log=$root/build/$1.configure.log
  shift
  if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  options+=(-DFARSHADE_UNITY=ON)  # scripts build everything at once, so they compile the sources of a library together
  # Without this option CMake would keep what it found when it first configured the folder.
  if pkg-config --exists libavcodec libavutil libswscale; then options+=(-DFARSHADE_VIDEO=ON); fi
  mkdir -p "$root/build"
  (cd "$root" && cmake --preset "$preset" "${options[@]}" "$@") >"$log" 2>&1 ||
    { cat "$log" >&2; die "configuring $preset failed"; }
}

# configure_programs [CMAKE_OPTION...]: the preset release without the tests, which need more packages. A folder that is
# configured with the tests stays so.
configure_programs() {
  local options=("$@")
  [[ -f $root/build/release/CMakeCache.txt ]] || options+=(-DBUILD_TESTING=OFF)
  configure release "${options[@]}"
}

# configure_tests PRESET: with the tests, also if the folder was configured without them.
configure_tests() { configure "$1" -DBUILD_TESTING=ON; }

no_aslr=()  # a command that starts others without address space randomisation, for builds with sanitizers

# build PRESET TARGET...: shows the compiler's progress.
build() {
  local preset=$1
  shift
  say "building $preset"
  (cd "$root" && "${no_aslr[@]}" cmake --build --preset "$preset" -j "$(jobs_for "$(nproc)")" --target "$@") || die "building $preset failed"
}

# find_python: sets `python` to one with matplotlib and Pillow. Another Python may come first in PATH; the packages were
# installed for Debian's.
find_python() {
  for python in python3 /usr/bin/python3 ''; do
    if [[ -z $python ]] || "$python" -c 'import matplotlib, PIL' 2>/dev/null; then break; fi
  done
  [[ $python ]] || die "no python3 here has matplotlib: apt-get install python3-matplotlib"
}

minutes() { printf '%d:%02d min' $(($1 / 60)) $(($1 % 60)); }

# Ctrl-C and SIGTERM end a script at once, with the statuses that shells give to them. The server ends with the script.
server='' server_files=''
trap stop_server EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# start_server SCENE [OPTION...]: starts rt_server on a free loopback port. Sets `address`, where the server listens,
# and `key`, the key file that lets a client in: a new one, if `key` is not set before. If no light of the scene casts
# shadows, the server has nothing to serve: it ends, and `address` is one where nobody listens, because the client
# needs no server either.
start_server() {
  local program=$programs/rt_server/rt_server scene=$1 patience_s=240 give_up ready ring
  shift
  server_files=$(mktemp -d)
  server_log=$server_files/log
  : >"$server_log"  # the server opens it later than this script may read it
  if [[ ${key:-} ]]; then
    ring=$key  # a client's key file is a ring of one key
  else
    key=$server_files/client.key ring=$server_files/ring.keys
    "$program" --config '' keygen client --key "$key" --ring "$ring" >/dev/null || die "no key could be made"
  fi
  "$program" --config '' --scene "$scene" --listen 127.0.0.1:0 --keys "$ring" --ready-file "$server_files/ready" "$@" \
    >"$server_log" 2>&1 &
  server=$!
  give_up=$((SECONDS + patience_s))
  until ready=$(whole_line "$server_files/ready"); do
    if ! kill -0 "$server" 2>/dev/null; then
      # The server may have written the file and ended between these two checks.
      ready=$(whole_line "$server_files/ready") || server_failed "rt_server ended before it listened"
      break
    fi
    ((SECONDS < give_up)) || server_failed "rt_server did not listen within $patience_s s"
    sleep 0.05
  done
  case $ready in
    'listening '*) address=${ready#listening } ;;
    no-shadows) address=127.0.0.1:1 ;;
    *) server_failed "rt_server wrote '$ready' to its ready file" ;;
  esac
}

# whole_line FILE: prints the first line of FILE; fails if there is none that ends with a newline.
whole_line() {
  local line
  [[ -f $1 ]] && IFS= read -r line <"$1" && printf '%s\n' "$line"
}

# has_option NAME OPTION...: whether --NAME is among the options.
has_option() {
  local name=$1 option
  shift
  for option; do
    [[ $option != "--$name" && $option != "--$name="* ]] || return 0
  done
  return 1
}

# value_of NAME OPTION...: prints the value of --NAME among the options; nothing if it is not there.
value_of() {
  local name=$1
  shift
  while (($#)); do
    case $1 in
      "--$name") printf '%s\n' "${2:-}"; return ;;
      "--$name="*) printf '%s\n' "${1#*=}"; return ;;
    esac
    shift
  done
}

# default_options NAME VALUE...: adds those pairs to the array `options` whose name is not in it.
default_options() {
  local name
  while (($#)); do
    name=${1#--}
    has_option "$name" "${options[@]}" || options+=("$1" "$2")
    shift 2
  done
}

# shared_options OPTION...: sets `shared` to those options that server and client both need: they choose and light the
# scene, keep all of it, or leave the link without encryption.
shared_options() {
  local i
  shared=()
  for ((i = 1; i <= $#; ++i)); do
    case ${!i} in
      --light | --sun | --ambient | --exposure | --scene-index | --camera | --variant | --animation) shared+=("${@:i:2}"); i=$((i + 1)) ;;
      --light=* | --sun=* | --ambient=* | --exposure=* | --scene-index=* | --camera=* | --variant=* | --animation=*) shared+=("${!i}") ;;
      --insecure) shared+=(--insecure) ;;
    esac
  done
  [[ $(value_of plan "$@") != everything ]] || shared+=(--plan=everything)
}

# needs_no_server OPTION...: whether vr_client needs no server of this script.
needs_no_server() {
  has_option server "$@" || has_option replay "$@" || has_option export-trace "$@" ||
    { has_option plan "$@" && [[ $(value_of plan "$@") != everything ]]; }
}

# run_client [OPTION...] [-- OPTION_OF_RT_SERVER...]: starts rt_server and runs vr_client with it, by default on the
# bundled room. If vr_client needs no server of this script, only runs vr_client. If the client fails, prints the server's
# log and exits with the client's status. Neither reads the user's configuration file, because both need the same scene,
# lights and keys; a --config among the options goes to vr_client.
run_client() {
  local status=0 shared options=()
  while (($#)) && [[ $1 != -- ]]; do options+=("$1"); shift; done
  shift $(($# > 0))
  has_option server "${options[@]}" || default_options --scene "$root/assets/room.glb"
  default_options --config ''
  if needs_no_server "${options[@]}"; then
    (($# == 0)) || die "no rt_server is started, so '$*' has no effect: omit it"
  else
    shared_options "${options[@]}"
    key=$(value_of key "${options[@]}")
    start_server "$(value_of scene "${options[@]}")" "${shared[@]}" "$@"
    options+=(--server "$address")
    has_option insecure "${options[@]}" || default_options --key "$key"
  fi
  "$programs/vr_client/vr_client" "${options[@]}" || status=$?
  ((status)) || return 0
  # 130 and 143: somebody stopped the client. 2: its command line is wrong.
  if [[ $server && ! $status =~ ^(2|130|143)$ ]]; then
    sed 's/^/  /' "$server_log" >&2
    say "vr_client ended with status $status; the log of rt_server is above"
  fi
  exit "$status"
}

server_failed() {
  cat "$server_log" >&2
  stop_server
  die "$@"
}

# shellcheck disable=SC2317  # called by traps
stop_server() {
  local tries
  if [[ $server ]]; then
    kill "$server" 2>/dev/null || true
    # A server that does not listen yet has nothing to finish, and looks at signals late.
    for ((tries = 50; tries > 0; --tries)); do
      [[ -s $server_files/ready ]] || break
      kill -0 "$server" 2>/dev/null || break
      sleep 0.1
    done
    kill -KILL "$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
    server=''
  fi
  [[ ! $server_files ]] || rm -rf "$server_files"
}
