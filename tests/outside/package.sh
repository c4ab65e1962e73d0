#!/usr/bin/env bash
# package.sh CPACK CONFIG TREE: the package liblssd-dev has headers, libraries, CMake files and sources, nothing of a vehicle
# of the tree and no path of it, and depends on what its CMake files look for. Skipped (77) without dpkg.
set -euo pipefail
command -v dpkg-deb > /dev/null || { echo "not Debian"; exit 77; }
fail() { echo "$*" && exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" --config "$2" -B "$folder" -D CPACK_COMPONENTS_ALL=dev > "$folder/log" || { cat "$folder/log" && exit 1; }
package=$(echo "$folder"/liblssd-dev_*.deb)
dpkg-deb -x "$package" "$folder/tree"
cd "$folder/tree/usr"

for file in include/lssd/{daemon/app/runtime.h,daemon/replay/replay.h,drivers/canopen/master.h,idl/commands.h,lss_fields.h} \
  include/lssd/tools/{lss-sim/frame/vehicle.h,lss-lc/vehicle.h} share/lssd/roster/daemon/app/roster.cpp \
  share/lssd/examples/scout/CMakeLists.txt \
  lib/*/lssd/liblss_runtime.a lib/*/cmake/lssd/{lssd-config,lss_add_vehicle}.cmake; do
  [ -s "$file" ] || fail "the package has no $file"
done
if find . | grep -E 'zebro|ardito|talaris'; then fail "the package has files of vehicles"; fi
if grep -rlF "$3" .; then fail "these files have paths of the machine that built them"; fi

depends=$(dpkg-deb -f "$package" Depends)
echo "$depends"
# The package that each dependency of the CMake files comes from.
for found in CycloneDDS:cyclonedds-dev spdlog:libspdlog-dev fmt:libfmt-dev CLI11:libcli11-dev tl-expected:libexpected-dev \
  Boost:libboost-dev nlohmann_json:nlohmann-json3-dev tomlplusplus:libtomlplusplus-dev idlc:cyclonedds-tools \
  Python3:python3 crypto:libssl-dev; do
  [[ ", $depends," == *", ${found#*:},"* || ", $depends," == *", ${found#*:} "* ]] || fail "it does not depend on ${found#*:}"
  grep -rqE "\\b${found%:*}\\b" lib/*/cmake || fail "its CMake files do not look for ${found%:*}"
done
