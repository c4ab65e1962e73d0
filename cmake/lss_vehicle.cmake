# What a vehicle in this tree and a vehicle from outside (lss_add_vehicle.cmake) are made with.

find_program(IDLC idlc REQUIRED)
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
set(LSS_IDL_FIELDS ${CMAKE_CURRENT_LIST_DIR}/idl_fields.py)

# lss_idl_library(NAME FILE.idl...): the library of the types, with <FILE.h> and <FILE_fields.h> made when NAME_headers is.
function(lss_idl_library name)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/generated)
  file(MAKE_DIRECTORY ${generated})
  foreach(idl ${ARGN})
    get_filename_component(stem ${idl} NAME_WE)
    get_filename_component(idl ${idl} ABSOLUTE)
    set(made ${generated}/${stem})
    # Without the paths of this machine: headers are installed.
    add_custom_command(OUTPUT ${made}.c ${made}.h
                       COMMAND ${IDLC} -l c ${idl} COMMAND sed -i "/^  Source: /d" ${stem}.c ${stem}.h
                       DEPENDS ${idl} WORKING_DIRECTORY ${generated} VERBATIM COMMENT "idlc ${stem}.idl")
    add_custom_command(OUTPUT ${made}_fields.h COMMAND Python3::Interpreter ${LSS_IDL_FIELDS} ${idl} ${made}_fields.h
                       DEPENDS ${idl} ${LSS_IDL_FIELDS} VERBATIM COMMENT "fields of ${stem}.idl")
    list(APPEND sources ${made}.c)
    list(APPEND headers ${made}.h ${made}_fields.h)
  endforeach()
  add_custom_target(${name}_headers DEPENDS ${headers})
  add_library(${name} STATIC ${sources})
  set_target_properties(${name} PROPERTIES C_EXTENSIONS ON)
  target_include_directories(${name} SYSTEM PUBLIC $<BUILD_INTERFACE:${generated}>)
  target_link_libraries(${name} PUBLIC CycloneDDS::ddsc)
  add_dependencies(${name} ${name}_headers)
endfunction()

# lss_kept_members(TARGET HEADER...): it is not built while a class forgets one of its members in keep(v).
set(LSS_KEPT_MEMBERS ${CMAKE_CURRENT_LIST_DIR}/kept_members.py)
function(lss_kept_members target)
  set(stamp ${CMAKE_CURRENT_BINARY_DIR}/${target}_kept_members.stamp)
  add_custom_command(OUTPUT ${stamp} COMMAND Python3::Interpreter ${LSS_KEPT_MEMBERS} ${stamp} ${ARGN}
                     DEPENDS ${ARGN} ${LSS_KEPT_MEMBERS} VERBATIM COMMENT "members in keep(v) of ${target}")
  target_sources(${target} PRIVATE ${stamp})
endfunction()

# The struct of a vehicle's telemetry is named after it: lss::ZebroTelemetry of zebro.
function(lss_type_name name result)
  string(SUBSTRING ${name} 0 1 initial)
  string(SUBSTRING ${name} 1 -1 rest)
  string(TOUPPER ${initial} initial)
  set(${result} ${initial}${rest} PARENT_SCOPE)
endfunction()

# lss_roster(FOLDER NAME...): the vehicles of programs that include FOLDER, as LSS_VEHICLE(name, Name), and their types.
function(lss_roster folder)
  set(types "#pragma once\n")
  set(roster "")
  foreach(name ${ARGN})
    lss_type_name(${name} type)
    string(APPEND roster "LSS_VEHICLE(${name}, ${type})\n")
    string(APPEND types "#include <${name}.h>\n")
  endforeach()
  file(CONFIGURE OUTPUT ${folder}/roster.inc CONTENT "${roster}" @ONLY)
  file(CONFIGURE OUTPUT ${folder}/roster_types.h CONTENT "${types}" @ONLY)
endfunction()
