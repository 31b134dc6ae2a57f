# BTF of SuiteSparse: the imported target SuiteSparse::BTF.
include(${CMAKE_CURRENT_LIST_DIR}/SuiteSparseLibrary.cmake)
suitesparse_library(BTF HEADER btf.h LIBRARY btf VERSION BTF_MAIN_VERSION BTF_SUB_VERSION BTF_SUBSUB_VERSION
                    NEEDS suitesparseconfig)
