# Cross compilation by Debian's compilers, tests under qemu-user: presets arm64 and armhf. ASSUR_TRIPLE names the machine,
# ASSUR_PACKAGES the folder in which .ci/arm has unpacked the libraries for it.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ASSUR_TRIPLE ASSUR_PACKAGES)
set(CMAKE_SYSTEM_NAME Linux)
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR ${ASSUR_TRIPLE})
set(CMAKE_C_COMPILER ${ASSUR_TRIPLE}-gcc)
set(CMAKE_CXX_COMPILER ${ASSUR_TRIPLE}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${ASSUR_TRIPLE})
set(CMAKE_FIND_ROOT_PATH ${ASSUR_PACKAGES} /usr/${ASSUR_TRIPLE})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind IN ITEMS LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
# The libraries of the C++ compiler, and those of the packages.
set(libraries ${ASSUR_PACKAGES}/usr/lib/${ASSUR_TRIPLE})
set(CMAKE_EXE_LINKER_FLAGS_INIT -Wl,-rpath-link,${libraries})
set(CMAKE_CROSSCOMPILING_EMULATOR
  qemu-${CMAKE_SYSTEM_PROCESSOR} -L /usr/${ASSUR_TRIPLE} -E LD_LIBRARY_PATH=/usr/${ASSUR_TRIPLE}/lib:${libraries})
