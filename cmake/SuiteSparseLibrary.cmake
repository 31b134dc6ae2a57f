# SuiteSparse before version 7 has no CMake package, so each library is searched by its header and file name:
#
#   suitesparse_library(CXSparse HEADER cs.h LIBRARY cxsparse VERSION CS_VER CS_SUBVER NEEDS suitesparseconfig)
#
# makes the imported target SuiteSparse::CXSparse and the variables CXSparse_FOUND and CXSparse_VERSION. VERSION: macros
# of the header with the parts of the version. NEEDS: other libraries that this library calls.
include(FindPackageHandleStandardArgs)

macro(suitesparse_library name)
  cmake_parse_arguments(arg "" "HEADER;LIBRARY" "VERSION;NEEDS" ${ARGN})

  find_path(${name}_INCLUDE_DIR ${arg_HEADER} PATH_SUFFIXES suitesparse)
  find_library(${name}_LIBRARY ${arg_LIBRARY})
  set(${name}_libraries ${${name}_LIBRARY})
  foreach(needed IN LISTS arg_NEEDS)
    find_library(SUITESPARSE_${needed}_LIBRARY ${needed})
    mark_as_advanced(SUITESPARSE_${needed}_LIBRARY)
    list(APPEND ${name}_libraries ${SUITESPARSE_${needed}_LIBRARY})
  endforeach()

  set(${name}_VERSION "")
  if(${name}_INCLUDE_DIR)
    foreach(part IN LISTS arg_VERSION)
      file(STRINGS ${${name}_INCLUDE_DIR}/${arg_HEADER} line REGEX "define ${part} +[0-9]+")
      if(line MATCHES "define ${part} +([0-9]+)")
        list(APPEND ${name}_VERSION ${CMAKE_MATCH_1})
      endif()
    endforeach()
    list(JOIN ${name}_VERSION "." ${name}_VERSION)
  endif()

  list(TRANSFORM arg_NEEDS REPLACE "(.+)" "SUITESPARSE_\\1_LIBRARY" OUTPUT_VARIABLE needed_variables)
  find_package_handle_standard_args(${name} REQUIRED_VARS ${name}_LIBRARY ${name}_INCLUDE_DIR ${needed_variables}
                                    VERSION_VAR ${name}_VERSION)
  mark_as_advanced(${name}_INCLUDE_DIR ${name}_LIBRARY)

  if(${name}_FOUND AND NOT TARGET SuiteSparse::${name})
    list(POP_FRONT ${name}_libraries)
    add_library(SuiteSparse::${name} UNKNOWN IMPORTED)
    set_target_properties(SuiteSparse::${name} PROPERTIES
      IMPORTED_LOCATION "${${name}_LIBRARY}"
      INTERFACE_INCLUDE_DIRECTORIES "${${name}_INCLUDE_DIR}"
      INTERFACE_LINK_LIBRARIES "${${name}_libraries}")
  endif()
endmacro()
