# Debian packages: `cpack --config build/release/CPackConfig.cmake` makes three.
#   lssd            daemon, command line, units, users, configuration
#   lss-ground      the pilot's page and its gateway, for the OBC or a base station
#   lssd-simulator  lss-sim, for development and test machines
# Libraries that they depend on are read from the programs (dpkg-shlibdeps).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME lssd)
set(CPACK_PACKAGE_CONTACT "the maintainers of lssd <lssd@localhost>")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
# Configuration goes to /etc, outside of the prefix.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_ALL lssd systemd)
if(LSS_BUILDS_SIMULATOR)
  list(APPEND CPACK_COMPONENTS_ALL simulator)
endif()
if(NOT LSS_TOOLS_DIR)
  list(APPEND CPACK_COMPONENTS_ALL ground)
endif()

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# iceoryx: RouDi, started by the units; systemd: creates its users.
set(CPACK_DEBIAN_LSSD_PACKAGE_NAME lssd)
set(CPACK_DEBIAN_LSSD_PACKAGE_DEPENDS "iceoryx, systemd, passwd")
set(CPACK_DEBIAN_LSSD_PACKAGE_SUGGESTS "lssd-simulator, can-utils, bash-completion, gnuplot-nox")
set(CPACK_DEBIAN_LSSD_DESCRIPTION "A real-time daemon that moves a walking, a driving or a hopping vehicle, and its command line.
It speaks RS-485 or CAN to the vehicle and DDS to everybody else.")
set(CPACK_DEBIAN_LSSD_PACKAGE_CONTROL_EXTRA "")
foreach(file postinst prerm postrm conffiles)
  list(APPEND CPACK_DEBIAN_LSSD_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/systemd/package/${file})
endforeach()

set(CPACK_DEBIAN_LSSD-SIMULATOR_PACKAGE_NAME lssd-simulator)
set(CPACK_DEBIAN_LSSD-SIMULATOR_PACKAGE_DEPENDS "")
set(CPACK_DEBIAN_LSSD-SIMULATOR_DESCRIPTION "lss-sim: a vehicle as the daemon sees it, serial ports or a CAN bus with the real bytes at the real rate,
and a robot in rigid-body physics behind them.")

set(CPACK_DEBIAN_LSS-GROUND_PACKAGE_NAME lss-ground)
set(CPACK_DEBIAN_LSS-GROUND_PACKAGE_DEPENDS "")
set(CPACK_DEBIAN_LSS-GROUND_PACKAGE_SUGGESTS lssd)
set(CPACK_DEBIAN_LSS-GROUND_DESCRIPTION "lss-ground: watch, command and stop the vehicles of lssd from a browser.
A gateway between DDS and WebSocket, and the page that it hands out.")

include(CPack)
cpack_add_component_group(lssd)
cpack_add_component_group(lssd-simulator)
cpack_add_component_group(lss-ground)
cpack_add_component(lssd GROUP lssd)
cpack_add_component(systemd GROUP lssd)
cpack_add_component(simulator GROUP lssd-simulator)
cpack_add_component(ground GROUP lss-ground)
