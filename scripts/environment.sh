# SPDX-License-Identifier: BSD-3-Clause
# Common ground of the scripts; sourced, not run. Sets `root` (the checkout) and an environment that holds on a bare Debian 12:
# Debian's own python3 before any other, a UTF-8 locale that is always there, and an address in place of host names.
# shellcheck shell=bash disable=SC2034

set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
export PATH="/usr/bin:/bin:/usr/sbin:/sbin:/usr/local/bin${PATH:+:$PATH}"
export LC_ALL=C.UTF-8
export HOME="${HOME:-/tmp}"
unset PYTHONHOME PYTHONPATH
# A bare system may not even know localhost.
if [[ -z ${ROS_HOSTNAME:-} && -z ${ROS_IP:-} ]]; then export ROS_IP=127.0.0.1; fi

say() { printf '%s\n' "[$(basename "$0")] $*" >&2; }
die() { say "$*"; exit 1; }

# The usage text of a script: the comment block under its licence line.
usage() { sed -n '3,/^$/s/^# \{0,1\}//p' "$0"; }

# Makes the built package known to ROS. catkin's file reads variables that need not be set.
source_workspace() {
  set +u
  # shellcheck disable=SC1090,SC1091
  . "$1/devel/setup.bash"
  set -u
}
