# CXSparse of SuiteSparse: the imported target SuiteSparse::CXSparse.
include(${CMAKE_CURRENT_LIST_DIR}/SuiteSparseLibrary.cmake)
suitesparse_library(CXSparse HEADER cs.h LIBRARY cxsparse VERSION CS_VER CS_SUBVER CS_SUBSUB NEEDS suitesparseconfig)
