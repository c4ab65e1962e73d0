# Cross-compiles for Debian's arm64 (preset arm64, tools/package): crossbuild-essential-arm64, and Debian's multiarch
# libraries of arm64 beside those of this machine; idlc, npm, Python and CMake are this machine's.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
find_program(LSS_ARM64_CXX ${triplet}-g++)
if(NOT LSS_ARM64_CXX)
  message(FATAL_ERROR "${triplet}-g++ is not installed. tools/package --arch arm64 builds in a Debian root of its own, which "
                      "has it; or, on this system: apt-get install crossbuild-essential-arm64 and the libraries of "
                      "tools/packages.txt for arm64 (dpkg --add-architecture arm64).")
endif()
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/${triplet}/pkgconfig:/usr/share/pkgconfig)
# Programs that the build executes are this machine's; so are headers and CMake files that do not depend on the processor.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_IGNORE_PATH /usr/lib/x86_64-linux-gnu /lib/x86_64-linux-gnu)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
# Tests run by emulation, if at all.
find_program(LSS_QEMU qemu-aarch64-static)
if(LSS_QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${LSS_QEMU})
endif()
