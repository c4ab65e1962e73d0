#!/usr/bin/env bash
# errors.sh CMAKE BUILD FOLDER: calls of lss_add_vehicle() with a mistake say what to do.
# shellcheck source=tests/outside/common.sh
. "$(dirname "$0")/common.sh"
failed=0
install_fresh dev
mkdir "$folder/project"
cd "$folder/project"
cat > CMakeLists.txt << 'END'
cmake_minimum_required(VERSION 3.25)
project(outside LANGUAGES C CXX)
find_package(lssd REQUIRED)
include(call.cmake)
END
printf 'module lss {\n  struct ScoutTelemetry { @key char vehicle_id[16]; long long time_ns; };\n};\n' > scout.idl
cp scout.idl zebro.idl
cp scout.idl Rover.idl
echo 'module lss { struct RoverTelemetry { octet x; }; };' > empty.idl
echo '// scout_port() scout_records()' > vehicle.cpp
touch nothing.cpp

refused() {  # SENTENCE CALL
  local output
  echo "$2" > call.cmake
  if output=$("$cmake" -S . -B build -DCMAKE_PREFIX_PATH="$folder/usr" 2>&1) ||
    ! tr -s ' \n' ' ' <<< "$output" | grep -qF "$1"; then
    printf 'not said: %s\n%s\n' "$1" "$output"
    failed=1
  fi
}

refused 'a vehicle'"'"'s name is lower-case letters and digits, and begins with a letter: scout' \
  'lss_add_vehicle(Scout IDL scout.idl DAEMON vehicle.cpp)'
refused 'lssd has a vehicle of this name itself' 'lss_add_vehicle(zebro IDL zebro.idl DAEMON vehicle.cpp)'
refused 'give the vehicle'"'"'s telemetry: IDL scout.idl' 'lss_add_vehicle(scout DAEMON vehicle.cpp)'
refused 'give the sources of the vehicle: DAEMON vehicle.cpp' 'lss_add_vehicle(scout IDL scout.idl)'
refused '"vehicle.cpp" belongs to no argument' 'lss_add_vehicle(scout vehicle.cpp IDL scout.idl)'
refused 'nothing follows CONFIG' 'lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp CONFIG)'
refused 'there is no file' 'lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp TESTS missing_test.cpp)'
refused 'rename it to scout.idl' 'lss_add_vehicle(scout IDL zebro.idl DAEMON vehicle.cpp)'
refused 'does not define lss::EmptyTelemetry' 'lss_add_vehicle(empty IDL empty.idl DAEMON vehicle.cpp)'
refused 'none of the DAEMON sources (nothing.cpp) defines lss::scout_port()' \
  'lss_add_vehicle(scout IDL scout.idl DAEMON nothing.cpp)'
refused 'none of the SIMULATOR sources (nothing.cpp) defines lss::sim::make_scout_kind()' \
  'lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp SIMULATOR nothing.cpp)'
refused 'none of the VERIFIED sources (nothing.cpp) defines LSS_VERIFIED(scout, ...)' \
  'lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp VERIFIED nothing.cpp)'
refused 'this project has a vehicle of this name already' \
  'lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp)
   lss_add_vehicle(scout IDL scout.idl DAEMON vehicle.cpp)'

[ "$failed" = 0 ] && echo 'each mistake is reported'
exit "$failed"
