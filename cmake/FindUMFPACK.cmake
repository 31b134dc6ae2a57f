# UMFPACK of SuiteSparse: the imported target SuiteSparse::UMFPACK.
include(${CMAKE_CURRENT_LIST_DIR}/SuiteSparseLibrary.cmake)
suitesparse_library(UMFPACK HEADER umfpack.h LIBRARY umfpack
                    VERSION UMFPACK_MAIN_VERSION UMFPACK_SUB_VERSION UMFPACK_SUBSUB_VERSION
                    NEEDS cholmod amd suitesparseconfig)
