# The summary of CMake tells packages that can be used from those that are too old, incomplete, switched off or absent.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${OUT})

# A package whose version file accepts its own major version only, as that of tinyxml2 does.
function(make_package name version content)
  file(WRITE ${OUT}/prefix/lib/cmake/${name}/${name}Config.cmake "${content}")
  string(REGEX MATCH "^[0-9]+" major ${version})
  file(WRITE ${OUT}/prefix/lib/cmake/${name}/${name}ConfigVersion.cmake "
set(PACKAGE_VERSION ${version})
if(NOT PACKAGE_FIND_VERSION OR PACKAGE_FIND_VERSION MATCHES \"^${major}[.]\")
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
")
endfunction()
make_package(newer 11.0.0 "")
make_package(older 8.4.0 "")
make_package(broken 9.1.0 "set(broken_FOUND FALSE)\nset(broken_NOT_FOUND_MESSAGE \"it needs\n  another package\")\n")
make_package(unwanted 9.1.0 "")
file(WRITE ${OUT}/prefix/include/half.h "")
file(WRITE ${OUT}/modules/FindHalf.cmake "
find_path(HALF_INCLUDE_DIR half.h)
find_library(HALF_LIBRARY half_of_it)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Half REQUIRED_VARS HALF_LIBRARY HALF_INCLUDE_DIR)
")
file(WRITE ${OUT}/CMakeLists.txt [=[
cmake_minimum_required(VERSION 3.25)
project(packages VERSION 1 LANGUAGES NONE)
include(AssurPackage)
foreach(name IN ITEMS newer older broken unwanted Half absent)
  assur_package(${name} optional DEBIAN lib${name}-dev FOR "test" VERSION 9.0)
  if(${name}_FOUND)
    file(APPEND ${PROJECT_BINARY_DIR}/found ${name})
  endif()
endforeach()
assur_package(older required DEBIAN libolder-dev FOR "test" VERSION 8.4 CONFIG)
assur_package(older required DEBIAN libolder-dev FOR "test" VERSION 8.4.1 CONFIG)
assur_summary()
]=])
execute_process(COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${OUT} -B ${OUT}/build -D CMAKE_PREFIX_PATH=${OUT}/prefix
  "-DCMAKE_MODULE_PATH=${SOURCE}/cmake;${OUT}/modules" -D CMAKE_DISABLE_FIND_PACKAGE_unwanted=ON
  OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)

set(broken ${OUT}/prefix/lib/cmake/broken/brokenConfig.cmake)
foreach(line IN ITEMS
    "found    newer 11.0.0: test\n"
    "without  older: test (version 8.4.0 was found, 9.0 or later is needed)\n"
    "without  broken: test (${broken} was found, but cannot be used. it needs another package)\n"
    "without  unwanted: test (switched off by CMAKE_DISABLE_FIND_PACKAGE_unwanted)\n"
    "without  Half: test (${OUT}/prefix/include was found, but nothing for HALF_LIBRARY)\n"
    "without  absent: test (Debian: apt install libabsent-dev)\n"
    "found    older 8.4.0: test\n"
    "MISSING  older: test (version 8.4.0 was found, 8.4.1 or later is needed)\n")
  string(FIND "${out}" "  ${line}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "the summary lacks\n  ${line}\n${out}")
  endif()
endforeach()
file(READ ${OUT}/build/found found)
if(NOT "${found}" STREQUAL "newer")
  message(FATAL_ERROR "found: ${found}")
endif()
