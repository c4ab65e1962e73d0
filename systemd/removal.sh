#!/usr/bin/env bash
# removal.sh BUILD_DIR: the packages lss-ground and lss-ros end their services when they are removed, not when they are
# upgraded. A folder stands in for the system.
set -euo pipefail
build=$1
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
wants=$root/etc/systemd/system/multi-user.target.wants
mkdir -p "$root/bin" "$root/run/systemd/system" "$wants"
printf '#!/bin/sh\necho "$@" >> "%s/said"\n' "$root" > "$root/bin/systemctl"
chmod +x "$root/bin/systemctl"

check() {  # PACKAGE UNITS ENABLED
  local script=$build/systemd/$1/prerm
  grep -qF "$script" "$build/CPackConfig.cmake" || { echo "the package $1 has no prerm"; exit 1; }
  sed "s@ /run/@ $root/run/@; s@ /etc/@ $root/etc/@" "$script" > "$root/prerm"
  : > "$root/said"
  ln -s nowhere "$wants/$3"
  ln -sf nowhere "$wants/other.service"
  PATH=$root/bin:$PATH sh "$root/prerm" upgrade 2.0
  if [ -s "$root/said" ] || [ ! -L "$wants/$3" ]; then echo "$1: an upgrade ends its service" && exit 1; fi
  PATH=$root/bin:$PATH sh "$root/prerm" remove
  [ "$(cat "$root/said")" = "stop $2" ] || { echo "$1: its service goes on: $(cat "$root/said")"; exit 1; }
  if [ -L "$wants/$3" ] || [ ! -L "$wants/other.service" ]; then echo "$1: links: $(ls "$wants")" && exit 1; fi
}

check lss-ground lss-ground.service lss-ground.service
check lss-ros 'lss-ros@*.service' lss-ros@zebro-1.service
echo "services end with their packages"
