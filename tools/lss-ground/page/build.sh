#!/usr/bin/env bash
# build.sh WORK OUT: builds the page in the folder WORK, out of the source tree, into OUT. npm packages are installed
# there once, and again when the lock file changes.
set -euo pipefail
source=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1" "$2"
work=$(cd "$1" && pwd) out=$(cd "$2" && pwd)
command -v npm > /dev/null || { echo "npm is missing: the page needs nodejs and npm (tools/packages.txt, group web)" >&2; exit 1; }

rm -rf "$work/src"
cp -R "$source"/{package.json,package-lock.json,.npmrc,tsconfig.json,vite.config.js,index.html,src} "$work"
cd "$work"
if ! cmp -s package-lock.json node_modules/.installed; then
  npm ci --no-progress
  cp package-lock.json node_modules/.installed
fi
node_modules/.bin/tsc --noEmit
LSS_PAGE_OUT=$out node_modules/.bin/vite build
