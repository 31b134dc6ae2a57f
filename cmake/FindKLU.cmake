# KLU of SuiteSparse: the imported target SuiteSparse::KLU.
include(${CMAKE_CURRENT_LIST_DIR}/SuiteSparseLibrary.cmake)
suitesparse_library(KLU HEADER klu.h LIBRARY klu VERSION KLU_MAIN_VERSION KLU_SUB_VERSION KLU_SUBSUB_VERSION
                    NEEDS btf amd colamd suitesparseconfig)
