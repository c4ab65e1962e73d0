#!/usr/bin/env bash
# page_needs_npm.sh PAGE: without npm the page is not built, and the message names it; its lock file has a checksum of
# each package and no address to get it from.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/bin"
for program in bash dirname mkdir; do ln -s "$(command -v $program)" "$folder/bin/"; done
if PATH=$folder/bin bash "$1/build.sh" "$folder/work" "$folder/page" 2> "$folder/said"; then
  echo "it was built without npm"
  exit 1
fi
cat "$folder/said"
grep -q "npm is missing: .*nodejs, npm and esbuild" "$folder/said"
[ ! -e "$folder/page/index.html" ]

if grep '"resolved"' "$1/package-lock.json"; then
  echo "the lock file has addresses"
  exit 1
fi
packages=$(grep -c '"node_modules/' "$1/package-lock.json")
sums=$(grep -c '"integrity": "sha512-' "$1/package-lock.json")
echo "$packages packages, $sums checksums"
[ "$packages" -gt 0 ] && [ "$packages" -eq "$sums" ]
