#!/usr/bin/env bash
# Plants each violation that check_sources.sh looks for in a temporary tree and expects the check to find it.
set -euo pipefail
check=$(cd "$(dirname "$0")" && pwd)/check_sources.sh
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
failed=0

fresh() {
  rm -rf "${tree:?}"/*
  mkdir -p "$tree"/{gnc/{zebro,ardito},drivers/zebro,daemon/{cycle,runtime,publish,vehicles/zebro},idl,tools/lss-sim/zebro,tests/zebro}
  mkdir "$tree"/idl/{zebro,ardito}
  touch "$tree"/idl/{lss,zebro/zebro,ardito/ardito}.idl
  cat > "$tree/gnc/zebro/good.h" <<'SOURCE'
#include <array>
#include <Eigen/Core>
#include "gnc/zebro/other.h"
// a new gait: printf and std::vector may stand in a comment, and a storyteller is recommended
const char* text = "new std::string";
int renew(int new_gait);
SOURCE
  echo '#include <dds/dds.h>' > "$tree/daemon/publish/face.cpp"
  echo '#include <zebro_fields.h>' > "$tree/daemon/vehicles/zebro/vehicle.h"
  echo '#include "daemon/cycle/x.h"' > "$tree/daemon/publish/main.cpp"
  mkdir -p "$tree/tests/e2e"
  echo 'lss_e2e(walk Walk it_walks 60)' > "$tree/tests/e2e/CMakeLists.txt"
  echo '    def test_it_walks(self):' > "$tree/tests/e2e/test_walk.py"
  printf '%s\n' '#include "tools/lss-sim/zebro/vehicle.h"' 'TEST(Gait, ANewTendency) { told("octet"); }' > "$tree/tests/zebro/sim_test.cpp"
}

# plant PATH LINE RULE : one line more in a file that has nothing but violations; the check must report it by that rule.
planted=()
plant() {
  local number
  printf '%s\n' "$2" >> "$tree/$1"
  number=$(wc -l < "$tree/$1")
  planted+=("$1:$number:" "$2" "$3")
}

# The line of output that follows a violation is its rule; others may have the same place.
expect_faults() {
  local output i place rules
  if output=$("$BASH" "$check" "$tree"); then
    echo 'a tree with violations is accepted'
    failed=1
  fi
  for ((i = 0; i < ${#planted[@]}; i += 3)); do
    place=${planted[i]}
    rules=$(grep -A1 -F "$place" <<< "$output" | grep '^    ' || true)
    grep -qF "${planted[i + 2]}" <<< "$rules" && continue
    printf 'not caught: %s in %s\n%s\n' "${planted[i + 1]}" "$place" "$rules"
    failed=1
  done
}

fresh
"$BASH" "$check" "$tree" || { echo 'a good tree is refused'; failed=1; }

for line in 'int* a = new int;' 'void* b = malloc(1);' 'std::vector<int> c;' 'std::string d;' 'std::mutex e;' \
            'spdlog::info("x");' 'printf("x");' 'dds_write(w, &x);' 'clock_gettime(0, &t);'; do
  plant gnc/zebro/bad.cpp "$line" 'gnc allocates nothing'
done
plant gnc/zebro/bad.cpp 'double x = std::sin(y);' 'code of the cycle takes such functions'
plant daemon/vehicles/zebro/bad.cpp 'double x = std::log10 (y);' 'code of the cycle takes such functions'
plant gnc/zebro/bad.h '#include "drivers/time.h"' 'gnc includes Eigen'
plant gnc/zebro/bad.h '#include <sys/mman.h>' 'gnc includes Eigen'
plant drivers/zebro/bad.h '#include "idl/codes.h"' 'drivers include'
plant drivers/zebro/bad.h '#include <fmt/format.h>' 'drivers include'
plant daemon/cycle/bad.cpp '#include <dds/dds.h>' 'DDS types stay'
plant daemon/vehicles/zebro/vehicle.cpp '#include "zebro.h"' 'DDS types stay'
plant daemon/cycle/bad.cpp '#include <zebro_fields.h>' 'DDS types stay'
plant daemon/cycle/bad.cpp '#include "daemon/runtime/x.h"' 'daemon/cycle includes no room that comes after it'
plant daemon/runtime/bad.cpp '#include "daemon/vehicles/zebro/x.h"' 'daemon/runtime includes no room'
plant tests/zebro/bad.cpp 'CLI11_PARSE(app, argc, argv);' 'a program ends with 2'
for line in '// the pilot is told' 'int a;  // tells it' '// begins anew' '/// mended by hand'; do
  plant daemon/runtime/bad.h "$line" 'a comment without'
done
for line in 'TEST(Gait, TellsItsRhythm) {' 'TEST_F(Gait, IsTold) {' 'TYPED_TEST_P(Gait, BeginsAnewAtOnce) {' \
            'RC_GTEST_PROP(Gait, WhateverItIs, ()) {'; do
  plant tests/zebro/bad.cpp "$line" 'a name of a test without Told'
done
plant tests/e2e/test_walk.py '    def test_it_stops(self):' 'is in its CMakeLists.txt'
plant tests/zebro/test_bad.py '    def test_a_cut_bus_is_mended(self):' 'a name of a test without told'
plant daemon/cycle/bad.cpp '#include "tools/lss-sim/zebro/vehicle.h"' 'nothing but tools and tests'
plant daemon/cycle/bad.cpp '#include "tests/zebro/x.h"' 'nothing includes tests'
plant gnc/zebro/bad.h '#include "gnc/ardito/drive.h"' 'vehicle zebro includes vehicle ardito'
plant daemon/vehicles/zebro/vehicle.cpp '#include "idl/ardito/commands.h"' 'vehicle zebro includes vehicle ardito'
plant tools/lss-sim/zebro/vehicle.cpp '#include "drivers/ardito/x.h"' 'vehicle zebro includes vehicle ardito'

expect_faults

fresh
rm "$tree/tests/e2e/CMakeLists.txt"
planted=(tests/e2e/test_walk.py:1: 'a test without tests/e2e/CMakeLists.txt' 'is in its CMakeLists.txt')
expect_faults

[ "$failed" = 0 ] && echo 'each violation is caught'
exit "$failed"
