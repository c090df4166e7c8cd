#!/bin/sh
# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Prints the path of a Python that has Blender (bpy) and everything that the scripts and tests need, in a virtual
# environment inside the checkout. If necessary, it makes or updates that environment first.
#
#   scripts/environment.sh [--blender 4.5|5.0|5.1|5.2]
#
# Without --blender the Python that is found decides: 3.13 gives Blender 5.2, 3.11 gives 5.0. $PYTHON names an
# interpreter to use instead. Exit codes: 2 bad call, 3 no suitable Python, 1 anything else.
set -eu

root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
requirements=$root/scripts/requirements

say() { printf '%s\n' "$*" >&2; }
fail() { code=$1; shift; say "$*"; exit "$code"; }

# "3.11" for an interpreter that starts, empty for one that does not: a pyenv shim exists for every installed version,
# even for those that are not selected.
version_of() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || true; }

# The first of the interpreters $2… that is Python $1.
choose() {
    version_wanted=$1
    shift
    for candidate; do
        if [ "$(version_of "$candidate")" = "$version_wanted" ]; then
            printf '%s\n' "$candidate"
            return
        fi
    done
}

blender=
case ${1-} in
    "") ;;
    --blender) blender=${2-} ;;
    *) fail 2 "Usage: scripts/environment.sh [--blender 4.5|5.0|5.1|5.2]" ;;
esac

case $blender in
    5.1 | 5.2) versions=3.13 ;;
    4.5 | 5.0) versions=3.11 ;;
    "")
        versions="3.13 3.11"
        if [ -n "${PYTHON-}" ]; then
            versions=$(version_of "$PYTHON")
            case $versions in
                3.11 | 3.13) ;;
                "") fail 3 "\$PYTHON is $PYTHON, which does not start." ;;
                *) fail 3 "\$PYTHON is $PYTHON, Python $versions; Blender needs Python 3.11 or 3.13." ;;
            esac
        fi
        ;;
    *) fail 2 "No environment for Blender $blender: choose 4.5, 5.0, 5.1 or 5.2." ;;
esac

# Interpreters on the path come first; then those of pyenv that are not selected.
python=
for place in path pyenv; do
    for version in $versions; do
        case $place in
            path) python=$(choose "$version" ${PYTHON:+"$PYTHON"} "python$version" python3 python) ;;
            pyenv) python=$(choose "$version" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python) ;;
        esac
        [ -z "$python" ] || break 2
    done
done
[ -n "$python" ] || fail 3 "No suitable Python: install Python $(echo $versions | sed 's/ / or /')" \
    "(Blender${blender:+ $blender} runs on no other), or name one with PYTHON=/path/to/python."

environment=$root/.venv-$version
case $version-$blender in
    3.13-5.1) environment=$environment-blender-5.1 ;;
    3.13-*) blender=5.2 ;;
    3.11-4.5) environment=$environment-blender-4.5 ;;
    3.11-*) blender=5.0 ;;
esac

interpreter=$environment/bin/python
[ ! -d "$environment/Scripts" ] || interpreter=$environment/Scripts/python.exe
stamp=$environment/stamp
wanted="$version $(cat "$requirements/bundled.txt" "$requirements/common.txt" "$requirements/blender-$blender.txt" | cksum)"

ready() { [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ] && [ "$(version_of "$interpreter")" = "$version" ]; }

if ! ready && command -v flock >/dev/null; then  # another command may be setting it up
    exec 9>"$environment.lock"
    flock 9
fi
if ! ready; then
    say "Setting up Blender $blender for Python $version in ${environment#"$root"/} (once; 1.4 GB on disk) ..."
    "$python" -m venv --clear "$environment" >&2 || fail 3 "$python cannot make virtual environments" \
        "(on Debian and Ubuntu: apt-get install python3-venv)."
    [ ! -d "$environment/Scripts" ] || interpreter=$environment/Scripts/python.exe
    # pip's output matters only if it fails.
    said=$("$interpreter" -m pip install --quiet --disable-pip-version-check --only-binary=:all: \
        -r "$requirements/blender-$blender.txt" 2>&1) ||
        { say "$said"; fail 1 "pip could not install what Blender $blender needs; see above."; }
    # Blender's Python module links to libraries of the desktop, which a server may lack.
    missing=$("$interpreter" -c 'import bpy' 2>&1 >/dev/null | grep -o 'lib[A-Za-z0-9_+-]*\.so[.0-9]*' | head -n 1) || true
    [ -z "$missing" ] || fail 1 "Blender's Python module needs the system library $missing; on Debian and Ubuntu:" \
        "apt-get install $("$root/scripts/system_libraries.sh")"
    "$interpreter" -c 'import bpy, numba, moderngl' >&2 || fail 1 "Blender's Python module does not start; see above."
    printf '%s\n' "$wanted" >"$stamp"
fi
printf '%s\n' "$interpreter"
