# MUMPS, sequential version, double precision: the imported target MUMPS::sequential.
include(FindPackageHandleStandardArgs)

find_path(MUMPS_INCLUDE_DIR dmumps_c.h)
find_library(MUMPS_LIBRARY dmumps_seq)
set(MUMPS_VERSION "")
if(MUMPS_INCLUDE_DIR)
  file(STRINGS ${MUMPS_INCLUDE_DIR}/dmumps_c.h line REGEX "define MUMPS_VERSION +\"")
  if(line MATCHES "\"([0-9.]+)\"")
    set(MUMPS_VERSION ${CMAKE_MATCH_1})
  endif()
endif()
find_package_handle_standard_args(MUMPS REQUIRED_VARS MUMPS_LIBRARY MUMPS_INCLUDE_DIR VERSION_VAR MUMPS_VERSION)
mark_as_advanced(MUMPS_INCLUDE_DIR MUMPS_LIBRARY)

if(MUMPS_FOUND AND NOT TARGET MUMPS::sequential)
  add_library(MUMPS::sequential UNKNOWN IMPORTED)
  set_target_properties(MUMPS::sequential PROPERTIES
    IMPORTED_LOCATION "${MUMPS_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MUMPS_INCLUDE_DIR}")
endif()
