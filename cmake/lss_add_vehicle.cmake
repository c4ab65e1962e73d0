# lss_add_vehicle(NAME IDL FILE DAEMON SOURCES... [SIMULATOR SOURCES...] [VERIFIED SOURCES...] [TESTS SOURCES...]
#                 [CONFIG FILE] [LINK LIBRARIES...])
#
# A vehicle outside of the tree of lssd: programs lssd-NAME, lss-sim-NAME and lss-lc-NAME, tests, and their installation.
# Part of the package liblssd-dev; docs/liblssd-dev.md describes the arguments and what each source defines.

# Fails with a sentence that begins with the call.
function(lss_vehicle_error name sentence)
  message(FATAL_ERROR "lss_add_vehicle(${name}): ${sentence}")
endfunction()

# lss_vehicle_defines(NAME KEYWORD FUNCTION HEADER SOURCE...): one of the sources names the function. Where none does, the
# linker would say so, later and less clearly.
function(lss_vehicle_defines name keyword function header)
  string(REGEX REPLACE "^.*::|[(][)]$|, [.]+[)]$" "" wanted ${function})
  foreach(source ${ARGN})
    get_filename_component(path ${source} ABSOLUTE)
    if(NOT EXISTS ${path})
      return()  # made by the build
    endif()
    file(READ ${path} text)
    string(FIND "${text}" "${wanted}" found)
    if(NOT found EQUAL -1)
      return()
    endif()
  endforeach()
  lss_vehicle_error(${name} "none of the ${keyword} sources (${ARGN}) defines ${function}; write it, as ${header} says")
endfunction()

function(lss_vehicle_check name idl)
  if(NOT name MATCHES "^[a-z][a-z0-9]*$")
    string(TOLOWER "${name}" better)
    string(REGEX REPLACE "[^a-z0-9]|^[0-9]+" "" better "${better}")
    lss_vehicle_error(${name} "a vehicle's name is lower-case letters and digits, and begins with a letter: ${better}")
  elseif(name IN_LIST lssd_VEHICLES)
    lss_vehicle_error(${name} "lssd has a vehicle of this name itself (${lssd_VEHICLES}); choose another one")
  elseif(TARGET lssd-${name})
    lss_vehicle_error(${name} "this project has a vehicle of this name already; choose another one")
  endif()
  foreach(file ${ARGN})
    get_filename_component(path ${file} ABSOLUTE)
    get_source_file_property(made ${path} GENERATED)
    if(NOT EXISTS ${path} AND NOT made)
      lss_vehicle_error(${name} "there is no file ${path}; write it, or correct the path")
    endif()
  endforeach()
  get_filename_component(stem ${idl} NAME)
  if(NOT stem STREQUAL "${name}.idl")
    lss_vehicle_error(${name} "IDL ${idl}: rename it to ${name}.idl, sources include its types as <${name}_fields.h>")
  endif()
  lss_type_name(${name} type)
  file(READ ${idl} text)
  if(NOT text MATCHES "module[ \n]+lss[ \n]*{" OR NOT text MATCHES "struct[ \n]+${type}Telemetry[ \n]*{")
    lss_vehicle_error(${name} "${idl} does not define lss::${type}Telemetry; write struct ${type}Telemetry in module lss")
  endif()
endfunction()

function(lss_add_vehicle name)
  cmake_parse_arguments(ARG "" "IDL;CONFIG" "DAEMON;SIMULATOR;VERIFIED;TESTS;LINK" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    lss_vehicle_error(${name} "\"${ARG_UNPARSED_ARGUMENTS}\" belongs to no argument; known are IDL, DAEMON, SIMULATOR, VERIFIED, TESTS, CONFIG and LINK")
  elseif(ARG_KEYWORDS_MISSING_VALUES)
    lss_vehicle_error(${name} "nothing follows ${ARG_KEYWORDS_MISSING_VALUES}; name a file, or leave it out")
  elseif(NOT ARG_IDL)
    lss_vehicle_error(${name} "give the vehicle's telemetry: IDL ${name}.idl")
  elseif(NOT ARG_DAEMON)
    lss_vehicle_error(${name} "give the sources of the vehicle: DAEMON vehicle.cpp")
  endif()
  lss_vehicle_check(${name} ${ARG_IDL} ${ARG_IDL} ${ARG_CONFIG} ${ARG_DAEMON} ${ARG_SIMULATOR} ${ARG_VERIFIED}
                    ${ARG_TESTS})
  set(roster ${CMAKE_CURRENT_BINARY_DIR}/${name}/roster)
  lss_roster(${roster} ${name})

  # A program is main(), a roster of one, and objects; these also for the verification and for tests.
  lss_vehicle_defines(${name} DAEMON "lss::${name}_port()" daemon/app/roster.h ${ARG_DAEMON})
  lss_vehicle_defines(${name} DAEMON "lss::${name}_records()" daemon/replay/records.h ${ARG_DAEMON})
  lss_idl_library(${name}_idl ${ARG_IDL})
  lss_target(${name}_daemon OBJECTS
    SOURCES ${ARG_DAEMON} ${lssd_SOURCES}/daemon/publish/roster.cpp ${lssd_SOURCES}/daemon/replay/records.cpp
    SYSTEM ${roster}
    LINK ${ARG_LINK} ${name}_idl lssd::lss_replay lssd::lss_runtime lssd::lss_kit lssd::lss_serial)
  set(folders "")
  foreach(source ${ARG_DAEMON})
    get_filename_component(folder ${source} ABSOLUTE)
    get_filename_component(folder ${folder} DIRECTORY)
    list(APPEND folders ${folder}/*.h)
  endforeach()
  list(REMOVE_DUPLICATES folders)
  file(GLOB headers CONFIGURE_DEPENDS ${folders})
  lss_kept_members(${name}_daemon ${headers})
  set(parts ${name}_daemon)
  lss_target(lssd-${name} PROGRAM SOURCES ${lssd_SOURCES}/daemon/app/roster.cpp SYSTEM ${roster}
             LINK ${name}_daemon lssd::lss_daemon_program)

  if(ARG_SIMULATOR)
    lss_vehicle_defines(${name} SIMULATOR "lss::sim::make_${name}_kind()" tools/lss-sim/frame/vehicle.h ${ARG_SIMULATOR})
    lss_target(${name}_simulator OBJECTS SOURCES ${ARG_SIMULATOR} LINK ${ARG_LINK} lssd::lss_sim_frame)
    list(APPEND parts ${name}_simulator)
    lss_target(lss-sim-${name} PROGRAM SOURCES ${lssd_SOURCES}/tools/lss-sim/roster.cpp SYSTEM ${roster}
               LINK ${name}_simulator lssd::lss_sim_program)
  endif()

  if(ARG_VERIFIED)
    lss_vehicle_defines(${name} VERIFIED "LSS_VERIFIED(${name}, ...)" tools/lss-lc/vehicle.h ${ARG_VERIFIED})
    lss_target(${name}_verified OBJECTS SOURCES ${ARG_VERIFIED} LINK ${ARG_LINK} ${name}_daemon lssd::lss_lc_explorer)
    list(APPEND parts ${name}_verified)
    lss_target(lss-lc-${name} PROGRAM SOURCES ${lssd_SOURCES}/tools/lss-lc/roster.cpp SYSTEM ${roster}
               LINK ${name}_verified ${name}_daemon lssd::lss_lc_program)
    add_test(NAME ${name}.controller_keeps_its_requirements COMMAND lss-lc-${name} explore)
    set_tests_properties(${name}.controller_keeps_its_requirements PROPERTIES LABELS ${name} TIMEOUT 1800)
  endif()

  if(ARG_TESTS AND (BUILD_TESTING OR NOT DEFINED BUILD_TESTING))
    find_package(GTest QUIET)
    if(NOT GTest_FOUND)
      lss_vehicle_error(${name} "TESTS need GoogleTest: sudo apt-get install libgtest-dev libgmock-dev")
    endif()
    include(GoogleTest)
    lss_target(${name}_test TEST SOURCES ${ARG_TESTS} LINK ${parts} lssd::lss_allocations LABELS ${name})
    if(ARG_CONFIG)
      get_filename_component(config ${ARG_CONFIG} ABSOLUTE)
      target_compile_definitions(${name}_test PRIVATE LSS_CONFIG="${config}")
    endif()
  endif()
  lss_install_vehicle(${name} "${ARG_IDL}" "${ARG_CONFIG}")
endfunction()

# The programs; the configuration in /etc/lss where the prefix is /usr; and the unit lssd@NAME, of the package lssd, with
# this program.
function(lss_install_vehicle name idl config)
  set(confdir ${CMAKE_INSTALL_SYSCONFDIR}/lss)
  if(CMAKE_INSTALL_FULL_SYSCONFDIR STREQUAL "/etc")
    set(confdir /etc/lss)
  endif()
  install(TARGETS lssd-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  if(TARGET lss-sim-${name})
    install(TARGETS lss-sim-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
  install(FILES ${idl} DESTINATION ${CMAKE_INSTALL_DATADIR}/lss/idl)
  if(NOT config)
    return()
  endif()
  install(FILES ${config} DESTINATION ${confdir} RENAME ${name}.toml)
  set(unit ${CMAKE_CURRENT_BINARY_DIR}/${name}/program.conf)
  set(arguments "--config ${CMAKE_INSTALL_FULL_SYSCONFDIR}/lss/${name}.toml --run-dir /run/lss")
  file(CONFIGURE OUTPUT ${unit} @ONLY CONTENT [[
[Service]
ExecStart=
ExecStart=@CMAKE_INSTALL_FULL_BINDIR@/lssd-@name@ @arguments@
]])
  install(FILES ${unit} DESTINATION lib/systemd/system/lssd@${name}.service.d)
endfunction()
