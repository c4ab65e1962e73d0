#!/usr/bin/env bash
# zebra.sh TREE FOLDER: makes in FOLDER a project of a vehicle from outside out of Lunar Zebro's sources, under the name
# zebra, which lssd does not know.
set -euo pipefail
tree=$1 folder=$2
mkdir -p "$folder"
(cd "$tree" && find gnc/zebro drivers/zebro idl/zebro daemon/vehicles/zebro tools/lss-sim/zebro tools/lss-lc/zebro \
  -name '*.h' -o -name '*.cpp' -o -name '*.idl') | while read -r file; do
  to=$folder/${file//zebro/zebra}
  mkdir -p "$(dirname "$to")"
  sed 's/zebro/zebra/g; s/Zebro\([A-Z]\)/Zebra\1/g' "$tree/$file" > "$to"
done
sed 's/zebro/zebra/g' "$tree/config/zebro.toml" > "$folder/zebra.toml"
sed 's/zebro/zebra/g' "$tree/tests/zebro/daemon/gate_test.cpp" > "$folder/gate_test.cpp"
cat > "$folder/CMakeLists.txt" << 'END'
cmake_minimum_required(VERSION 3.25)
project(zebra LANGUAGES C CXX)
find_package(lssd REQUIRED)
find_package(DART 6.12 REQUIRED COMPONENTS collision-bullet CONFIG)
file(GLOB daemon gnc/zebra/*.cpp drivers/zebra/leg_*.cpp daemon/vehicles/zebra/*.cpp)
file(GLOB simulator tools/lss-sim/zebra/*.cpp)
file(GLOB verified tools/lss-lc/zebra/*.cpp)
lss_add_vehicle(zebra
  IDL idl/zebra/zebra.idl
  DAEMON ${daemon}
  SIMULATOR ${simulator}
  VERIFIED ${verified}
  TESTS gate_test.cpp
  CONFIG zebra.toml
  LINK zebra_codec)
lss_target(zebra_codec LIBRARY SOURCES drivers/zebra/ascii_codec.cpp LINK lssd::lss_serial)
target_link_libraries(zebra_simulator PUBLIC dart dart-collision-bullet)
find_package(rapidcheck REQUIRED)
target_link_libraries(zebra_test PUBLIC rapidcheck)
END
