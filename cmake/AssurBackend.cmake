# assur_backend(ID PACKAGE package TARGET target SOURCE file LICENCE spdx DEBIAN name LIBRARIES -l... )
#
# A linear solver of the library `assur`. Where the package was found, SOURCE is built and linked; where not, the same
# functions come from lib/backends/absent.cpp.in and say what to install. Either way the table of registry.cpp has the
# same rows. absent.cpp.in may use @ASSUR_BACKEND_ID@, @ASSUR_BACKEND_PACKAGE@, @ASSUR_BACKEND_DEBIAN@ and
# @ASSUR_BACKEND_LICENCE@. LIBRARIES is what a static link needs, for pkg-config.
function(assur_backend id)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE;TARGET;SOURCE;LICENCE;DEBIAN" "LIBRARIES")
  if(${arg_PACKAGE}_FOUND)
    target_sources(assur PRIVATE ${arg_SOURCE})
    target_link_libraries(assur PRIVATE ${arg_TARGET})
    set_property(GLOBAL APPEND PROPERTY ASSUR_FOUND_PACKAGES ${arg_PACKAGE})
    set_property(GLOBAL APPEND PROPERTY ASSUR_PRIVATE_LIBRARIES ${arg_LIBRARIES})
  else()
    set(ASSUR_BACKEND_ID ${id})
    set(ASSUR_BACKEND_PACKAGE ${arg_PACKAGE})
    set(ASSUR_BACKEND_DEBIAN ${arg_DEBIAN})
    set(ASSUR_BACKEND_LICENCE ${arg_LICENCE})
    configure_file(backends/absent.cpp.in backends/${id}_absent.cpp @ONLY)
    target_sources(assur PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/backends/${id}_absent.cpp)
  endif()
endfunction()
