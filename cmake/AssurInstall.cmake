# cmake --install: libraries, headers, the command, and packages for CMake and pkg-config.
include(CMakePackageConfigHelpers)

get_property(ASSUR_PACKAGES GLOBAL PROPERTY ASSUR_FOUND_PACKAGES)
set(ASSUR_TINYXML2 "")
if(tinyxml2_FOUND)
  set(ASSUR_TINYXML2 tinyxml2)  # it has a package of its own
endif()
get_property(ASSUR_LIBRARIES GLOBAL PROPERTY ASSUR_PRIVATE_LIBRARIES)
set(ASSUR_ASMJIT "")
if(asmjit_FOUND)
  set(ASSUR_ASMJIT asmjit)
endif()
list(REMOVE_DUPLICATES ASSUR_PACKAGES)
list(REMOVE_DUPLICATES ASSUR_LIBRARIES)
list(JOIN ASSUR_LIBRARIES " " ASSUR_LIBRARIES)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME libassur-dev)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/assur)
set(shared_library LIBRARY COMPONENT libassur NAMELINK_COMPONENT libassur-dev)
install(TARGETS assur_core EXPORT assurCoreTargets ${shared_library} FILE_SET HEADERS FILE_SET eigen)
install(TARGETS assur EXPORT assurTargets ${shared_library})
install(EXPORT assurCoreTargets NAMESPACE assur:: DESTINATION ${package_folder})
install(EXPORT assurTargets NAMESPACE assur:: DESTINATION ${package_folder})

configure_package_config_file(cmake/assurConfig.cmake.in assurConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(assurConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/assurConfig.cmake ${PROJECT_BINARY_DIR}/assurConfigVersion.cmake
  DESTINATION ${package_folder})
if(NOT BUILD_SHARED_LIBS)
  # Users of a static assur must also link the libraries that it uses.
  list(TRANSFORM ASSUR_PACKAGES REPLACE "(.+)" "cmake/Find\\1.cmake" OUTPUT_VARIABLE find_modules)
  install(FILES ${find_modules} cmake/SuiteSparseLibrary.cmake DESTINATION ${package_folder})
  set(ASSUR_CORE_REQUIRES libhwy)
  set(ASSUR_REQUIRES muparser)
  set(ASSUR_CORE_LIBRARIES "${CMAKE_THREAD_LIBS_INIT} -lstdc++ -lm")  # also for programs in C and Fortran
else()
  set(ASSUR_LIBRARIES "")
endif()

# pkg-config files that remain valid if the installed tree is moved.
file(RELATIVE_PATH ASSUR_PREFIX_FROM_PC /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
string(REGEX REPLACE "/$" "" ASSUR_PREFIX_FROM_PC ${ASSUR_PREFIX_FROM_PC})
foreach(name IN ITEMS assur_core assur)
  configure_file(cmake/${name}.pc.in ${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME assur)
install(TARGETS assur_command)
if(TARGET assur_hdf5)
  install(TARGETS assur_hdf5 LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/assur)
endif()

# What is installed, and no more.
add_custom_target(assur_installed DEPENDS assur_core assur assur_command)
if(TARGET assur_python)
  add_dependencies(assur_installed assur_python)
endif()

# Files to which README.md refers are installed beside it, as in the sources.
install(FILES README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
if(NOT ASSUR_DEBIAN)  # Debian has the text for all packages in one place
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
endif()
install(FILES db/README.md db/schema.sql DESTINATION ${CMAKE_INSTALL_DOCDIR}/db)
install(FILES bench/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/bench)
install(FILES bench/peers/peers.csv DESTINATION ${CMAKE_INSTALL_DOCDIR}/bench/peers)
install(DIRECTORY scenes examples DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN *.py EXCLUDE)

configure_file(cmake/tune_on_install.cmake.in tune_on_install.cmake.in @ONLY)
file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/tune_on_install.cmake INPUT ${PROJECT_BINARY_DIR}/tune_on_install.cmake.in)
if(ASSUR_TUNE_ON_INSTALL)
  install(SCRIPT ${PROJECT_BINARY_DIR}/tune_on_install.cmake)
endif()
