#!/bin/sh
# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# A Blender with a window on a machine without a screen. Needs Debian, or a similar system, and root.
#
#   scripts/windowed_blender.sh                                    installs it
#   scripts/windowed_blender.sh xvfb-run -a blender FILE.blend     runs a command beside it
#   SDF_LIGHTS_BLENDER="$PWD/scripts/windowed_blender.sh xvfb-run -a blender" scripts/test gui
#
# Installs Debian's Blender into a separate root folder, because the present system may be older. It includes a virtual
# screen, xdotool (keys and mouse), ImageMagick (screenshots), and the wheels of the extension's zip. This takes a few
# minutes and 2 GB once. Packages come from apt's mirror on this machine, wheels from pip's index.
#
# A command sees this checkout, the folder from which it is called and the temporary folder at their own paths. Mounts
# are made in a namespace of the command and end with it.
#
#   SDF_LIGHTS_BLENDER_ROOT     the root folder; /var/cache/sdf-lights-blender unless set
#   SDF_LIGHTS_BLENDER_SUITE    Debian's suite; sid unless set, as others have no Blender 4.5 or later
#   SDF_LIGHTS_BLENDER_MIRROR   mirror of Debian; apt's unless set
#
# Exit codes: 3 unsupported system, 1 the installation failed, else that of the command.
set -eu

checkout=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
root=${SDF_LIGHTS_BLENDER_ROOT:-/var/cache/sdf-lights-blender}
suite=${SDF_LIGHTS_BLENDER_SUITE:-sid}
# Debian's Blender does not depend on all Python modules that its own add-ons import.
packages="blender python3-cattr python3-numpy python3-openimageio python3-requests python3-zstandard
    imagemagick libegl1 libgl1-mesa-dri mesa-vulkan-drivers procps xauth xdotool xvfb"
wheels=$checkout/scripts/requirements/bundled.txt
stamp=$root/sdf-lights-blender
wanted="$suite $(echo "$packages" | cat - "$wheels" | cksum)"

fail() { code=$1; shift; printf '%s\n' "$*" >&2; exit "$code"; }

installed() { [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; }

# Prints the address of apt's first mirror with Debian itself, not its security updates or third-party packages.
mirror() {
    if [ -n "${SDF_LIGHTS_BLENDER_MIRROR-}" ]; then
        printf '%s\n' "$SDF_LIGHTS_BLENDER_MIRROR"
    else
        apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep '/debian/*$' | head -n 1
    fi
}

install_blender() {
    if ! command -v debootstrap >/dev/null; then
        apt-get update -q && apt-get install -y -q --no-install-recommends debootstrap || return 1
    fi
    state=$(cat "$stamp" 2>/dev/null) || state=begun
    if [ "$state" = begun ]; then
        if [ ! -f "$stamp" ] && [ -n "$(ls -A "$root" 2>/dev/null)" ]; then
            echo "$root holds something else: set SDF_LIGHTS_BLENDER_ROOT to a folder that is empty."
            return 1
        fi
        address=$(mirror)
        [ -n "$address" ] || { echo "apt has no mirror of Debian: set SDF_LIGHTS_BLENDER_MIRROR to one."; return 1; }
        rm -rf --one-file-system "$root"
        mkdir -p "$root"
        echo begun >"$stamp"
        debootstrap --variant=minbase "$suite" "$root" "$address" || return 1
    fi
    echo "not complete" >"$stamp"
    # The apt configuration of this machine's mirrors.
    apt-config dump --format '%f "%v";%n' | grep -i '^Acquire::https*::' >"$root/etc/apt/apt.conf.d/90from-outside" || true
    # Mirrors that stand still have expired Release files.
    # shellcheck disable=SC2086
    chroot "$root" apt-get -q -o Acquire::Check-Valid-Until=false update &&
        DEBIAN_FRONTEND=noninteractive chroot "$root" apt-get install -y -q --no-install-recommends $packages &&
        chroot "$root" apt-get clean || return 1
    inside=$(chroot "$root" python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])') || return 1
    outside=$("$checkout/scripts/environment.sh") || return 1
    "$outside" -m pip install --quiet --disable-pip-version-check --upgrade --no-deps --only-binary=:all: \
        --target "$root/usr/lib/python3/dist-packages" --implementation cp --python-version "$inside" \
        --platform "manylinux_2_28_$(uname -m)" --platform "manylinux_2_27_$(uname -m)" \
        --platform "manylinux_2_17_$(uname -m)" --requirement "$wheels" || return 1
    echo "$wanted" >"$stamp"
}

if ! installed; then
    command -v apt-get >/dev/null && [ "$(id -u)" = 0 ] || fail 3 "This script installs Blender with a window on" \
        "Debian, as root. Elsewhere, install Blender 4.5 or later, and without a screen also Xvfb, xdotool and" \
        "ImageMagick; then set SDF_LIGHTS_BLENDER to its command, such as \"xvfb-run -a blender\"."
    printf '%s\n' "Installing Blender with a window in $root (once; a few minutes, 2 GB on disk) ..." >&2
    mkdir -p "$(dirname "$root")"
    (
        flock 9  # another call may be installing
        installed || install_blender >"$root.log" 2>&1
    ) 9>"$root.lock" || { tail -n 20 "$root.log" >&2; fail 1 "Blender with a window could not be installed; see $root.log."; }
fi
[ $# -gt 0 ] || exit 0

temporary=${TMPDIR:-/tmp}
# A separate home, so that the settings of this machine's Blender stay unchanged.
export HOME="$temporary/sdf-lights-blender-home" LIBGL_ALWAYS_SOFTWARE=1
mkdir -p "$HOME"
export BLENDER_ROOT="$root" BLENDER_FOLDERS="$checkout:$temporary:$PWD"
# shellcheck disable=SC2016
exec unshare --mount sh -euc '
    for folder in proc sys dev; do mount --rbind "/$folder" "$BLENDER_ROOT/$folder"; done
    printf "%s\n" "$BLENDER_FOLDERS" | tr ":" "\n" | sort -u | while read -r folder; do
        # A folder inside one that was mounted before is there already; / would cover everything.
        [ "$folder" = / ] || [ "$folder" -ef "$BLENDER_ROOT$folder" ] || {
            mkdir -p "$BLENDER_ROOT$folder"
            mount --bind "$folder" "$BLENDER_ROOT$folder"
        }
    done
    exec env -u PYTHONPATH -u BLENDER_ROOT -u BLENDER_FOLDERS PATH=/usr/bin:/usr/sbin:/bin:/sbin \
        chroot "$BLENDER_ROOT" sh -c "cd \"\$0\" && exec \"\$@\"" "$PWD" "$@"
' sh "$@"
