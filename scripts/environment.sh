# Sourced by the other scripts: makes a virtual environment with haul_ros and its extra dependencies.
# Arguments: names of extras; its folder (.venv); a file of versions that pip has to take.
# Where ROS 2 Jazzy is sourced its own rclpy is used; elsewhere the real rclpy comes as a Python package.

fail() {
    echo "haul_ros: $1" >&2
    exit 2
}

[ "$(uname -sm)" = "Linux x86_64" ] || [ -n "${ROS_DISTRO:-}" ] ||
    fail "found $(uname -sm), but rclpy for machines without ROS 2 exists for Linux x86_64 only; source ROS 2 Jazzy first"

python=""
if [ -n "${ROS_DISTRO:-}" ]; then
    candidates="python3"
else
    candidates="python3 python3.13 python3.12 python3.11"
fi
for candidate in $candidates; do
    if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
[ -n "$python" ] || fail "found no Python 3.11, 3.12 or 3.13 (python3 is $(python3 --version 2>&1)); install one of them"
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "$("$python" --version) has no venv module; on Debian and Ubuntu: sudo apt install python3-venv"

environment="$(pwd)/${2:-.venv}"
if [ -n "${ROS_DISTRO:-}" ] && "$python" -c 'import rclpy' 2>/dev/null; then
    extras="$1"
    [ -x "$environment/bin/python" ] || "$python" -m venv --system-site-packages "$environment"
else
    extras="ros${1:+,$1}"
    [ -x "$environment/bin/python" ] || "$python" -m venv "$environment"
fi
# Python compiles what is imported; pip would compile all that there is, one file after the other
echo "haul_ros: installing into $environment (a minute the first time)"
"$environment/bin/python" -m pip install --quiet --no-compile --disable-pip-version-check ${3:+--constraint "$3"} \
    --editable ".${extras:+[$extras]}" ||
    fail "installation failed; the lines above tell why (no package index reachable?)"
PATH="$environment/bin:$PATH"
