# The C library of HDF5: the imported target Hdf5C::Hdf5C. CMake's own module needs a C compiler.
include(FindPackageHandleStandardArgs)

find_path(HDF5C_INCLUDE_DIR H5public.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5C_LIBRARY NAMES hdf5_serial hdf5)
set(Hdf5C_VERSION "")
if(HDF5C_INCLUDE_DIR)
  file(STRINGS ${HDF5C_INCLUDE_DIR}/H5public.h line REGEX "define H5_VERS_INFO ")
  if(line MATCHES "([0-9]+\\.[0-9]+\\.[0-9]+)")
    set(Hdf5C_VERSION ${CMAKE_MATCH_1})
  endif()
endif()
find_package_handle_standard_args(Hdf5C REQUIRED_VARS HDF5C_LIBRARY HDF5C_INCLUDE_DIR VERSION_VAR Hdf5C_VERSION)
mark_as_advanced(HDF5C_INCLUDE_DIR HDF5C_LIBRARY)

if(Hdf5C_FOUND AND NOT TARGET Hdf5C::Hdf5C)
  add_library(Hdf5C::Hdf5C UNKNOWN IMPORTED)
  set_target_properties(Hdf5C::Hdf5C PROPERTIES
    IMPORTED_LOCATION "${HDF5C_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${HDF5C_INCLUDE_DIR}")
endif()
