# assur_backend(ID PACKAGE package TARGET target SOURCE files LICENCE spdx DEBIAN name LIBRARIES -l... [OPTION option])
#
# A linear solver of the library `assur`. Where the package was found, SOURCE is built and linked; where not, the same
# functions come from lib/backends/absent.cpp.in and say what to install. Either way the table of registry.cpp has the
# same rows. OPTION names the option that must be on for the package to be looked for at all. absent.cpp.in may use
# @ASSUR_BACKEND_ID@, @ASSUR_BACKEND_PACKAGE@ and @ASSUR_BACKEND_ADVICE@. LIBRARIES is what a static link needs, for
# pkg-config.
function(assur_backend id)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE;TARGET;LICENCE;DEBIAN;OPTION" "SOURCE;LIBRARIES")
  set(wanted ON)
  if(arg_OPTION)
    set(wanted ${${arg_OPTION}})
  endif()
  if(${arg_PACKAGE}_FOUND AND wanted)
    target_sources(assur PRIVATE ${arg_SOURCE})
    target_link_libraries(assur PRIVATE ${arg_TARGET})
    set_property(GLOBAL APPEND PROPERTY ASSUR_FOUND_PACKAGES ${arg_PACKAGE})
    set_property(GLOBAL APPEND PROPERTY ASSUR_PRIVATE_LIBRARIES ${arg_LIBRARIES})
  else()
    set(ASSUR_BACKEND_ID ${id})
    set(ASSUR_BACKEND_PACKAGE ${arg_PACKAGE})
    set(ASSUR_BACKEND_ADVICE "install the Debian package ${arg_DEBIAN} and build assur again")
    if(arg_OPTION)
      set(ASSUR_BACKEND_PACKAGE "${arg_PACKAGE}, which is under ${arg_LICENCE}")
      string(APPEND ASSUR_BACKEND_ADVICE " with -D ${arg_OPTION}=ON")
    endif()
    configure_file(backends/absent.cpp.in backends/${id}_absent.cpp @ONLY)
    target_sources(assur PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/backends/${id}_absent.cpp)
  endif()
endfunction()
