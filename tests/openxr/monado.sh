# Functions that start and end Monado with a simulated headset and without a display; after scripts/lib.sh.
# shellcheck shell=bash

XDG_RUNTIME_DIR=$(mktemp -d)
export XDG_RUNTIME_DIR XR_RUNTIME_JSON=/usr/share/openxr/1/openxr_monado.json
monado='' monado_log=$XDG_RUNTIME_DIR/monado.log
trap stop_all EXIT

# Monado ends when its standard input does, so it reads from a pipe to which nothing is written.
start_monado() {
  local give_up=$((SECONDS + 120)) input=$XDG_RUNTIME_DIR/input
  rm -f "$XDG_RUNTIME_DIR"/monado_comp_ipc "$input"
  mkfifo "$input"
  XRT_COMPOSITOR_NULL=1 SIMULATED_ENABLE=true monado-service <"$input" >"$monado_log" 2>&1 &
  monado=$!
  exec 8>"$input"
  until [[ -S $XDG_RUNTIME_DIR/monado_comp_ipc ]]; do
    kill -0 "$monado" 2>/dev/null || { cat "$monado_log" >&2; die "monado-service ended"; }
    ((SECONDS < give_up)) || { cat "$monado_log" >&2; die "monado-service does not listen"; }
    sleep 0.05
  done
}

# end_monado SIGNAL
end_monado() {
  [[ ! $monado ]] || { kill "-$1" "$monado" 2>/dev/null && wait "$monado" 2>/dev/null; } || true
  monado=''
  exec 8>&-
}

stop_all() {
  stop_server
  end_monado KILL
  rm -rf "$XDG_RUNTIME_DIR"
}
