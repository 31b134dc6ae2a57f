# assur_backend(ID PACKAGE package TARGET target SOURCE files LICENCE spdx DEBIAN name LIBRARIES -l... [OPTION option])
#
# A linear solver of the library `assur`. If the package was found, SOURCE is built and linked. If not, the same
# functions come from lib/backends/absent.cpp.in and name the package to install, so that the table of registry.cpp
# always has the same rows. OPTION names a CMake option; the package is searched only if this option is on.
# absent.cpp.in may use @ASSUR_BACKEND_ID@, @ASSUR_BACKEND_PACKAGE@ and @ASSUR_BACKEND_ADVICE@. LIBRARIES are the
# libraries that pkg-config lists for a static link.
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
