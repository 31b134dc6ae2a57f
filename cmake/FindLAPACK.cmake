# LAPACK with BLAS: the target LAPACK::LAPACK. Takes the OpenMP build of OpenBLAS from its place on Debian. If it is
# absent, or if BLA_VENDOR, BLAS_LIBRARIES or LAPACK_LIBRARIES ask for another library, takes the result of CMake's own
# module. LAPACK_LINK_FLAGS are the flags for a linker that is called by hand.
#
# Debian's builds of OpenBLAS have the same soname. If several are installed, the loader takes the build that
# update-alternatives selects: by default the build for pthreads, whose number of threads cannot be set for each caller.
# Programs and libraries that link this target therefore have the folder of the OpenMP build in their RUNPATH, which the
# loader searches first.
include(FindPackageHandleStandardArgs)

if(NOT BLA_VENDOR AND NOT BLAS_LIBRARIES AND NOT LAPACK_LIBRARIES AND NOT TARGET LAPACK::LAPACK)
  find_library(LAPACK_OPENBLAS_LIBRARY openblas NO_DEFAULT_PATH
               PATHS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/openblas-openmp)
  mark_as_advanced(LAPACK_OPENBLAS_LIBRARY)
endif()

if(LAPACK_OPENBLAS_LIBRARY)
  get_filename_component(lapack_folder ${LAPACK_OPENBLAS_LIBRARY} DIRECTORY)
  file(REAL_PATH ${LAPACK_OPENBLAS_LIBRARY} lapack_file)
  string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" LAPACK_VERSION ${lapack_file})
  find_package_handle_standard_args(LAPACK REQUIRED_VARS LAPACK_OPENBLAS_LIBRARY VERSION_VAR LAPACK_VERSION)
  add_library(LAPACK::LAPACK UNKNOWN IMPORTED)
  set_target_properties(LAPACK::LAPACK PROPERTIES
    IMPORTED_LOCATION ${LAPACK_OPENBLAS_LIBRARY}
    INTERFACE_LINK_OPTIONS LINKER:-rpath,${lapack_folder})
  set(LAPACK_LINK_FLAGS -L${lapack_folder} -Wl,-rpath,${lapack_folder} -lopenblas)
else()
  include(${CMAKE_ROOT}/Modules/FindLAPACK.cmake)
  set(LAPACK_LINK_FLAGS ${LAPACK_LIBRARIES} ${BLAS_LIBRARIES})
endif()
