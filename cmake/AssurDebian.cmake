# cpack: a Debian package for each component of the installation. Files in cmake/debian/.
if(ASSUR_WITH_GPL)
  message(FATAL_ERROR "The Debian packages have no parts under the GPL: set ASSUR_WITH_GPL=OFF")
endif()
if(NOT BUILD_SHARED_LIBS OR NOT TARGET assur_python)
  message(FATAL_ERROR "The Debian packages need BUILD_SHARED_LIBS=ON and the Python package, for which "
                      "pybind11-dev, python3-dev and python3-numpy must be installed")
endif()
set(CPACK_PACKAGE_CONTACT "assur maintainers <maintainers@assur.invalid>" CACHE STRING "Maintainer of the packages")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL ${ASSUR_COMPONENTS})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)  # CPACK_COMPONENT_..._DEPENDS become dependencies on the same version
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)

set(folder ${PROJECT_BINARY_DIR}/debian)

# The first line of a description is the synopsis.
set(CPACK_DEBIAN_LIBASSUR_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBASSUR_PACKAGE_CONTROL_EXTRA ${folder}/shlibs ${PROJECT_SOURCE_DIR}/cmake/debian/libassur/triggers)
set(CPACK_DEBIAN_LIBASSUR_DESCRIPTION "motion of multibody mechanisms: shared libraries")
if(LAPACK_OPENBLAS_LIBRARY)  # libassur looks for this build of OpenBLAS first, see FindLAPACK.cmake
  set(CPACK_DEBIAN_LIBASSUR_PACKAGE_DEPENDS libopenblas0-openmp)
endif()

set(CPACK_DEBIAN_LIBASSUR-DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_LIBASSUR-DEV_DEPENDS libassur)
set(CPACK_DEBIAN_LIBASSUR-DEV_PACKAGE_SUGGESTS libeigen3-dev)  # assur/eigen.hpp
set(CPACK_DEBIAN_LIBASSUR-DEV_DESCRIPTION "motion of multibody mechanisms: headers for C++ programs
This package has the headers, and files for CMake and pkg-config.")

set(CPACK_DEBIAN_ASSUR_PACKAGE_SECTION science)
set(CPACK_COMPONENT_ASSUR_DEPENDS libassur)
set(CPACK_DEBIAN_ASSUR_DESCRIPTION "motion of multibody mechanisms: command, samples and documents")

set(CPACK_DEBIAN_PYTHON3-ASSUR_PACKAGE_SECTION python)
set(CPACK_COMPONENT_PYTHON3-ASSUR_DEPENDS libassur)
math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON3-ASSUR_PACKAGE_DEPENDS
  "python3 (>= 3.${Python3_VERSION_MINOR}~), python3 (<< 3.${next_minor}), python3-numpy")
set(CPACK_DEBIAN_PYTHON3-ASSUR_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/cmake/debian/python3-assur/postinst ${PROJECT_SOURCE_DIR}/cmake/debian/python3-assur/prerm)
set(CPACK_DEBIAN_PYTHON3-ASSUR_DESCRIPTION "motion of multibody mechanisms: package for Python 3")

# Files that Debian asks for.
function(assur_gzip file output)
  execute_process(COMMAND gzip -9nc ${file} OUTPUT_FILE ${output} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
configure_file(cmake/debian/libassur/shlibs.in debian/shlibs @ONLY)
configure_file(cmake/debian/changelog.in debian/changelog @ONLY)
configure_file(cmake/debian/assur.1.in debian/assur.1 @ONLY)
assur_gzip(${folder}/changelog ${folder}/changelog.gz)
assur_gzip(${folder}/assur.1 ${folder}/assur.1.gz)
install(FILES ${folder}/assur.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT assur)
install(FILES cmake/debian/libassur/lintian DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME libassur
  COMPONENT libassur)
foreach(package IN LISTS ASSUR_COMPONENTS)
  install(FILES cmake/debian/copyright ${folder}/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
  string(TOUPPER ${package} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${package})
  string(APPEND CPACK_DEBIAN_${key}_DESCRIPTION "
assur computes position, velocity and acceleration of multibody mechanisms
whose drivers prescribe the motion. It chooses the way that it expects to be
the fastest on the machine, and reports how exact the result is.")
endforeach()
include(CPack)
