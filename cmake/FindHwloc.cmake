# hwloc: the imported target Hwloc::hwloc.
include(FindPackageHandleStandardArgs)

find_path(HWLOC_INCLUDE_DIR hwloc.h)
find_library(HWLOC_LIBRARY hwloc)
find_path(HWLOC_CONFIG_DIR hwloc/autogen/config.h)  # on Debian in a separate folder
set(Hwloc_VERSION "")
if(HWLOC_CONFIG_DIR)
  file(STRINGS ${HWLOC_CONFIG_DIR}/hwloc/autogen/config.h line REGEX "define HWLOC_VERSION +\"")
  if(line MATCHES "\"([0-9.]+)")
    set(Hwloc_VERSION ${CMAKE_MATCH_1})
  endif()
endif()
find_package_handle_standard_args(Hwloc REQUIRED_VARS HWLOC_LIBRARY HWLOC_INCLUDE_DIR VERSION_VAR Hwloc_VERSION)
mark_as_advanced(HWLOC_INCLUDE_DIR HWLOC_CONFIG_DIR HWLOC_LIBRARY)

if(Hwloc_FOUND AND NOT TARGET Hwloc::hwloc)
  add_library(Hwloc::hwloc UNKNOWN IMPORTED)
  set_target_properties(Hwloc::hwloc PROPERTIES
    IMPORTED_LOCATION "${HWLOC_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${HWLOC_INCLUDE_DIR}")
endif()
