# Component dev, package liblssd-dev: headers, static libraries, and the CMake package lssd with lss_add_vehicle(), to build
# a vehicle outside of this tree. No vehicle of this tree is part of it.
if(NOT LSS_DEV)
  return()
endif()
include(CMakePackageConfigHelpers)
set(lss_libdir ${CMAKE_INSTALL_LIBDIR}/lssd)
set(lss_cmakedir ${CMAKE_INSTALL_LIBDIR}/cmake/lssd)
set(lss_includedir ${CMAKE_INSTALL_INCLUDEDIR}/lssd)
set(lss_sources ${CMAKE_INSTALL_DATADIR}/lssd/roster)

install(TARGETS lss_codes lss_idl lss_idl_structs lss_idl_types lss_lockstep lss_serial lss_can_codec lss_can lss_canopen
                lss_core lss_rt lss_config lss_recording lss_parameters lss_record lss_dictionary lss_dds lss_runtime
                lss_kit lss_replay lss_daemon_program lss_sim_frame lss_sim_program lss_lc_explorer lss_lc_program
                lss_allocations
        EXPORT lssd COMPONENT dev
        ARCHIVE DESTINATION ${lss_libdir} OBJECTS DESTINATION ${lss_libdir} INCLUDES DESTINATION ${lss_includedir})
# As Debian's packages: without debug information, which has the paths of the build machine.
install(CODE "file(GLOB_RECURSE files \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${lss_libdir}/*.[ao]\")
execute_process(COMMAND \"${CMAKE_STRIP}\" --strip-debug \${files} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT dev)
install(EXPORT lssd NAMESPACE lssd:: FILE lssd-targets.cmake DESTINATION ${lss_cmakedir} COMPONENT dev)

list(TRANSFORM LSS_ROSTER REPLACE "(.+)" "PATTERN;\\1;EXCLUDE" OUTPUT_VARIABLE not_ours)
foreach(room daemon drivers idl tools/lss-sim tools/lss-lc tests/safety tests/support)
  install(DIRECTORY ${room}/ DESTINATION ${lss_includedir}/${room} COMPONENT dev
          FILES_MATCHING PATTERN *.h PATTERN *.inc PATTERN vehicles EXCLUDE ${not_ours})
endforeach()
foreach(name lss dictionary)
  install(FILES ${PROJECT_BINARY_DIR}/idl/generated/${name}.h ${PROJECT_BINARY_DIR}/idl/generated/${name}_fields.h
          DESTINATION ${lss_includedir} COMPONENT dev)
endforeach()

# What docs/tutorial-vehicle.md explains.
install(DIRECTORY examples/scout DESTINATION ${CMAKE_INSTALL_DATADIR}/lssd/examples COMPONENT dev PATTERN build EXCLUDE)

# Compiled with a vehicle, since they name it.
foreach(room daemon/app daemon/publish tools/lss-sim tools/lss-lc)
  install(FILES ${room}/roster.cpp DESTINATION ${lss_sources}/${room} COMPONENT dev)
endforeach()
install(FILES daemon/replay/records.cpp DESTINATION ${lss_sources}/daemon/replay COMPONENT dev)

configure_package_config_file(cmake/lssd-config.cmake.in ${PROJECT_BINARY_DIR}/lssd-config.cmake
                              INSTALL_DESTINATION ${lss_cmakedir} PATH_VARS lss_sources)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lssd-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lssd-config.cmake ${PROJECT_BINARY_DIR}/lssd-config-version.cmake
              cmake/lss_target.cmake cmake/lss_vehicle.cmake cmake/lss_add_vehicle.cmake cmake/idl_fields.py cmake/kept_members.py
        DESTINATION ${lss_cmakedir} COMPONENT dev)
