# The target `docs`: the API reference of include/, with README.md and docs/ as its pages, in docs/html of the build.
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
  assur_note("  without  Doxygen: the target docs, an API reference (Debian: apt install doxygen)")
  return()
endif()
assur_note("  found    Doxygen ${DOXYGEN_VERSION}: the target docs, an API reference")

set(DOXYGEN_PROJECT_NAME assur)
set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/docs)
set(DOXYGEN_USE_MDFILE_AS_MAINPAGE ${PROJECT_SOURCE_DIR}/README.md)
set(DOXYGEN_STRIP_FROM_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_STRIP_FROM_INC_PATH ${PROJECT_SOURCE_DIR}/include)
set(DOXYGEN_IMAGE_PATH ${PROJECT_SOURCE_DIR}/docs/pictures)
set(DOXYGEN_INPUT_FILTER "awk -f ${PROJECT_SOURCE_DIR}/cmake/doxygen_comments.awk")
set(DOXYGEN_JAVADOC_AUTOBRIEF YES)        # the first sentence of a comment is the short description
set(DOXYGEN_EXTRACT_STATIC YES)
set(DOXYGEN_TOC_INCLUDE_HEADINGS 2)
set(DOXYGEN_SORT_MEMBER_DOCS NO)          # in the order of the header
set(DOXYGEN_HIDE_FRIEND_COMPOUNDS YES)
set(DOXYGEN_GENERATE_LATEX NO)
set(DOXYGEN_GENERATE_TREEVIEW YES)
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_QUIET YES)
set(DOXYGEN_WARN_IF_UNDOCUMENTED YES)
set(DOXYGEN_WARN_NO_PARAMDOC NO)
set(DOXYGEN_WARN_LOGFILE ${PROJECT_BINARY_DIR}/docs/warnings.txt)
file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.md)
list(APPEND pages ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md
  ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/bench/README.md ${PROJECT_SOURCE_DIR}/db/README.md)
doxygen_add_docs(docs ${PROJECT_SOURCE_DIR}/include ${pages}
  COMMENT "Writing the API reference into docs/html")
