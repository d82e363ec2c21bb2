# SPDX-License-Identifier: BSD-3-Clause
# ROS processes of a script, each with its log, on a roscore port of their own; all ended by process id when the script ends.
# Sourced after environment.sh. Set `output` to the folder for logs and pictures first.
# shellcheck shell=bash disable=SC2154

started=()

# start NAME COMMAND...: runs COMMAND in the background; its process id is in `pid`, its output in $output/log/NAME.log.
start() {
  local name=$1
  shift
  "$@" >"$output/log/$name.log" 2>&1 </dev/null &
  pid=$!
  started+=("$pid")
}

# end PID: asks first, as Ctrl-C would, insists after a while. roslaunch ends its own children.
end() {
  local signal
  for signal in INT TERM KILL; do
    kill -"$signal" "$1" 2>/dev/null || return 0
    for _ in {1..100}; do
      kill -0 "$1" 2>/dev/null || return 0
      sleep 0.1
    done
  done
}

end_all() {
  local i
  for ((i = ${#started[@]} - 1; i >= 0; i--)); do end "${started[i]}"; done
  started=()
}

# Why a background process failed: the end of its log.
log_tail() { sed 's/\x1b\[[0-9;]*m//g; s/^/    /' "$output/log/$1.log" | tail -n "${2:-20}" >&2; }

# Installs, builds and starts a roscore.
begin_session() {
  "$root/scripts/setup"
  say "building (some minutes the first time, seconds later)"
  mkdir -p "$output/log"
  rm -f "$output"/*.png
  "$root/scripts/build" >"$output/log/build.log" 2>&1 || { log_tail build 40; die "the build failed"; }
  export ROS_HOME=$output/log
  source_workspace "$root/build"
  trap end_all EXIT
  trap 'exit 130' INT
  trap 'exit 143' TERM
  local port
  port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
  export ROS_MASTER_URI=http://${ROS_HOSTNAME:-${ROS_IP:-}}:$port
  start roscore roscore -p "$port"
}

# Sets `screen` to a display without a monitor.
start_screen() {
  local number=$output/log/screen_number
  rm -f "$number"
  start xvfb Xvfb -displayfd 3 -screen 0 1400x900x24 -nolisten tcp 3>"$number"
  for _ in {1..100}; do
    [[ -s $number ]] && break
    sleep 0.1
  done
  [[ -s $number ]] || { log_tail xvfb; die "Xvfb did not start"; }
  # shellcheck disable=SC2034
  screen=:$(<"$number")
}

# start_rviz NAME DISPLAY: rviz with the package's view.
start_rviz() {
  install -d -m 700 "$output/log/runtime"
  start "$1" env DISPLAY="$2" XDG_RUNTIME_DIR="$output/log/runtime" QT_X11_NO_MITSHM=1 \
    roslaunch --wait patch_plane_clustering view.launch
}

# watch_with LAUNCH_PID ARG...: the lines of watch_sweeps.py, until it ends or the launch does. Sets `ended_first` to watcher or
# launch; the status is the watcher's.
watch_with() {
  local launch=$1 first='' status=0
  shift
  "$root/scripts/watch_sweeps.py" "$@" </dev/null &
  local watcher=$!
  started+=("$watcher")
  wait -n -p first "$watcher" "$launch" || status=$?
  ended_first=watcher
  if [[ $first == "$launch" ]]; then
    # shellcheck disable=SC2034
    ended_first=launch status=0
    end "$watcher"
    wait "$watcher" || status=$?
  fi
  return "$status"
}
