#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Makes viewer.min.js, which the build takes as it is, of viewer.js and three.js: after a change of
# either. Needs npm and the network; the versions are those of package.json.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here/package.json" "$here/viewer.js" "$work"
cd "$work"
npm install --no-package-lock --no-audit --no-fund
npx esbuild viewer.js --bundle --minify --format=iife --target=es2019 --legal-comments=eof \
  --outfile=viewer.min.js
cp viewer.min.js "$here/viewer.min.js"
cp node_modules/three/LICENSE "$here/three.LICENSE"
