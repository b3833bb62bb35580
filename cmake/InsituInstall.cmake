# Installed package: find_package(insitu), pkg-config insitu.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/insitu)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/insituConfig.cmake.in
  ${PROJECT_BINARY_DIR}/insituConfig.cmake INSTALL_DESTINATION ${package_dir} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/insituConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/insituConfig.cmake ${PROJECT_BINARY_DIR}/insituConfigVersion.cmake
        DESTINATION ${package_dir})
install(EXPORT insituTargets NAMESPACE insitu:: DESTINATION ${package_dir})

# The prefix is told from where the .pc files lie, so that these hold under any prefix given to cmake --install.
set(pc_dir ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_prefix ${pc_dir} ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
file(RELATIVE_PATH pc_libdir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_LIBDIR})
file(RELATIVE_PATH pc_includedir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
file(RELATIVE_PATH pc_datadir ${CMAKE_INSTALL_PREFIX} ${CMAKE_INSTALL_FULL_DATADIR})
foreach(name insitu insitu-fortran)
  if(name STREQUAL "insitu" OR INSITU_HAVE_FORTRAN)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  endif()
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
# The pages, where README.md's links lead to.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/libinsitu/doc DESTINATION ${CMAKE_INSTALL_DOCDIR}/libinsitu
        FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg")
