#!/usr/bin/env bash
# build.sh WORK OUT: builds the page in the folder WORK, out of the source tree, into OUT. npm packages are installed
# there once, and again when the lock file changes.
set -euo pipefail
source=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1" "$2"
work=$(cd "$1" && pwd) out=$(cd "$2" && pwd)
for program in npm esbuild; do
  command -v $program > /dev/null && continue
  echo "$program is missing: the page needs nodejs, npm and esbuild (tools/packages.txt, groups web and page)" >&2
  exit 1
done

rm -rf "$work/src"
cp -R "$source"/{package.json,package-lock.json,.npmrc,tsconfig.json,src} "$work"
cd "$work"
if ! cmp -s package-lock.json node_modules/.installed; then
  npm ci --no-progress
  cp package-lock.json node_modules/.installed
fi
node_modules/.bin/tsc --noEmit
# Nothing inline and relative paths: the gateway's content policy, and proxies that put the page below a folder.
esbuild src/main.ts --bundle --minify --format=esm --target=es2021 --log-level=warning --outfile="$out/page.js"
rm -rf "$out/assets"  # of earlier versions
cp "$source/index.html" "$out"
