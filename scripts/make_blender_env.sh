#!/usr/bin/env bash
# Blender for the tests and for `mixlight insert --renderer blender`: PyPI's bpy in a virtual environment of its
# own. bpy is compiled for one Python and against NumPy 1, so it can never live in MixLight's own environment.
#
#   scripts/make_blender_env.sh FOLDER VERSION     FOLDER/bin/python then runs scripts that import bpy
#   scripts/make_blender_env.sh                    .interop/blender-4.5 and .interop/blender-5.0
#
# PYTHON311 names the interpreter where `python3.11` is not on PATH.
set -euo pipefail

make_one() {
    local folder=$1 version=$2
    local stamp="$folder/.made-bpy-$version"
    if [ -e "$stamp" ]; then return; fi
    if ! "$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
        echo "make_blender_env.sh: bpy $version needs Python 3.11; set PYTHON311 to one (tried: $python)" >&2
        exit 1
    fi
    rm -rf "$folder"
    mkdir -p "$(dirname "$folder")"
    # Some systems ship Python without ensurepip; their own pip then fills the environment.
    "$python" -m venv "$folder" 2>/dev/null || {
        "$python" -m venv --without-pip "$folder"
        "$python" -m pip --python "$folder/bin/python" install --quiet pip
    }
    "$folder/bin/python" -m pip --disable-pip-version-check install --quiet "bpy==$version" 'numpy<2'
    "$folder/bin/python" -c 'import bpy; print(bpy.app.version_string)' >"$stamp.part"
    mv "$stamp.part" "$stamp"
}

python=${PYTHON311:-python3.11}
case $# in
0)
    root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)/.interop"
    make_one "$root/blender-4.5" 4.5.15
    make_one "$root/blender-5.0" 5.0.1
    ;;
2)
    make_one "$1" "$2"
    ;;
*)
    sed -n '5,8s/^# *//p' "$0" >&2
    exit 2
    ;;
esac
