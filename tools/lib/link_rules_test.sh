#!/usr/bin/env bash
# Configures a small tree with each forbidden link in turn and expects cmake/link_rules.cmake to reject it.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
failed=0

mkdir -p "$tree"/{idl,gnc/{zebro,ardito},drivers/zebro,daemon/{cycle,publish},tools,tests}
cat > "$tree/CMakeLists.txt" <<EOF2
cmake_minimum_required(VERSION 3.20)
project(rules LANGUAGES NONE)
set(LSS_VEHICLES zebro ardito)
add_library(Eigen3::Eigen INTERFACE IMPORTED)
foreach(room idl gnc drivers daemon tools tests)
  add_subdirectory(\${room})
endforeach()
include($root/cmake/link_rules.cmake)
EOF2

target() {  # FOLDER NAME [LINKS...]
  local folder=$1 name=$2
  shift 2
  printf 'add_library(%s INTERFACE)\ntarget_link_libraries(%s INTERFACE %s)\n' "$name" "$name" "$*" \
    >> "$tree/$folder/CMakeLists.txt"
}

fresh() {
  find "$tree" -mindepth 2 -name CMakeLists.txt -delete
  rm -rf "$tree/build"
  target idl lss_idl
  printf 'add_subdirectory(zebro)\nadd_subdirectory(ardito)\n' > "$tree/gnc/CMakeLists.txt"
  target gnc/zebro gnc_zebro Eigen3::Eigen
  target gnc/ardito gnc_ardito Eigen3::Eigen
  printf 'add_subdirectory(zebro)\n' > "$tree/drivers/CMakeLists.txt"
  target drivers serial
  target drivers/zebro zebro_bus serial
  printf 'add_subdirectory(cycle)\nadd_subdirectory(publish)\n' > "$tree/daemon/CMakeLists.txt"
  target daemon/cycle core gnc_zebro zebro_bus
  target daemon/publish face lss_idl
  target daemon program core face
  target tools cli lss_idl
  target tests test_cli cli
}

configure() { cmake -S "$tree" -B "$tree/build" 2>&1; }

expect_fault() {  # FOLDER LINK
  fresh
  target "$1" culprit "$2"
  local output
  if output=$(configure) || ! tr -s ' \n' ' ' <<<"$output" | grep -qF "must not link $2"; then
    printf 'not caught: %s links %s\n%s\n' "$1" "$2" "$output"
    failed=1
  fi
}

fresh
configure > /dev/null || { echo 'a good tree is refused'; configure || true; failed=1; }

expect_fault gnc/zebro fmt
expect_fault gnc/zebro gnc_ardito
expect_fault gnc/ardito zebro_bus
expect_fault drivers/zebro Eigen3::Eigen
expect_fault drivers lss_idl
expect_fault daemon/cycle lss_idl
expect_fault daemon/cycle CycloneDDS::ddsc
expect_fault daemon CycloneDDS::ddsc
expect_fault daemon cli
expect_fault idl cli

[ "$failed" = 0 ] && echo 'each violation is caught'
exit "$failed"
