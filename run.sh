#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail

usage() {
  cat <<'TEXT'
./run.sh CONFIG.ini [cf-run options]
./run.sh PHOTOS [PHOTOS2 …] [cf-import options] [cf-run options]
./run.sh [cf-run options]

Installs what is missing, builds, and runs the main job: a configuration, or folders of photos (one
UAV each), or, without either, the demo in rawlogs/ with config.ini.

  cf-import options  --split N|strips  --geo FILE  --camera FILE  --sigma H,V
  cf-run options     -o OUTDIR  -s section.key=value  -w  --resume

Photos are imported into ./imported/NAME, NAME being the first folder's. Without -o the results lie
beside the configuration, in results/.
TEXT
}

fail() {
  echo "run.sh: $*" >&2
  exit 2
}

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
config=
outdir=
photos=()
import_options=()
run_options=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help)
      usage
      exit 0
      ;;
    --split | --geo | --camera | --sigma)
      [ $# -ge 2 ] || fail "$1 needs a value"
      import_options+=("$1" "$2")
      shift
      ;;
    --split=* | --geo=* | --camera=* | --sigma=*) import_options+=("$1") ;;
    -o | --output | -s | --set | --role | --uav | --seam)
      [ $# -ge 2 ] || fail "$1 needs a value"
      run_options+=("$1" "$2")
      [[ $1 != -o && $1 != --output ]] || outdir=$2
      shift
      ;;
    -*)
      run_options+=("$1")
      case $1 in
        --output=*) outdir=${1#*=} ;;
        -o?*) outdir=${1#-o} ;;
      esac
      ;;
    *.ini)
      [ -z "$config" ] || fail "one configuration at a time: $config or $1"
      config=$1
      ;;
    *)
      [ -d "$1" ] || fail "'$1' is neither a configuration (.ini) nor a folder of photos"
      photos+=(--images "$1")
      ;;
  esac
  shift
done

if [ -n "$config" ]; then
  [ ${#photos[@]} -eq 0 ] || fail "give a configuration or folders of photos, not both"
  [ -f "$config" ] || fail "$config: no such configuration file"
elif [ ${#photos[@]} -eq 0 ]; then
  config=$root/config.ini
  [ -n "$outdir" ] || run_options+=(-w) # of the demo's own results
fi
[ ${#photos[@]} -gt 0 ] || [ ${#import_options[@]} -eq 0 ] ||
  fail "${import_options[0]} is for folders of photos, and none was given"

prepare() (
  cd "$root"
  source scripts/prepare.sh
  installPackages packages.txt
  build cf-import cf-simulate cf-run cf-snapshot cf-eval
)
prepare

if [ ${#photos[@]} -gt 0 ]; then
  imported=imported/$(basename "$(realpath "${photos[1]}")")
  "$root/build/bin/cf-import" "${photos[@]}" "${import_options[@]}" -o "$imported"
  config=$imported/config.ini
fi
"$root/build/bin/cf-run" "$config" "${run_options[@]}"

# Where to look: the folder is that of -o, else results/ beside the configuration.
outdir=${outdir:-$(dirname "$config")/results}
for result in report.html snapshots/top.png snapshots/iso.png cloud/cloud.ply; do
  [ ! -e "$outdir/$result" ] || echo "see   $outdir/$result"
done
