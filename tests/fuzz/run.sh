#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# usage: run.sh BUILD_DIR SOURCE_DIR COUNT SEED: nine tenths of the inputs are scenes, the rest meshes, which take longer.
set -u
build=$1 source=$2 count=$3 seed=$4
folder=$build/fuzz
rm -rf "$folder"
meshes=$((count / 10))
status=0
for kind in scene mesh; do
  [ $kind = mesh ] && inputs=$meshes || inputs=$((count - meshes))
  "$build/signorini-fuzz-$kind" "$seed" "$inputs" "$source" "$folder" || {
    status=1
    echo "failed: the inputs are in $folder; last.* is the one that ended the program, if one did" >&2
  }
done
exit $status
