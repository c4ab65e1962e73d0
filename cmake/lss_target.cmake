# lss_target(NAME LIBRARY|OBJECTS|INTERFACE|PROGRAM|TEST [SOURCES ...] [APART ...] [LINK ...] [SYSTEM ...] [LABELS ...])
#
# The only place with the compiler settings of this project, also for vehicles from outside (lss_add_vehicle.cmake):
# C++20, warnings (errors in the presets of this tree), sanitizers by preset, includes from the top of the project ("gnc/zebro/gait.h").
# LINK names our own targets and well-behaved imported ones; SYSTEM names third-party include directories whose warnings
# are not ours. Sources are compiled in groups, which takes a third of the time (LSS_UNITY); APART sources are compiled
# separately, because their names conflict with those of others. OBJECTS: a library whose every source is linked. A TEST
# is linked to GoogleTest's main and registered with CTest case by case under its LABELS; only those with the label
# "threads" run under the thread sanitizer, and tools/test without words leaves out those with the label "long" and does
# not build them (property LSS_LONG of a target).

set(LSS_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast
                 -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion -Wformat=2)

# Whether the compiler fuses a multiplication with an addition depends on the optimisation.
set(LSS_BASELINE_X86 OFF)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT CMAKE_CXX_FLAGS MATCHES "-m(arch|fma|avx)")
  set(LSS_BASELINE_X86 ON)
endif()

function(lss_target name kind)
  cmake_parse_arguments(ARG "" "" "SOURCES;APART;LINK;SYSTEM;LABELS" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "lss_target(${name}): do not know ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(kind STREQUAL "INTERFACE")
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
    target_link_libraries(${name} INTERFACE ${ARG_LINK})
    target_include_directories(${name} SYSTEM INTERFACE "$<BUILD_INTERFACE:${ARG_SYSTEM}>")
    return()
  elseif(kind STREQUAL "LIBRARY")
    add_library(${name} STATIC ${ARG_SOURCES} ${ARG_APART})
  elseif(kind STREQUAL "OBJECTS")
    add_library(${name} OBJECT ${ARG_SOURCES} ${ARG_APART})
  elseif(kind STREQUAL "PROGRAM" OR kind STREQUAL "TEST")
    add_executable(${name} ${ARG_SOURCES} ${ARG_APART})
  else()
    message(FATAL_ERROR "lss_target(${name}): kind is LIBRARY, OBJECTS, INTERFACE, PROGRAM or TEST, not ${kind}")
  endif()

  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF UNITY_BUILD_BATCH_SIZE 8)
  if(LSS_UNITY)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON)
  endif()
  set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_include_directories(${name} SYSTEM PUBLIC "$<BUILD_INTERFACE:${ARG_SYSTEM}>")
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:${LSS_WARNINGS}>)
  if(NOT LSS_BASELINE_X86)  # a recording gives the same bits in every preset: docs/recording.md
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>)
  endif()
  target_link_libraries(${name} PUBLIC ${ARG_LINK})
  if(LSS_SANITIZE)
    set(checks ${LSS_SANITIZE})
    if(kind STREQUAL "TEST")  # "undefined" not in tests: in test libraries' templates it takes 60 % of the compiler's time
      string(REPLACE ",undefined" "" checks ${checks})
    endif()
    target_compile_options(${name} PRIVATE -fsanitize=${checks} -fno-omit-frame-pointer)
    target_link_options(${name} PRIVATE -fsanitize=${LSS_SANITIZE})
    target_compile_definitions(${name} PRIVATE LSS_SANITIZED=1)
    if(name MATCHES "^lss_(gnc|sim)_")  # mathematics and physics: tests run hours of a vehicle's time
      target_compile_options(${name} PRIVATE -O1)
    endif()
  elseif(kind STREQUAL "TEST" AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
    # Tested code is optimised; a test only where it steps hours of a vehicle's time. This halves the compiler's time.
    set(level -O0)
    if(CMAKE_CURRENT_SOURCE_DIR MATCHES "/(gnc|sim|chain|mission|campaign|lc)$")
      set(level -O1)
    endif()
    target_compile_options(${name} PRIVATE ${level})
    if(CMAKE_PROJECT_NAME STREQUAL "lssd")  # its preset debug has lines for debuggers
      target_compile_options(${name} PRIVATE -g0)
    endif()
  endif()

  if(kind STREQUAL "TEST")
    target_link_libraries(${name} PRIVATE GTest::gtest GTest::gmock GTest::gtest_main)
    find_program(LSS_MOLD mold)
    if(LSS_MOLD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12.1)
      target_link_options(${name} PRIVATE -fuse-ld=mold)
    endif()
  endif()
  if(kind STREQUAL "TEST" AND LSS_SANITIZE STREQUAL "thread" AND NOT "threads" IN_LIST ARG_LABELS)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)  # one thread: nothing to find
  elseif(kind STREQUAL "TEST")
    if("long" IN_LIST ARG_LABELS)
      set_target_properties(${name} PROPERTIES LSS_LONG ON)
    endif()
    list(JOIN ARG_LABELS "+" labels)  # a list would lose all but its first
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS "${labels}" TIMEOUT 1200)
  elseif(kind STREQUAL "PROGRAM")
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  endif()
endfunction()
