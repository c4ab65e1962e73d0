# Debian packages: `cpack --config build/release/CPackConfig.cmake` makes five.
#   lssd            daemon, command line, units, users, configuration
#   lss-ground      the pilot's page and its gateway, for the OBC or a base station
#   lss-ros         a vehicle as a ROS 2 node
#   lssd-simulator  lss-sim, for development and test machines
#   liblssd-dev     libraries and lss_add_vehicle(), for vehicles from outside (cmake/dev.cmake)
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
  list(APPEND CPACK_COMPONENTS_ALL ground ros)
endif()

if(LSS_DEV)
  list(APPEND CPACK_COMPONENTS_ALL dev)
endif()

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# iceoryx: RouDi, started by the units; systemd: creates its users.
set(CPACK_DEBIAN_LSSD_PACKAGE_NAME lssd)
set(CPACK_DEBIAN_LSSD_PACKAGE_DEPENDS "iceoryx, systemd, passwd")
set(CPACK_DEBIAN_LSSD_PACKAGE_SUGGESTS "lssd-simulator, can-utils, bash-completion, librsvg2-bin")
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
set(CPACK_DEBIAN_LSS-GROUND_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/systemd/lss-ground/prerm)
set(CPACK_DEBIAN_LSS-GROUND_DESCRIPTION "lss-ground: watch, command and stop the vehicles of lssd from a browser.
A gateway between DDS and WebSocket, and the page that it hands out.")

set(CPACK_DEBIAN_LSS-ROS_PACKAGE_NAME lss-ros)
set(CPACK_DEBIAN_LSS-ROS_PACKAGE_DEPENDS "")
set(CPACK_DEBIAN_LSS-ROS_PACKAGE_SUGGESTS lssd)
set(CPACK_DEBIAN_LSS-ROS_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/systemd/lss-ros/prerm)
set(CPACK_DEBIAN_LSS-ROS_DESCRIPTION "lss-ros: a vehicle of lssd as a ROS 2 node.
It publishes motion, joints, frames and diagnostics, and drives by cmd_vel; no ROS installation is needed.")

# What lssd-config.cmake looks for, and the compiler.
set(CPACK_DEBIAN_LIBLSSD-DEV_PACKAGE_NAME liblssd-dev)
set(CPACK_DEBIAN_LIBLSSD-DEV_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_LIBLSSD-DEV_PACKAGE_DEPENDS
       "cmake (>= 3.25)" g++ python3 cyclonedds-dev cyclonedds-tools libboost-dev libcli11-dev libexpected-dev libfmt-dev
       libspdlog-dev libssl-dev libtomlplusplus-dev nlohmann-json3-dev)
set(CPACK_DEBIAN_LIBLSSD-DEV_PACKAGE_RECOMMENDS "libgtest-dev, libgmock-dev")
set(CPACK_DEBIAN_LIBLSSD-DEV_PACKAGE_SUGGESTS "lssd, lssd-simulator, libdart-dev, libeigen3-dev, librapidcheck-dev")
set(CPACK_DEBIAN_LIBLSSD-DEV_DESCRIPTION "Libraries of lssd, to build a daemon for a vehicle of your own.
Headers, static libraries and the CMake package lssd, whose lss_add_vehicle() makes the daemon, the simulator
and the verification of a vehicle from its sources.")

include(CPack)
cpack_add_component_group(lssd)
cpack_add_component_group(lssd-simulator)
cpack_add_component_group(lss-ground)
cpack_add_component_group(lss-ros)
cpack_add_component_group(liblssd-dev)
cpack_add_component(lssd GROUP lssd)
cpack_add_component(systemd GROUP lssd)
cpack_add_component(simulator GROUP lssd-simulator)
cpack_add_component(ground GROUP lss-ground)
cpack_add_component(ros GROUP lss-ros)
cpack_add_component(dev GROUP liblssd-dev)
