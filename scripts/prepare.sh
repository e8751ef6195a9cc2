# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# shellcheck shell=bash
# Sourced by run.sh and test.sh, in the root of the source tree.
#   installPackages LIST…   installs the packages of these files of scripts/ that are missing
#   build TARGET…           configures build/ and builds the targets
# Environment: CF_WERROR=ON makes compiler warnings errors.

say() { echo "== $*" >&2; }

installPackages() {
  if ! command -v dpkg-query >/dev/null; then
    say "not a Debian: install what scripts/packages.txt names by your own means if the build fails"
    return 0
  fi
  local wanted missing
  mapfile -t wanted < <(cat "${@/#/scripts/}" | grep -v '^#' | sort)
  # dpkg-query fails where it knows no package of a name; that one is missing, then.
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}") <(
    dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null |
      sed -n 's/^installed //p' | sort -u))
  [ ${#missing[@]} -gt 0 ] || return 0

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      say "run this as root: apt-get install --no-install-recommends" "${missing[@]}"
      return 1
    fi
    as_root=(sudo)
  fi
  say "installs" "${missing[@]}"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
  "${apt[@]}" update
  "${apt[@]}" install --no-install-recommends "${missing[@]}"
}

build() {
  local options=(-DCMAKE_BUILD_TYPE=Release "-DCF_WERROR=${CF_WERROR:-OFF}")
  [ -f build/CMakeCache.txt ] || options+=(-G Ninja)
  if command -v ccache >/dev/null; then
    options+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  say "configures build/"
  cmake -S . -B build "${options[@]}"
  say "builds" "$@"
  cmake --build build --parallel "$(nproc)" --target "$@"
}
