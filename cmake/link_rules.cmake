# Rules for links between targets, checked at every configuration (rules for includes: tools/lib/check_sources.sh).
#
#   gnc/NAME   Eigen, lss_gnc_math and its own targets
#   drivers/   libc and other drivers
#   daemon/    anything but tools; DDS only in daemon/publish
#   tools/     is linked by tools/ and tests/ only

# All targets that the CMakeLists.txt of `directory` and below define.
function(lss_targets_below directory result)
  get_property(all DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(children DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  foreach(child ${children})
    lss_targets_below(${child} below)
    list(APPEND all ${below})
  endforeach()
  set(${result} ${all} PARENT_SCOPE)
endfunction()

# Everything that `target` names in its link line or passes on.
function(lss_direct_links target result)
  get_target_property(type ${target} TYPE)
  get_target_property(passed_on ${target} INTERFACE_LINK_LIBRARIES)
  set(links ${passed_on})
  if(NOT type STREQUAL "INTERFACE_LIBRARY" AND NOT type STREQUAL "UTILITY")
    get_target_property(own ${target} LINK_LIBRARIES)
    list(APPEND links ${own})
  endif()
  list(FILTER links EXCLUDE REGEX "-NOTFOUND$")
  list(REMOVE_DUPLICATES links)
  set(${result} ${links} PARENT_SCOPE)
endfunction()

# lss_only_links(DIRECTORY ALLOWED...): targets below link only each other and the allowed ones.
function(lss_only_links directory)
  lss_targets_below(${PROJECT_SOURCE_DIR}/${directory} targets)
  foreach(target ${targets})
    lss_direct_links(${target} links)
    foreach(link ${links})
      if(NOT link IN_LIST targets AND NOT link IN_LIST ARGN)
        message(SEND_ERROR "link rules: ${target} in ${directory}/ must not link ${link}")
      endif()
    endforeach()
  endforeach()
endfunction()

# lss_never_link(TARGETS FORBIDDEN): two lists; no target of the first links one of the second.
function(lss_never_link targets forbidden)
  foreach(target ${targets})
    lss_direct_links(${target} links)
    foreach(link ${links})
      if(link IN_LIST forbidden)
        message(SEND_ERROR "link rules: ${target} must not link ${link}")
      endif()
    endforeach()
  endforeach()
endfunction()

foreach(name ${LSS_VEHICLES})
  lss_only_links(gnc/${name} Eigen3::Eigen lss_gnc_math)  # only its own vehicle: vehicles never link one another
endforeach()
lss_only_links(drivers)

lss_targets_below(${PROJECT_SOURCE_DIR}/tools lss_tools)
foreach(room idl gnc drivers daemon)
  lss_targets_below(${PROJECT_SOURCE_DIR}/${room} lss_room)
  lss_never_link("${lss_room}" "${lss_tools}")
endforeach()

# The remaining targets in lss_room are the daemon's.
lss_targets_below(${PROJECT_SOURCE_DIR}/daemon/publish lss_face)
list(REMOVE_ITEM lss_room ${lss_face})
list(TRANSFORM LSS_VEHICLES PREPEND lss_idl_ OUTPUT_VARIABLE lss_types)
lss_never_link("${lss_room}" "lss_idl;lss_idl_types;${lss_types};CycloneDDS::ddsc")

find_program(LSS_BASH bash)
if(BUILD_TESTING AND LSS_BASH)
  # [Conf-2]
  add_test(NAME source_rules
           COMMAND ${LSS_BASH} ${PROJECT_SOURCE_DIR}/tools/lib/check_sources.sh ${PROJECT_SOURCE_DIR})
  foreach(rules check_sources link_rules)
    add_test(NAME ${rules}_catches_each_violation
             COMMAND ${LSS_BASH} ${PROJECT_SOURCE_DIR}/tools/lib/${rules}_test.sh)
    set_tests_properties(${rules}_catches_each_violation PROPERTIES LABELS rules TIMEOUT 300)
  endforeach()
  file(GLOB headers ${PROJECT_SOURCE_DIR}/daemon/cycle/supervisor.h ${PROJECT_SOURCE_DIR}/daemon/kit/*.h
                    ${PROJECT_SOURCE_DIR}/daemon/vehicles/*/*.h ${PROJECT_SOURCE_DIR}/examples/*/*.h)
  add_test(NAME kept_members_catches_each_violation
           COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/lib/kept_members_test.py ${headers})
  set_tests_properties(kept_members_catches_each_violation PROPERTIES LABELS rules TIMEOUT 300)
  set_tests_properties(source_rules PROPERTIES LABELS rules TIMEOUT 300)
endif()
